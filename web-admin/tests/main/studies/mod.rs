//! Studies through the front door. Fails when a guest leaves more than a pseudonym, counts outside the study, signs in twice by
//! one code or without having agreed; when an answer is not of the attempt after which it was given; and when somebody who has
//! left is still in the study.

pub(crate) mod retention;

use acts::training::deadlines;
use axum::body::Body;
use axum::http::Request;
use model::ids::SessionId;
use serde_json::{Value, json};
use time::OffsetDateTime;
use web_admin::{outbox, worker};

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};
use crate::surveys::{School, send};

const STUDY: [(&str, &str); 11] = [
    ("title", "Is it like a patient?"),
    ("exercise", "feel-the-layers"),
    ("attempts", "2"),
    ("groups", "Novices\r\nExperts"),
    ("questions", "Role\r\nYears"),
    ("after", "nasa-tlx"),
    ("end", "simulator-validity"),
    ("consent", "I take part.\r\nI can leave."),
    ("controller", "North"),
    ("contact", "study@example.org"),
    ("kept", "12"),
];

/// A school in which a study is held, and a station.
pub(crate) struct StudyDay {
    pub(crate) school: School,
    pub(crate) teacher: Client,
    pub(crate) study: String,
    station: Client,
}

impl StudyDay {
    pub(crate) async fn new() -> Self {
        let school = School::new().await;
        let mut teacher = school.app.signed_in("teacher@example.org").await;
        let csrf = csrf_in(&teacher.get("/studies/new").await.text());
        let made = send(&mut teacher, "/studies/new", &[&[("csrf", csrf.as_str())], &STUDY[..]].concat()).await;
        assert_eq!(made.status, 303, "{}", made.text());
        let station = school.app.with_token(&school.app.station(school.id).await);
        Self { school, study: made.header("location").to_owned(), teacher, station }
    }

    /// Sends a form of the study's page.
    pub(crate) async fn post(&mut self, path: &str, fields: &[(&str, &str)]) -> Answer {
        let csrf = csrf_in(&self.teacher.get(&self.study).await.text());
        send(&mut self.teacher, path, &[&[("csrf", csrf.as_str())], fields].concat()).await
    }

    pub(crate) async fn add(&mut self, fields: &[(&str, &str)]) -> Answer {
        self.post(&format!("{}/participants", self.study), fields).await
    }

    /// The code of a guest who is an expert.
    pub(crate) async fn guest(&mut self) -> String {
        let fields = [("group", "1"), ("fact", "surgeon"), ("fact", "12"), ("consent", "yes")];
        code_in(&self.add(&fields).await)
    }

    /// What the school says to what a station sends it.
    async fn type_code(&mut self, typed: Value) -> Answer {
        let request = Request::post("/api/v1/stations/sign-in").header("content-type", "application/json");
        self.station.send(request.body(Body::from(typed.to_string())).unwrap()).await
    }

    /// Somebody types their code, and agrees to what they are asked.
    pub(crate) async fn sign_in(&mut self, code: &str) -> Answer {
        let answer = self.type_code(json!({ "code": code })).await;
        if answer.status != 202 {
            return answer;
        }
        let revision = answer.json()["revision"].clone();
        self.type_code(json!({ "code": code, "consent": revision })).await
    }

    /// An attempt of somebody at the station.
    pub(crate) async fn attempt(&mut self, trainee: &Value) -> SessionId {
        let session_id = SessionId::random();
        let trainee = trainee.as_str().unwrap().to_owned();
        let attempt = Attempt { session_id, trainee, ..Attempt::default() };
        let answer = self.station.upload(&record(&attempt)).await;
        assert_eq!(answer.status, 201, "{}", answer.text());
        worker::work_off_jobs(&self.school.app.state).await.unwrap();
        session_id
    }

