//! What is there in the end, held against what clients were told.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use anyhow::Context;
use data_encoding::HEXLOWER;
use platform::clock;
use serde_json::Value;
use sha2::{Digest, Sha256};
use tests::endings::say;

use crate::client::{Client, Proxy};
use crate::ledger::{Act, BROKEN, Entry, Ledger, REFUSED, RequestTally};
use crate::school::School;

/// Longest until everything that waits is done.
const PATIENCE: Duration = Duration::from_secs(600);
/// Most that is told of what is amiss.
const MOST_TOLD: usize = 40;

/// What was found.
#[derive(Debug, Default)]
pub struct Verdict {
    counts: Vec<(&'static str, usize)>,
    amiss: Vec<String>,
}

impl Verdict {
    /// Nothing is amiss.
    pub const fn is_good(&self) -> bool {
        self.amiss.is_empty()
    }

    /// Notes a figure that is neither good nor bad.
    pub fn count(&mut self, what: &'static str, count: usize) {
        self.counts.push((what, count));
    }

    /// Notes a figure that must be 0, with a sentence for each thing that is counted.
    pub fn blame(&mut self, what: &'static str, found: Vec<String>) {
        self.counts.push((what, found.len()));
        self.amiss.extend(found);
    }

    /// For people.
    pub fn table(&self) -> String {
        let mut table = String::from("| what | count |\n|---|---|\n");
        for (what, count) in &self.counts {
            // A text takes whatever is written to it.
            let _ = writeln!(table, "| {what} | {count} |");
        }
        for sentence in self.amiss.iter().take(MOST_TOLD) {
            let _ = writeln!(table, "amiss: {sentence}");
        }
        table + if self.is_good() { "nothing is amiss" } else { "SOMETHING IS AMISS" }
    }
}

/// Waits until nothing waits any more.
pub fn await_queues(school: &School) -> anyhow::Result<()> {
    let begun = clock::instant();
    while !school.are_queues_empty()? {
        anyhow::ensure!(
            begun.elapsed() < PATIENCE,
            "after {} s something still waits to be scored or mailed",
            PATIENCE.as_secs()
        );
        thread::sleep(Duration::from_millis(300));
    }
    Ok(())
}

/// Holds what is there against the ledger, once the queues are empty.
pub fn pass(school: &Arc<School>, proxy: &Arc<Proxy>, ledger: &Arc<Ledger>) -> anyhow::Result<Verdict> {
    let mut verdict = Verdict::default();
    check_uploads(school, proxy, ledger, &mut verdict)?;
    check_scores(school, ledger, &mut verdict)?;
    let comments = "SELECT body, count(*) FROM comments GROUP BY body";
    verdict.count("comments acknowledged", acknowledged(&ledger.entries(Act::Comment)));
    verdict
        .blame("comments lost or there twice", differing(&ledger.entries(Act::Comment), &tallied(school, comments)?));
    check_people(school, ledger, &mut verdict)?;
    verdict.blame("findings of verify", findings(school)?);
    let left = "SELECT (SELECT count(*) FROM readers) + (SELECT count(*) FROM uploads WHERE held_by IS NOT NULL)
                     + (SELECT count(*) FROM jobs WHERE held_by IS NOT NULL)";
    let left = school.query(left)?;
    let left =
        left.iter().flatten().filter(|count| *count != "0").map(|count| format!("held by nobody alive: {count}"));
    verdict.blame("left in hands of the dead", left.collect());
    Ok(verdict)
}

fn acknowledged(entries: &[Entry]) -> usize {
    entries.iter().filter(|entry| entry.acknowledged).count()
}

/// Counts by their names.
fn tallied(school: &School, statement: &str) -> anyhow::Result<BTreeMap<String, u64>> {
    let pair = |row: Vec<String>| {
        let [name, count] = row.as_slice() else { anyhow::bail!("{statement}: a row has not two columns") };
        Ok((name.clone(), count.parse().context("a count")?))
    };
    school.query(statement)?.into_iter().map(pair).collect()
}

/// What is not there once that was acknowledged, or there more than once, or not acknowledged and there more than once.
fn differing(entries: &[Entry], there: &BTreeMap<String, u64>) -> Vec<String> {
    let differs = |entry: &&Entry| match there.get(&entry.mark).copied().unwrap_or(0) {
        0 => entry.acknowledged,
        count => count > 1,
    };
    let tell = |entry: &Entry| {
        let Entry { mark, session, acknowledged, unheard, .. } = entry;
        let count = there.get(mark).copied().unwrap_or(0);
        format!("{mark} (of {session:?}; acknowledged: {acknowledged}; sent unheard: {unheard}) is there {count} times")
    };
    entries.iter().filter(differs).map(tell).collect()
}

fn uploads(ledger: &Ledger) -> Vec<Entry> {
    [ledger.entries(Act::Upload), ledger.entries(Act::UploadInPieces)].concat()
}

fn check_uploads(
    school: &School,
    proxy: &Arc<Proxy>,
    ledger: &Arc<Ledger>,
    verdict: &mut Verdict,
) -> anyhow::Result<()> {
    let entries = uploads(ledger);
    let there = tallied(school, "SELECT recording_sha256, count(*) FROM sessions GROUP BY recording_sha256")?;
    verdict.count("uploads acknowledged", acknowledged(&entries));
    verdict.blame("uploads lost or there twice", differing(&entries, &there));
    let nobodys = there.keys().filter(|sha256| !entries.iter().any(|entry| entry.mark == **sha256));
    verdict.blame("there and sent by nobody", nobodys.map(|sha256| format!("{sha256} was sent by nobody")).collect());
    let (mut unlisted, mut damaged) = (Vec::new(), Vec::new());
    let mut lists: BTreeMap<String, Vec<String>> = BTreeMap::new();
    // Whoever looks at the end has a page of the ledger to themselves.
    let aside = Arc::new(Ledger::default());
    for entry in entries.iter().filter(|entry| entry.acknowledged) {
        let mut client = Client::new(proxy, &aside, 200);
        client.token = Some(entry.token.clone());
        let list = match lists.get(&entry.token) {
            Some(list) => list,
            None => lists.entry(entry.token.clone()).or_insert(list_sessions(&mut client)?),
        };
        let listed = list.iter().filter(|id| **id == entry.session).count();
        if listed != 1 {
            unlisted.push(format!("{} is listed {listed} times", entry.session));
        }
        let file = client.get("download", &format!("/api/v1/sessions/{}/recording", entry.session))?;
        if file.status != 200 || HEXLOWER.encode(&Sha256::digest(&file.body)) != entry.mark {
            damaged.push(format!(
                "{} downloads with {} and {} bytes, and another hash",
                entry.session,
                file.status,
                file.body.len()
            ));
        }
    }
    verdict.blame("not listed once", unlisted);
    verdict.blame("not downloaded whole", damaged);
    Ok(())
}

/// Ids of all sessions of whoever asks.
fn list_sessions(client: &mut Client) -> anyhow::Result<Vec<String>> {
    let (mut ids, mut path) = (Vec::new(), "/api/v1/sessions".to_owned());
    loop {
        let list: Value = serde_json::from_slice(&client.get("list", &path)?.body)?;
        let page = list["sessions"].as_array().context("sessions")?;
        ids.extend(page.iter().filter_map(|session| session["session_id"].as_str()).map(str::to_owned));
        let Some(next) = list["next"].as_str() else { return Ok(ids) };
        path = format!("/api/v1/sessions?after={next}");
    }
}

/// Each attempt is scored once by the worker, and once more for each time that somebody has graded it again.
fn check_scores(school: &School, ledger: &Ledger, verdict: &mut Verdict) -> anyhow::Result<()> {
    let scored =
        tallied(school, "SELECT object, count(*) FROM audit_log WHERE action = 'session.scored' GROUP BY object")?;
    let regraded =
        tallied(school, "SELECT object, count(*) FROM audit_log WHERE action = 'session.regraded' GROUP BY object")?;
    let scores = tallied(school, "SELECT session_id, count(*) FROM scores GROUP BY session_id")?;
    let mut wrong = Vec::new();
    for row in school.query("SELECT id, state FROM sessions")? {
        let [id, state] = row.as_slice() else { continue };
        let of = |counts: &BTreeMap<String, u64>| counts.get(id).copied().unwrap_or(0);
        let (once, again, all) = (of(&scored), of(&regraded), of(&scores));
        if state != "scored" || once != 1 || all != once + again {
            wrong.push(format!("{id} is {state}: scored {once} times, graded again {again} times, {all} scores"));
        }
    }
    verdict.blame("not scored once by effect", wrong);
    let acts = ledger.entries(Act::Regrade);
    verdict.count("regrades acknowledged", acknowledged(&acts));
    let there = tallied(school, "SELECT reason, count(*) FROM regrade_reasons GROUP BY reason")?;
    verdict.blame("regrades lost or there twice", differing(&acts, &there));
    Ok(())
}

/// Each person is there once and was sent one letter. Those of which the service itself does not know whether they went are counted apart:
/// of them the mail server has one or none.
fn check_people(school: &School, ledger: &Ledger, verdict: &mut Verdict) -> anyhow::Result<()> {
    let entries = ledger.entries(Act::Person);
    verdict.count("people acknowledged", acknowledged(&entries));
    verdict.blame(
        "people lost or there twice",
        differing(&entries, &tallied(school, "SELECT email, count(*) FROM people GROUP BY email")?),
    );
    let unknown = tallied(
        school,
        "SELECT p.email, count(*) FROM mails m JOIN people p ON p.id = m.person_id
         WHERE m.sent_at IS NULL AND m.next_run_at IS NULL AND m.error IS NULL GROUP BY p.email",
    )?;
    let mut letters: BTreeMap<String, u64> = BTreeMap::new();
    for to in school.mail.taken() {
        *letters.entry(to).or_default() += 1;
    }
    verdict.count("letters taken by the mail server", letters.values().sum::<u64>() as usize);
    let (arrived, lost): (Vec<&String>, _) = unknown.keys().partition(|to| letters.contains_key(*to));
    verdict.count("letters told to be unknown, that arrived", arrived.len());
    verdict.count("letters told to be unknown, that did not", lost.len());
    letters.extend(lost.into_iter().map(|to| (to.clone(), 1)));
    verdict.blame("letters lost untold, or written twice", differing(&entries, &letters));
    Ok(())
}

/// What `verify` finds.
fn findings(school: &School) -> anyhow::Result<Vec<String>> {
    let output = school.command(&school.program, "office").arg("verify").output()?;
    if output.status.success() {
        return Ok(Vec::new());
    }
    let [out, err] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    Ok(out.lines().chain(err.lines()).map(str::to_owned).collect())
}

/// How requests went, as a table; the most tries that one took.
pub fn tell_requests(tallies: &BTreeMap<&'static str, RequestTally>) -> u32 {
    let mut table = String::from(
        "| request | answered at once | after one retry | after more | statuses (longest, s) |\n|---|---|---|---|---|\n",
    );
    let mut most = 0;
    for (what, tally) in tallies {
        let by = |retries: u32| tally.by_retries.get(&retries).copied().unwrap_or(0);
        let more: usize = tally.by_retries.range(2..).map(|(_, count)| count).sum();
        most = most.max(tally.by_retries.keys().next_back().copied().unwrap_or(0));
        let statuses = tally.by_status.iter().map(|(status, of)| {
            let name = match *status {
                REFUSED => "no connection".to_owned(),
                BROKEN => "broken off".to_owned(),
                status => status.to_string(),
            };
            format!("{name}: {} ({:.1})", of.count, of.longest_s)
        });
        let statuses: Vec<String> = statuses.collect();
        let _ = writeln!(table, "| {what} | {} | {} | {more} | {} |", by(0), by(1), statuses.join(", "));
    }
    say(table.trim_end());
    most
}
