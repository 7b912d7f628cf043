//! Stations join by a code and trainees sign in at them. Fails when a code works twice, too late or at another school,
//! when guessing is not braked, when a revoked station is let in, or when what was done is not in the audit log.

use axum::body::Body;
use axum::http::Request;
use model::{Moment, Role};
use platform::clock::Clock;
use serde_json::{Value, json};
use store::{audit, people};
use web_admin::worker;

use crate::support::App;
use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};

async fn post(client: &mut Client, path: &str, body: &Value) -> Answer {
    let request = Request::post(format!("/api/v1/stations/{path}")).header("content-type", "application/json");
    client.send(request.body(Body::from(body.to_string())).unwrap()).await
}

/// Sends a form that holds nothing but its token, from the page at `from`.
async fn press(browser: &mut Client, from: &str, path: &str) -> Answer {
    let csrf = csrf_in(&browser.get(from).await.text());
    browser.form(path, &[("csrf", &csrf)]).await
}

/// The code that a page shows.
fn code_in(answer: &Answer) -> String {
    let page = answer.text();
    assert_eq!(answer.status, 200, "{page}");
    page.split("code-to-type\">").nth(1).expect("a code").split('<').next().unwrap().to_owned()
}

/// Makes a sign-in code from the page at `from`; the code.
async fn made_code(browser: &mut Client, from: &str) -> String {
    assert_eq!(press(browser, from, "/sign-in-code").await.header("location"), "/sign-in-code");
    code_in(&browser.get("/sign-in-code").await)
}

/// A school with an administrator and a trainee.
struct School {
    app: App,
    clock: Clock,
}

impl School {
    async fn new() -> Self {
        let clock = Clock::fixed(Moment::from_micros(1_767_268_800_000_000));
        let app = App::with(clock.clone(), |_| {}).await;
        let north = app.school("North").await;
        app.publish(north).await;
        app.member(north, Role::Administrator, "head@example.org").await;
        app.member(north, Role::Trainee, "ada@example.org").await;
        Self { app, clock }
    }

    async fn pairing_code(&self) -> String {
        let mut head = self.app.signed_in("head@example.org").await;
        code_in(&press(&mut head, "/admin", "/admin/pairing-codes").await)
    }

    async fn sign_in_code(&self) -> String {
        let mut ada = self.app.signed_in("ada@example.org").await;
        made_code(&mut ada, "/").await
    }

    /// A client with the token of a station that has just joined.
    async fn station(&self, name: &str) -> Client {
        let code = self.pairing_code().await;
        let answer = post(&mut self.app.stranger(), "pair", &json!({ "code": code, "name": name })).await;
        assert_eq!(answer.status, 201, "{}", answer.text());
        self.app.with_token(answer.json()["token"].as_str().unwrap())
    }

    async fn pseudonym(&self) -> String {
        people::find_person_by_email(self.app.state.db.reader(), "ada@example.org").await.unwrap().unwrap().pseudonym
    }
}

#[tokio::test]
async fn a_station_joins_once_with_a_code_however_it_is_typed() {
    let school = School::new().await;
    let code = school.pairing_code().await;
    assert_eq!(code.len(), 9, "{code}");
    let typed = code.to_lowercase().replace('-', " ");
    let mut stranger = school.app.stranger();
    let answer = post(&mut stranger, "pair", &json!({ "code": typed, "name": " Skills lab 2 " })).await;
    assert_eq!(answer.status, 201, "{}", answer.text());
    let paired = answer.json();
    assert_eq!((&paired["school"], &paired["name"]), (&"North".into(), &"Skills lab 2".into()));
    post(&mut stranger, "pair", &json!({ "code": code, "name": "other" })).await.is_problem(403, "used");
    let mut station = school.app.with_token(paired["token"].as_str().unwrap());
    let me = station.get("/api/v1/stations/me").await.json();
    assert_eq!(me["name"], "Skills lab 2");
    let page = school.app.signed_in("head@example.org").await.get("/admin").await.text();
    assert!(page.contains("Skills lab 2") && page.contains("1 Jan 2026, 12:00"), "{page}");
}

#[tokio::test]
async fn pairing_code_rejects_wrong_names_and_expires() {
    let school = School::new().await;
    school.station("lab").await;
    let mut stranger = school.app.stranger();
    let code = school.pairing_code().await;
    for (name, status) in [("", 422), ("a\nb", 422), ("lab", 409)] {
        let answer = post(&mut stranger, "pair", &json!({ "code": code, "name": name })).await;
        answer.is_problem(status, "name");
    }
    post(&mut stranger, "pair", &json!({ "code": code })).await.is_problem(400, "name");
    school.clock.advance(600);
    post(&mut stranger, "pair", &json!({ "code": code, "name": "lab 2" })).await.is_problem(403, "expired");
}

