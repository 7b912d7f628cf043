//! What a school does all day: uploads whole and in pieces, sign-ins, pages, comments, new people who are mailed, scores by the rubric of
//! today.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::SeqCst;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use anyhow::{Context, bail, ensure};
use serde_json::Value;
use tests::dice::Dice;

use crate::client::{Answer, Client, Proxy, Request};
use crate::ledger::{Act, Entry, Ledger};
use crate::school::{PASSWORD, SPEED_MM_S, School};

/// Bytes of a piece of an upload.
const PIECE: usize = 200_000;
/// Acts from one sign-in to the next: somebody who signs in more often than every half minute is held up, whoever serves.
const ACTS_SIGNED_IN: usize = 120;
/// Longest pause between two acts of somebody, in ms.
const LONGEST_PAUSE_MS: u64 = 400;

/// Everybody who uses the school.
#[derive(Debug)]
pub struct Load {
    over: Arc<AtomicBool>,
    working: Vec<JoinHandle<anyhow::Result<()>>>,
}

/// Somebody at work.
struct Visitor {
    school: Arc<School>,
    ledger: Arc<Ledger>,
    over: Arc<AtomicBool>,
    client: Client,
    dice: Dice,
    name: String,
}

impl Load {
    /// Adds so many trainees, as many teachers as half of them, and one administrator, and has them begin.
    pub fn begin(
        school: &Arc<School>,
        proxy: &Arc<Proxy>,
        ledger: &Arc<Ledger>,
        trainees: usize,
    ) -> anyhow::Result<Self> {
        let over = Arc::new(AtomicBool::new(false));
        let mut visitors = Vec::new();
        for number in 0..trainees + trainees.div_ceil(2) + 1 {
            let (role, work): (_, fn(&mut Visitor) -> anyhow::Result<()>) = match number {
                n if n < trainees => ("trainee", upload_on),
                n if n < trainees + trainees.div_ceil(2) => ("instructor", teach_on),
                _ => ("administrator", administer_on),
            };
            let name = format!("{role}-{number}");
            let mut client = Client::new(proxy, ledger, number);
            client.token = Some(school.add_person(role, &format!("{name}@example.org"))?);
            let (school, ledger, over) = (Arc::clone(school), Arc::clone(ledger), Arc::clone(&over));
            visitors.push((Visitor { school, ledger, over, client, dice: Dice::new(number as u64 + 77), name }, work));
        }
        // As if everybody had signed in before and had chosen this password.
        school.query("UPDATE people SET password_initial_until = NULL")?;
        let begin = |(mut visitor, work): (Visitor, fn(&mut Visitor) -> anyhow::Result<()>)| {
            thread::spawn(move || work(&mut visitor).with_context(|| visitor.name.clone()))
        };
        Ok(Self { over, working: visitors.into_iter().map(begin).collect() })
    }

    /// Fails where somebody could not go on.
    pub fn look_after(&mut self) -> anyhow::Result<()> {
        if let Some(ended) = self.working.extract_if(.., |worker| worker.is_finished()).next() {
            ended.join().map_err(|_| anyhow::anyhow!("a client has panicked"))??;
            bail!("a client has ended before it was told to");
        }
        Ok(())
    }

    /// Has everybody finish what they do.
    pub fn end(self) -> anyhow::Result<()> {
        self.over.store(true, SeqCst);
        for worker in self.working {
            worker.join().map_err(|_| anyhow::anyhow!("a client has panicked"))??;
        }
        Ok(())
    }
}

impl Visitor {
    fn goes_on(&mut self) -> bool {
        thread::sleep(Duration::from_millis(self.dice.below(LONGEST_PAUSE_MS)));
        !self.over.load(SeqCst)
    }

    fn entry(&self, mark: &str, session: &str) -> Entry {
        let token = self.client.token.clone().unwrap_or_default();
        Entry { mark: mark.to_owned(), session: session.to_owned(), token, acknowledged: false, unheard: 0 }
    }

    /// A session of this school that is scored.
    fn draw_scored(&mut self) -> anyhow::Result<Option<String>> {
        let listed = self.client.get("list", "/api/v1/sessions?limit=100")?;
        let list: Value = serde_json::from_slice(&listed.body)?;
        let scored = list["sessions"].as_array().into_iter().flatten().filter(|session| session["state"] == "scored");
        let ids: Vec<&str> = scored.filter_map(|session| session["session_id"].as_str()).collect();
        let drawn = self.dice.below(ids.len() as u64) as usize;
        Ok(ids.get(drawn).map(|id| (*id).to_owned()))
    }
}