    /// Answers at the station what is asked after an attempt.
    pub(crate) async fn answer(&mut self, session: SessionId, survey: &Value, item: &str) -> Answer {
        let path = format!("/api/v1/sessions/{session}/survey/{}", survey["survey_id"].as_str().unwrap());
        let secret: String = session.uuid().simple().to_string().repeat(2);
        let secret = if item == "mental" { secret } else { secret.chars().rev().collect() };
        let value = if item == "mental" { 40 } else { 4 };
        let given =
            json!({ "secret": secret, "language": "en", "consent": true, "answers": { item: value }, "sent": true });
        let request = Request::put(&path).header("content-type", "application/json");
        self.station.send(request.body(Body::from(given.to_string())).unwrap()).await
    }

    pub(crate) async fn count(&self, statement: &'static str) -> i64 {
        sqlx::query_scalar(statement).fetch_one(self.school.app.state.db.reader()).await.unwrap()
    }
}

fn code_in(answer: &Answer) -> String {
    let page = answer.text();
    assert_eq!(answer.status, 200, "{page}");
    assert!(page.contains("I can leave.") && page.contains("study@example.org"), "what was agreed to: {page}");
    page.split("code-to-type\">").nth(1).expect("a code").split('<').next().unwrap().to_owned()
}

#[tokio::test]
async fn a_guest_goes_from_a_code_to_answers_tied_to_the_attempt() {
    let mut day = StudyDay::new().await;
    let refused = day.add(&[("group", "1"), ("fact", "surgeon")]).await;
    assert!(refused.status == 422 && refused.text().contains("requires consent"), "{}", refused.text());
    let code = day.guest().await;
    let signed_in = day.sign_in(&code).await.json();
    assert_eq!(signed_in["trainee"], signed_in["display_name"], "a pseudonym and nothing else");
    let exercises = signed_in["exercises"].as_array().unwrap();
    assert_eq!((exercises.len(), &exercises[0]["due"]), (1, &true.into()), "{signed_in}");
    let surveys = signed_in["surveys"].as_array().unwrap();
    let asked: Vec<_> = surveys.iter().map(|s| (s["study"].as_bool(), s["from_attempt"].as_u64())).collect();
    assert_eq!(asked, [(Some(true), Some(1)), (Some(true), Some(2))], "after each, and after the second");
    assert_eq!(day.sign_in(&code).await.status, 403, "good once");
    let first = day.attempt(&signed_in["trainee"]).await;
    assert_eq!(day.answer(first, &surveys[0], "mental").await.status, 200);
    let second = day.attempt(&signed_in["trainee"]).await;
    assert_eq!(day.answer(second, &surveys[0], "mental").await.status, 200);
    assert_eq!(day.answer(second, &surveys[1], "looks").await.status, 200);
    let page = day.teacher.get(&day.study.clone()).await.text();
    assert!(page.contains("2 of 2") && page.contains("surgeon · 12") && page.contains(">3</td>"), "{page}");
    let tied = "SELECT count(*) FROM survey_responses r JOIN sessions s ON s.id = r.session_id
                AND s.trainee_id = r.person_id WHERE r.state = 'submitted'";
    assert_eq!(day.count(tied).await, 3);
}

#[tokio::test]
async fn guest_consents_at_the_station_before_any_data_are_stored() {
    let mut day = StudyDay::new().await;
    let code = day.guest().await;
    let kept = "SELECT count(*) FROM audit_log WHERE action IN ('study.consented', 'guest.signed_in_at_station')";
    let codes = "SELECT count(*) FROM sign_in_codes";
    for typed in [json!({ "code": code }), json!({ "code": code, "consent": "of another text" })] {
        let asked = day.type_code(typed).await;
        assert_eq!(asked.status, 202, "{}", asked.text());
        let terms = asked.json();
        assert_eq!(terms["consent"], "I take part.\nI can leave.");
        assert_eq!(
            [&terms["study"], &terms["controller"], &terms["contact"]],
            ["Is it like a patient?", "North", "study@example.org"]
        );
        assert_eq!(terms["kept_months"], 12);
        assert!(terms.get("trainee").is_none() && terms.get("surveys").is_none(), "nobody is signed in: {terms}");
        assert_eq!((day.count(kept).await, day.count(codes).await), (0, 1), "whoever goes away uses up nothing");
    }
    let revision = day.type_code(json!({ "code": code })).await.json()["revision"].clone();
    let signed_in = day.type_code(json!({ "code": code, "consent": revision })).await;
    assert_eq!(signed_in.status, 200, "{}", signed_in.text());
    assert_eq!((day.count(kept).await, day.count(codes).await), (2, 0));
    let sql = "SELECT details FROM audit_log WHERE action = 'study.consented'";
    let details: String = sqlx::query_scalar(sql).fetch_one(day.school.app.state.db.reader()).await.unwrap();
    let details: Value = serde_json::from_str(&details).unwrap();
    assert_eq!((&details["terms_sha256"], &details["consent"]), (&revision, &"I take part.\nI can leave.".into()));
    assert_eq!(revision.as_str().map(str::len), Some(64));
}