#[tokio::test]
async fn guessing_pairing_codes_is_braked() {
    let school = School::new().await;
    let mut eve = school.app.stranger();
    let mut statuses = Vec::new();
    for n in 0..12 {
        statuses.push(post(&mut eve, "pair", &json!({ "code": format!("{n}"), "name": "x" })).await.status.as_u16());
    }
    assert_eq!((statuses[0], statuses[11]), (403, 429), "{statuses:?}");
}

#[tokio::test]
async fn a_trainee_signs_in_and_what_is_recorded_there_is_theirs() {
    let school = School::new().await;
    let mut station = school.station("lab").await;
    let code = school.sign_in_code().await;
    let answer = post(&mut station, "sign-in", &json!({ "code": code.to_lowercase() })).await;
    assert_eq!(answer.status, 200, "{}", answer.text());
    let signed_in = answer.json();
    assert_eq!(signed_in["trainee"], school.pseudonym().await);
    assert_eq!(signed_in["display_name"], "Somebody");
    let exercises = signed_in["exercises"].as_array().unwrap();
    assert_eq!((&exercises[0]["exercise_id"], &exercises[0]["next"]), (&"feel-the-layers".into(), &true.into()));
    assert!(exercises.len() > 3 && exercises[3]["due"] == false, "what is not due comes after: {signed_in}");
    let attempt = Attempt { trainee: school.pseudonym().await, ..Attempt::default() };
    assert_eq!(station.upload(&record(&attempt)).await.status, 201);
    let home = school.app.signed_in("ada@example.org").await.get("/").await.text();
    assert!(home.contains(&attempt.session_id.to_string()), "{home}");
    let listed = station.get("/api/v1/exercises").await.json();
    assert_eq!(listed["exercises"].as_array().unwrap().len(), exercises.len());
    station.get("/api/v1/sessions").await.is_problem(403, "station");
}

#[tokio::test]
async fn teacher_practises_like_a_trainee_and_counts_in_no_figure() {
    let school = School::new().await;
    let mut station = school.station("lab").await;
    let reader = school.app.state.db.reader();
    let head = people::find_person_by_email(reader, "head@example.org").await.unwrap().unwrap();
    let mut browser = school.app.signed_in("head@example.org").await;
    let code = made_code(&mut browser, "/account").await;
    let answer = post(&mut station, "sign-in", &json!({ "code": code })).await;
    assert_eq!((answer.status.as_u16(), &answer.json()["trainee"]), (200, &head.pseudonym.clone().into()));
    let attempt = Attempt { trainee: head.pseudonym.clone(), ..Attempt::default() };
    assert_eq!(station.upload(&record(&attempt)).await.status, 201);
    worker::work_off_jobs(&school.app.state).await.unwrap();
    let page = browser.get("/account").await.text();
    assert!(page.contains(&format!("/trainees/{}", head.id)) && page.contains("1 Jan 2026"), "{page}");
    let own = browser.get(&format!("/trainees/{}", head.id)).await.text();
    assert!(own.contains(&attempt.session_id.to_string()), "{own}");
    assert_eq!(browser.get(&format!("/sessions/{}", attempt.session_id)).await.status, 200);
    let queue = browser.get("/review").await.text();
    assert!(!queue.contains(&attempt.session_id.to_string()), "nobody judges whoever teaches: {queue}");
    let counted: Option<i64> = sqlx::query_scalar("SELECT sum(attempts) FROM tallies").fetch_one(reader).await.unwrap();
    assert_eq!(counted, None);
    let mut ada = school.app.signed_in("ada@example.org").await;
    assert_eq!(ada.get(&format!("/trainees/{}", head.id)).await.status, 404, "their practice is theirs");
}

#[tokio::test]
async fn sign_in_code_page_reloads_the_same_code_and_stores_it_sealed() {
    let school = School::new().await;
    let mut station = school.station("lab").await;
    let mut ada = school.app.signed_in("ada@example.org").await;
    assert_eq!(ada.get("/sign-in-code").await.header("location"), "/account", "none was made");
    let code = made_code(&mut ada, "/").await;
    assert_eq!(code_in(&ada.get("/sign-in-code").await), code);
    assert_eq!(post(&mut station, "sign-in", &json!({ "code": code })).await.status, 200);
    let kept: Vec<String> = sqlx::query_scalar("SELECT CAST(data AS TEXT) FROM web_sessions")
        .fetch_all(school.app.state.db.reader())
        .await
        .unwrap();
    assert!(
        kept.iter().any(|data| data.contains("sealed")) && !kept.iter().any(|data| data.contains(&code)),
        "{kept:?}"
    );
    let mut elsewhere = school.app.signed_in("ada@example.org").await;
    assert_eq!(elsewhere.get("/sign-in-code").await.header("location"), "/account", "another browser's");
    school.clock.advance(601);
    assert_eq!(ada.get("/sign-in-code").await.header("location"), "/account", "ten minutes later");
}