/// Fails where an answer is not as it must be.
fn expect(answer: &Answer, allowed: &[u16], what: &str) -> anyhow::Result<()> {
    ensure!(allowed.contains(&answer.status), "{what}: {} {}", answer.status, answer.text());
    Ok(())
}

fn upload_on(visitor: &mut Visitor) -> anyhow::Result<()> {
    while visitor.goes_on() {
        if visitor.dice.happens(50) { upload_whole(visitor)? } else { upload_in_pieces(visitor)? }
    }
    Ok(())
}

fn upload_whole(visitor: &mut Visitor) -> anyhow::Result<()> {
    let recorded = visitor.school.record(SPEED_MM_S)?;
    let mut entry = visitor.entry(&recorded.sha256, &recorded.session);
    visitor.ledger.note(Act::Upload, &entry);
    let headers = vec![("content-type", "application/octet-stream".to_owned())];
    let path = "/api/v1/sessions";
    let request = Request { what: "upload", method: "POST", path, headers, body: &recorded.bytes, repeatable: true };
    let answer = visitor.client.ask(&request)?.context("an upload may be sent again")?;
    expect(&answer, &[200, 201], "an upload")?;
    entry.acknowledged = true;
    visitor.ledger.note(Act::Upload, &entry);
    Ok(())
}

fn tus(method: &'static str, what: &'static str) -> Request<'static> {
    let headers = vec![("tus-resumable", "1.0.0".to_owned())];
    Request { what, method, path: "/api/v1/uploads", headers, body: &[], repeatable: true }
}

/// Sends a recording by tus; a piece of which nobody knows what has become goes on from where the service stands.
fn upload_in_pieces(visitor: &mut Visitor) -> anyhow::Result<()> {
    let recorded = visitor.school.record(SPEED_MM_S)?;
    let mut entry = visitor.entry(&recorded.sha256, &recorded.session);
    visitor.ledger.note(Act::UploadInPieces, &entry);
    let mut begin = tus("POST", "begin upload");
    begin.headers.push(("upload-length", recorded.bytes.len().to_string()));
    // One that was begun unheard stays unfinished, and expires.
    let begun = visitor.client.ask(&begin)?.context("an upload may be begun again")?;
    expect(&begun, &[201], "the begin of an upload")?;
    let path = begun.header("location").to_owned();
    let (mut offset, mut session) = (0, String::new());
    while session.is_empty() {
        let end = (offset + PIECE).min(recorded.bytes.len());
        let mut piece =
            Request { path: &path, body: &recorded.bytes[offset..end], repeatable: false, ..tus("PATCH", "piece") };
        piece.headers.push(("content-type", "application/offset+octet-stream".to_owned()));
        piece.headers.push(("upload-offset", offset.to_string()));
        let sent = visitor.client.ask(&piece)?.filter(|answer| answer.status != 409);
        let answer = match sent {
            Some(answer) => answer,
            // The connection broke, or the piece had arrived before: the service knows.
            None => visitor.client.ask(&Request { path: &path, ..tus("HEAD", "offset") })?.context("it only reads")?,
        };
        expect(&answer, &[200, 204], "a piece")?;
        offset = answer.header("upload-offset").parse().context("Upload-Offset")?;
        answer.header("stylet-session").clone_into(&mut session);
        if session.is_empty() && offset == recorded.bytes.len() {
            // It is whole, and taken in by whoever finds it so.
            thread::sleep(Duration::from_millis(100));
        }
    }
    ensure!(session == recorded.session, "an upload of {} has become {session}", recorded.session);
    entry.acknowledged = true;
    visitor.ledger.note(Act::UploadInPieces, &entry);
    Ok(())
}