#[tokio::test]
async fn code_of_a_closed_study_is_rejected_until_it_reopens() {
    let mut day = StudyDay::new().await;
    let code = day.guest().await;
    let close = format!("{}/close", day.study);
    assert_eq!(day.post(&close, &[("closed", "true")]).await.status, 303);
    assert_eq!(day.type_code(json!({ "code": code })).await.status, 403);
    assert_eq!(day.post(&close, &[("closed", "false")]).await.status, 303);
    assert_eq!(day.sign_in(&code).await.status, 200);
}

#[tokio::test]
async fn a_guest_counts_nowhere_but_in_the_study_and_has_no_account() {
    let mut day = StudyDay::new().await;
    let code = day.guest().await;
    let trainee = day.sign_in(&code).await.json()["trainee"].clone();
    let session = day.attempt(&trainee).await;
    assert_eq!(day.count("SELECT CAST(coalesce(sum(attempts), 0) AS BIGINT) FROM tallies").await, 0);
    let mut head = day.school.app.signed_in("head@example.org").await;
    let pseudonym = trainee.as_str().unwrap();
    for path in ["/people", "/review", "/progress/attempts.csv", "/exercises/feel-the-layers", "/"] {
        let page = head.get(path).await;
        assert_eq!(page.status, 200, "{path}");
        assert!(
            !page.text().contains(pseudonym) && !page.text().contains(&session.to_string()),
            "{path}: {}",
            page.text()
        );
    }
    let sql = "SELECT lower(hex(id)) FROM people WHERE role = 'guest'";
    let guest: String = sqlx::query_scalar(sql).fetch_one(day.school.app.state.db.reader()).await.unwrap();
    let guest: model::ids::PersonId = guest.parse().unwrap();
    assert_eq!(head.get(&format!("/people/{guest}")).await.status, 404);
    let address = format!("{pseudonym}@guest.invalid");
    assert_eq!(day.school.app.stranger().sign_in(&address, "").await.status, 401);
    assert_eq!(day.count("SELECT count(*) FROM mails").await, 0);
    let page = day.teacher.get(&format!("/sessions/{session}")).await;
    assert_eq!(page.status, 404, "who runs a study sees figures, not attempts of single people");
}

#[tokio::test]
async fn whoever_leaves_is_out_with_all_they_said() {
    let mut day = StudyDay::new().await;
    let code = day.guest().await;
    let signed_in = day.sign_in(&code).await.json();
    let session = day.attempt(&signed_in["trainee"]).await;
    assert_eq!(day.answer(session, &signed_in["surveys"][0], "mental").await.status, 200);
    let page = day.teacher.get(&day.study.clone()).await.text();
    let path = page.split("action=\"").find(|rest| rest.contains("/withdraw\"")).unwrap().split('"').next().unwrap();
    let (withdraw, code) = (path.to_owned(), path.replace("/withdraw", "/code"));
    let renewed = day.post(&code, &[]).await;
    let unused = code_in(&renewed);
    assert_eq!(day.post(&withdraw, &[]).await.status, 303);
    assert_eq!(day.sign_in(&unused).await.status, 403, "an open code is closed");
    assert_eq!(day.post(&code, &[]).await.status, 404);
    assert_eq!(day.post(&withdraw, &[]).await.status, 404, "once is enough");
    let page = day.teacher.get(&day.study.clone()).await.text();
    assert!(page.contains("left on 20 May 2026") && !page.contains("surgeon"), "{page}");
    assert_eq!(
        day.count("SELECT count(*) FROM survey_responses WHERE answers <> '[]' OR person_id IS NOT NULL").await,
        0
    );
}