#[tokio::test]
async fn sign_in_code_ends_with_the_next_and_opens_no_other_school() {
    let school = School::new().await;
    let mut station = school.station("lab").await;
    let (old, new) = (school.sign_in_code().await, school.sign_in_code().await);
    post(&mut station, "sign-in", &json!({ "code": old })).await.is_problem(403, "unknown sign-in code");
    assert_eq!(post(&mut station, "sign-in", &json!({ "pin": new })).await.status, 200);
    let south = school.app.school("South").await;
    let mut abroad = school.app.with_token(&school.app.station(south).await);
    post(&mut abroad, "sign-in", &json!({ "code": new })).await.is_problem(403, "unknown sign-in code");
    let ada = people::find_person_by_email(school.app.state.db.reader(), "ada@example.org").await.unwrap().unwrap();
    let now = school.clock.now();
    school.app.write(async |tx| people::disable_person(tx, ada.id, now).await.unwrap()).await;
    post(&mut station, "sign-in", &json!({ "code": new })).await.is_problem(403, "unknown sign-in code");
}

#[tokio::test]
async fn twenty_wrong_codes_lock_one_station_for_the_hour() {
    let school = School::new().await;
    let mut station = school.station("lab").await;
    let right = json!({ "code": school.sign_in_code().await });
    for n in 0..20 {
        assert_eq!(post(&mut station, "sign-in", &right).await.status, 200, "{n}");
        assert_eq!(post(&mut station, "sign-in", &json!({ "code": format!("{n}") })).await.status, 403, "{n}");
    }
    school.clock.advance(600);
    let locked = post(&mut station, "sign-in", &right).await;
    locked.is_problem(429, "3000 s");
    assert_eq!(locked.header("retry-after"), "3000");
    let mut other = school.station("lab 2").await;
    assert_eq!(post(&mut other, "sign-in", &right).await.status, 200, "the next station is not locked");
    school.clock.advance(3000);
    assert_eq!(post(&mut station, "sign-in", &right).await.status, 200);
}

#[tokio::test]
async fn only_a_station_signs_in_and_only_the_right_people_make_codes() {
    let school = School::new().await;
    let north = school.app.school("North").await;
    let bob = school.app.member(north, Role::Trainee, "bob@example.org").await;
    let mut person = school.app.with_token(&bob.token);
    post(&mut person, "sign-in", &json!({ "code": "x" })).await.is_problem(403, "station");
    post(&mut school.app.stranger(), "sign-in", &json!({ "code": "x" })).await.is_problem(401, "token");
    let mut ada = school.app.signed_in("ada@example.org").await;
    assert_eq!(press(&mut ada, "/", "/admin/pairing-codes").await.status, 403);
    assert_eq!(ada.form("/sign-in-code", &[]).await.status, 403, "a form of another site");
    let mut head = school.app.signed_in("head@example.org").await;
    assert_eq!(press(&mut head, "/account", "/sign-in-code").await.status, 303, "whoever has an account practises");
    assert_eq!(school.app.stranger().form("/admin/pairing-codes", &[]).await.status, 303);
}

#[tokio::test]
async fn a_revoked_station_is_out_and_its_name_is_free() {
    let school = School::new().await;
    let mut station = school.station("lab").await;
    let south = school.app.school("South").await;
    school.app.member(south, Role::Administrator, "head@south.example").await;
    let mut head = school.app.signed_in("head@example.org").await;
    let page = head.get("/admin").await.text();
    let path = page.split("action=\"").find(|rest| rest.starts_with("/admin/stations/")).unwrap();
    let path = path.split('"').next().unwrap().to_owned();
    let mut abroad = school.app.signed_in("head@south.example").await;
    assert_eq!(press(&mut abroad, "/admin", &path).await.status, 404, "another school's station");
    assert_eq!(station.get("/api/v1/stations/me").await.status, 200);
    assert_eq!(press(&mut head, "/admin", &path).await.header("location"), "/admin#stations");
    station.get("/api/v1/stations/me").await.is_problem(401, "token");
    assert_eq!(press(&mut head, "/admin", &path).await.status, 404, "once is enough");
    school.station("lab").await;
}

#[tokio::test]
async fn what_was_done_is_in_the_audit_log() {
    let school = School::new().await;
    let mut station = school.station("lab").await;
    let code = school.sign_in_code().await;
    assert_eq!(post(&mut station, "sign-in", &json!({ "code": code })).await.status, 200);
    let mut head = school.app.signed_in("head@example.org").await;
    let page = head.get("/admin").await.text();
    let path = page.split("action=\"").find(|rest| rest.starts_with("/admin/stations/")).unwrap();
    press(&mut head, "/admin", path.split('"').next().unwrap()).await;
    let reader = school.app.state.db.reader();
    let actions: Vec<String> =
        sqlx::query_scalar("SELECT action FROM audit_log ORDER BY seq").fetch_all(reader).await.unwrap();
    let wanted =
        ["pairing_code.made", "station.paired", "sign_in_code.made", "trainee.signed_in_at_station", "station.revoked"];
    let found: Vec<_> = actions.iter().filter(|action| wanted.contains(&action.as_str())).collect();
    assert_eq!(found, wanted);
    assert!(audit::check_audit_chain(reader).await.unwrap().findings.is_empty());
}