/// Does what must be done once: where the connection breaks over it, looks whether it was done, and does it again if it was not.
fn do_once(
    visitor: &mut Visitor,
    act: Act,
    mut entry: Entry,
    send: impl Fn(&mut Client) -> anyhow::Result<Option<Answer>>,
    seen: (&str, &str),
) -> anyhow::Result<()> {
    let (page, words) = seen;
    visitor.ledger.note(act, &entry);
    while !entry.acknowledged {
        match send(&mut visitor.client)? {
            Some(answer) => {
                expect(&answer, &[201, 303], &entry.mark)?;
                entry.acknowledged = true;
            }
            None => {
                entry.unheard += 1;
                // What the dead service has sent to the database is done by then.
                thread::sleep(Duration::from_millis(100));
                entry.acknowledged = visitor.client.get("look", page)?.text().contains(words);
            }
        }
        visitor.ledger.note(act, &entry);
    }
    Ok(())
}

fn sign_in(visitor: &mut Visitor) -> anyhow::Result<()> {
    visitor.client.forget_cookies();
    let email = format!("{}@example.org", visitor.name);
    let fields = [("email", email.as_str()), ("password", PASSWORD)];
    let answer = loop {
        // Whoever does not know whether they are in signs in again.
        if let Some(answer) = visitor.client.press("sign in", "/login", ("/login", &fields))? {
            break answer;
        }
        visitor.client.forget_cookies();
    };
    expect(&answer, &[303], "signing in")?;
    ensure!(!answer.header("location").contains("login"), "signing in leads to {}", answer.header("location"));
    Ok(())
}

fn show(visitor: &mut Visitor, path: &str) -> anyhow::Result<()> {
    let answer = visitor.client.get("page", path)?;
    expect(&answer, &[200], path)
}

fn teach_on(visitor: &mut Visitor) -> anyhow::Result<()> {
    let (mut said, token) = (0, visitor.client.token.clone());
    while visitor.goes_on() {
        visitor.client.token = None;
        if said % ACTS_SIGNED_IN == 0 {
            sign_in(visitor)?;
        }
        show(visitor, ["/", "/cohorts", "/review", "/curricula"][said % 4])?;
        visitor.client.token.clone_from(&token);
        said += 1;
        let Some(session) = visitor.draw_scored()? else { continue };
        let mark = format!("{} says {said}.", visitor.name);
        if said % 2 == 0 {
            comment(visitor, &mark, &session)?;
        } else {
            regrade(visitor, &mark, &session)?;
        }
    }
    Ok(())
}

fn comment(visitor: &mut Visitor, mark: &str, session: &str) -> anyhow::Result<()> {
    let body = serde_json::json!({ "kind": "teaching", "from_s": 0.5, "body": mark }).to_string();
    let path = format!("/api/v1/sessions/{session}/comments");
    let headers = vec![("content-type", "application/json".to_owned())];
    let entry = visitor.entry(mark, session);
    let request =
        Request { what: "comment", method: "POST", path: &path, headers, body: body.as_bytes(), repeatable: false };
    do_once(visitor, Act::Comment, entry, |client| client.ask(&request), (&path, mark))
}

fn regrade(visitor: &mut Visitor, mark: &str, session: &str) -> anyhow::Result<()> {
    let (page, entry) = (format!("/sessions/{session}/regrade"), visitor.entry(mark, session));
    // In a browser: a token is for the API alone.
    let token = visitor.client.token.take();
    let (fields, grade) = ([("reason", mark)], format!("/sessions/{session}/grade"));
    let send = |client: &mut Client| client.press("regrade", &page, (&page, &fields));
    let done = do_once(visitor, Act::Regrade, entry, send, (&grade, mark));
    visitor.client.token = token;
    done
}

fn administer_on(visitor: &mut Visitor) -> anyhow::Result<()> {
    let mut added = 0;
    visitor.client.token = None;
    while visitor.goes_on() {
        if added % ACTS_SIGNED_IN == 0 {
            sign_in(visitor)?;
        }
        show(visitor, ["/people", "/admin/service", "/"][added % 3])?;
        added += 1;
        let (name, email) = (format!("New {added}"), format!("new-{added}@example.org"));
        let entry = visitor.entry(&email, "");
        let fields = [("name", name.as_str()), ("email", email.as_str()), ("role", "trainee")];
        let send = |client: &mut Client| client.press("add person", "/people", ("/people", &fields));
        // In the list, and not in the field of the search.
        let seen = (format!("/people?q=new-{added}"), format!("{name}<"));
        do_once(visitor, Act::Person, entry, send, (&seen.0, &seen.1))?;
    }
    Ok(())
}