/// Somebody of the school answers what they are asked on their own page.
pub(crate) async fn answer_request(client: &mut Client, answer: &str) -> Answer {
    let page = client.get("/account/studies").await.text();
    let is_answer = |value: &&str| value.starts_with("/account/studies/") && value.ends_with(answer);
    let path = page.split('"').rfind(is_answer).expect("somebody asks").to_owned();
    let terms = page.split("name=\"terms\" value=\"").nth(1).map(|rest| rest.split('"').next().unwrap().to_owned());
    client.form(&path, &[("csrf", &csrf_in(&page)), ("terms", terms.as_deref().unwrap_or_default())]).await
}

/// What a station is answered that brings an attempt of somebody.
async fn bring(day: &mut StudyDay, pseudonym: &str) -> Answer {
    let attempt = Attempt { trainee: pseudonym.to_owned(), ..Attempt::default() };
    day.station.upload(&record(&attempt)).await
}

#[tokio::test]
async fn guest_recording_needs_consent_that_is_still_in_force() {
    let mut day = StudyDay::new().await;
    let code = day.guest().await;
    let sql = "SELECT pseudonym FROM people WHERE role = 'guest'";
    let guest: String = sqlx::query_scalar(sql).fetch_one(day.school.app.state.db.reader()).await.unwrap();
    bring(&mut day, &guest).await.is_problem(451, "has not agreed");
    assert_eq!(day.sign_in(&code).await.status, 200);
    assert_eq!(bring(&mut day, &guest).await.status, 201, "once they have agreed it is kept");
    let page = day.teacher.get(&day.study.clone()).await.text();
    let path = page.split("action=\"").find(|rest| rest.contains("/withdraw\"")).unwrap().split('"').next().unwrap();
    assert_eq!(day.post(path, &[("erase", "yes")]).await.status, 303);
    bring(&mut day, &guest).await.is_problem(451, "was erased");
    let left = "SELECT count(*) FROM sessions WHERE recording_erased_at IS NULL";
    assert_eq!((day.count(left).await, day.school.app.files().len()), (0, 0), "their recordings go where it is wished");
}

#[tokio::test]
async fn withdrawn_guest_sends_nothing_new_and_earlier_data_may_stay() {
    let mut day = StudyDay::new().await;
    let code = day.guest().await;
    let guest = day.sign_in(&code).await.json()["trainee"].as_str().unwrap().to_owned();
    assert_eq!(bring(&mut day, &guest).await.status, 201);
    let page = day.teacher.get(&day.study.clone()).await.text();
    let path = page.split("action=\"").find(|rest| rest.contains("/withdraw\"")).unwrap().split('"').next().unwrap();
    assert_eq!(day.post(path, &[]).await.status, 303);
    bring(&mut day, &guest).await.is_problem(451, "has withdrawn");
    assert_eq!(day.count("SELECT count(*) FROM sessions WHERE recording_erased_at IS NULL").await, 1);
}

#[tokio::test]
async fn open_study_counts_attempts_at_an_exercise_replaced_since() {
    let mut day = StudyDay::new().await;
    let code = day.guest().await;
    let trainee = day.sign_in(&code).await.json()["trainee"].as_str().unwrap().to_owned();
    let app = &day.school.app;
    app.publish_with_pass_mark(day.school.id, 99).await;
    app.state.clock.advance(30 * 86_400);
    let now = app.state.clock.now().micros() / 1_000_000;
    let started_at = OffsetDateTime::from_unix_timestamp(now - 60).unwrap();
    let attempt = Attempt { started_at, trainee, ..Attempt::default() };
    let received = day.station.upload(&record(&attempt)).await.json();
    assert_eq!(received["uncounted"], "unpublished", "it earns no mastery");
    worker::work_off_jobs(&app.state).await.unwrap();
    let mut teacher = app.signed_in("teacher@example.org").await;
    let table = teacher.get(&format!("{}/results/study.csv", day.study)).await.text();
    assert_eq!(table.lines().count(), 2, "the study asked for this revision: {table}");
}

#[tokio::test]
async fn invited_members_are_reminded_once_after_a_week() {
    let mut day = StudyDay::new().await;
    day.guest().await;
    for email in ["other@example.org", "ada@example.org"] {
        assert_eq!(day.add(&[("email", email), ("group", "0")]).await.status, 303);
    }
    let mut ada = day.school.app.signed_in("ada@example.org").await;
    assert_eq!(answer_request(&mut ada, "join").await.status, 303);
    let letters = async |day: &StudyDay| {
        deadlines::remind(&day.school.app.state).await.unwrap();
        outbox::work_off_letters(&day.school.app.state).await.unwrap();
        day.count("SELECT count(*) FROM mails WHERE kind = 'reminder' AND sent_at IS NOT NULL").await
    };
    assert_eq!(letters(&day).await, 0, "not on the first day");
    let older = sqlx::query("UPDATE study_participants SET added_at = added_at - $1").bind(8 * 86_400_000_000_i64);
    day.school.app.write(async |tx| older.execute(tx).await.unwrap()).await;
    assert_eq!([letters(&day).await, letters(&day).await], [1, 1], "only the member who has not answered, once");
}

#[tokio::test]
async fn school_members_join_a_study_by_consenting_signed_in() {
    let mut day = StudyDay::new().await;
    let fields = |email| [("email", email), ("group", "0")];
    assert_eq!(day.add(&fields("nobody@example.org")).await.status, 422);
    assert_eq!(day.add(&fields("other@example.org")).await.status, 303);
    assert_eq!(day.add(&fields("other@example.org")).await.status, 422, "once");
    let mut other = day.school.app.signed_in("other@example.org").await;
    assert_eq!(other.get(&day.study.clone()).await.status, 404, "a study is whoever's who runs it");
    let csrf = csrf_in(&other.get("/account").await.text());
    other.form("/sign-in-code", &[("csrf", &csrf)]).await;
    let page = other.get("/sign-in-code").await.text();
    let code = page.split("code-to-type\">").nth(1).unwrap().split('<').next().unwrap().to_owned();
    let signed_in = day.sign_in(&code).await.json();
    let before = day.attempt(&signed_in["trainee"]).await;
    let table = format!("{}/results/study.csv", day.study);
    assert_eq!(day.teacher.get(&table).await.text().lines().count(), 1, "who is only asked is not in it");
    assert!(other.get("/").await.text().contains("invites you to the study"), "they are told");
    assert!(!other.get(&format!("/sessions/{before}")).await.text().contains("NASA"), "nothing is asked yet");
    let csrf = csrf_in(&other.get("/account/studies").await.text());
    let join = format!("/account{}/join", day.study);
    let unread = other.form(&join, &[("csrf", &csrf), ("terms", "of another text")]).await;
    assert_eq!(unread.status, 409, "{}", unread.text());
    let mut third = day.school.app.signed_in("ada@example.org").await;
    let csrf = csrf_in(&third.get("/account/studies").await.text());
    assert_eq!(third.form(&join, &[("csrf", &csrf), ("terms", "x")]).await.status, 404, "who was not asked");
    day.school.app.state.clock.advance(1);
    assert_eq!(answer_request(&mut other, "join").await.status, 303);
    assert_eq!(day.teacher.get(&table).await.text().lines().count(), 1, "what they did before is theirs alone");
    let session = day.attempt(&signed_in["trainee"]).await;
    assert_eq!(day.teacher.get(&table).await.text().lines().count(), 2, "what they do from now on is in it");
    let own = other.get(&format!("/sessions/{session}")).await.text();
    assert!(own.contains("/surveys/") && own.contains("NASA"), "asked on the attempt's own page: {own}");
    let page = day.teacher.get(&day.study.clone()).await.text();
    assert!(page.contains("1 of 2") && !page.contains("/links\""), "what they did before is not in it: {page}");
    let path = page.split("action=\"").find(|rest| rest.contains("/withdraw\"")).unwrap().split('"').next().unwrap();
    let links = path.replace("/withdraw", "/links");
    assert_eq!(day.post(&links, &[]).await.status, 404, "nobody answers in their place");
    assert_eq!(answer_request(&mut other, "leave").await.status, 303);
    assert_eq!(day.teacher.get(&table).await.text().lines().count(), 1, "they have left");
    assert_eq!(day.post(&format!("{}/close", day.study), &[("closed", "true")]).await.status, 303);
    assert_eq!(day.add(&fields("ada@example.org")).await.status, 409, "it has ended");
}

#[tokio::test]
async fn a_guest_answers_by_link_what_nobody_has_begun() {
    let mut day = StudyDay::new().await;
    let code = day.guest().await;
    let signed_in = day.sign_in(&code).await.json();
    day.attempt(&signed_in["trainee"]).await;
    let page = day.teacher.get(&day.study.clone()).await.text();
    let path = page.split("formaction=\"").find(|rest| rest.contains("/links\"")).unwrap().split('"').next().unwrap();
    let links = day.post(path, &[]).await.text();
    let link = links.split("href=\"http://localhost").nth(1).unwrap().split('"').next().unwrap().to_owned();
    let mut browser = day.school.app.stranger();
    assert_eq!(send(&mut browser, &link, &[("do", "begin"), ("consent", "yes"), ("lang", "en")]).await.status, 303);
    let again = day.post(path, &[]).await.text();
    let counted = |page: &str| page.matches("href=\"http://localhost").count();
    assert_eq!((counted(&links), counted(&again)), (2, 1), "what was begun is the guest's alone: {again}");
    let sent = send(&mut browser, &link, &[("do", "send"), ("page", "0"), ("q.mental", "40")]).await;
    assert_eq!(sent.status, 303, "{}", sent.text());
    let tied =
        "SELECT count(*) FROM survey_responses r JOIN sessions s ON s.id = r.session_id WHERE r.state = 'submitted'";
    assert_eq!(day.count(tied).await, 1);
}

#[tokio::test]
async fn study_results_compare_groups_and_export_statistics_tables() {
    let mut day = StudyDay::new().await;
    for group in ["0", "0", "1", "1"] {
        let fields = [("group", group), ("fact", "=1+1"), ("fact", "7"), ("consent", "yes")];
        let code = code_in(&day.add(&fields).await);
        let signed_in = day.sign_in(&code).await.json();
        let session = day.attempt(&signed_in["trainee"]).await;
        assert_eq!(day.answer(session, &signed_in["surveys"][0], "mental").await.status, 200);
    }
    let results = format!("{}/results", day.study);
    let page = day.teacher.get(&results).await;
    assert_eq!(page.status, 200, "{}", page.text());
    assert!(page.text().contains("Does it distinguish Experts from Novices?"), "{}", page.text());
    let table = day.teacher.get(&format!("{results}/study.csv")).await.text();
    let mut lines = table.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let safe = |name: &&str| name.len() <= 64 && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    assert!(names.iter().all(safe) && names[0] == "participant", "{names:?}");
    let rows: Vec<&str> = lines.collect();
    assert!(rows.len() == 4 && rows.iter().all(|row| row.starts_with("g-") && row.contains(",'=1+1,")), "{table}");
    let book = day.teacher.get(&format!("{results}/study.json")).await.json();
    let columns: Vec<&str> = book["columns"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(columns, names, "each column is told");
    let mental = &book["columns"][names.iter().position(|name| *name == "q1_mental").unwrap()];
    assert!(mental["label"].as_str().unwrap().contains("mental"), "{mental}");
    assert_eq!(day.teacher.get(&format!("{results}/else.csv")).await.status, 404);
    let mut other = day.school.app.signed_in("other@example.org").await;
    assert_eq!(other.get(&results).await.status, 404);
}
