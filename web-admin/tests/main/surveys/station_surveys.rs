//! What a station asks in its debriefing, and the answers that it sends, through the front door. Fails when answers that are
//! sent again count twice or change, when an anonymous one leads to who gave it, or when a station learns or stores what
//! it may not.

use axum::body::Body;
use axum::http::Request;
use documents::Instrument;
use model::Role;
use model::ids::SessionId;
use serde_json::{Value, json};

use crate::support::client::{Answer, Client, csrf_in};
use crate::surveys::{School, send};

/// A school with a survey after each attempt, an attempt, and a station.
struct Debrief {
    school: School,
    survey: String,
    attempt: SessionId,
    station: Client,
}

impl Debrief {
    async fn after_attempt(identity: &str) -> Self {
        let school = School::new().await;
        let mut teacher = school.app.signed_in("teacher@example.org").await;
        let fields = [("identity", identity), ("after_attempts", "true")];
        let survey = school.survey(&mut teacher, "nasa-tlx", &fields).await;
        let attempt = school.upload().await;
        let station = school.app.with_token(&school.app.station(school.id).await);
        Self { school, survey, attempt, station }
    }

    fn address(&self) -> String {
        format!("/api/v1/sessions/{}/survey{}", self.attempt, self.survey.replace("/surveys", ""))
    }

    async fn give(&mut self, given: &Value) -> Answer {
        put(&mut self.station.clone(), &self.address(), given).await
    }

    async fn responses(&self) -> i64 {
        let count = sqlx::query_scalar("SELECT count(*) FROM survey_responses");
        count.fetch_one(self.school.app.state.db.reader()).await.unwrap()
    }

    async fn answers(&self) -> String {
        let mut teacher = self.school.app.signed_in("teacher@example.org").await;
        teacher.get(&format!("{}/results/answers-wide.csv", self.survey)).await.text()
    }
}

async fn put(client: &mut Client, path: &str, given: &Value) -> Answer {
    let request = Request::put(path).header("content-type", "application/json");
    client.send(request.body(Body::from(given.to_string())).unwrap()).await
}

fn secret(digit: &str) -> String {
    digit.repeat(64)
}

fn given(secret: &str, mental: u32, sent: bool) -> Value {
    let answers = json!({ "mental": mental, "effort": "30" });
    json!({ "secret": secret, "language": "de", "consent": true, "answers": answers, "sent": sent })
}

#[tokio::test]
async fn a_station_learns_what_to_ask_and_what_to_say_first() {
    let mut debrief = Debrief::after_attempt("pseudonymous").await;
    let asked = debrief.station.get(&format!("/api/v1/sessions/{}/survey", debrief.attempt)).await.json();
    let survey = &asked["surveys"][0];
    assert_eq!((&survey["identity"], &survey["languages"]), (&"pseudonymous".into(), &json!(["en", "de"])), "{asked}");
    for (language, words) in
        [("en", ["under a pseudonym", "voluntary"]), ("de", ["unter einem Pseudonym", "freiwillig"])]
    {
        let told = survey["terms"][language].as_array().unwrap();
        assert_eq!(
            told.len(),
            7,
            "introduction, identity, who asks, who is responsible, freedom, saving, taking back: {told:#?}"
        );
        let all: Vec<&str> = told.iter().map(|line| line.as_str().unwrap()).collect();
        assert!(words.iter().all(|word| all.concat().contains(word)), "{all:#?}");
    }
    let document = survey["instrument_toml"].as_str().unwrap();
    assert_eq!(Instrument::from_bytes("asked", document.as_bytes()).unwrap().items.len(), 6);

    let mut ada = debrief.school.app.signed_in("ada@example.org").await;
    let csrf = csrf_in(&ada.get("/").await.text());
    ada.form("/sign-in-code", &[("csrf", &csrf)]).await;
    let page = ada.get("/sign-in-code").await.text();
    let code = page.split("code-to-type\">").nth(1).unwrap().split('<').next().unwrap();
    let request = Request::post("/api/v1/stations/sign-in").header("content-type", "application/json");
    let request = request.body(Body::from(json!({ "code": code }).to_string())).unwrap();
    let signed_in = debrief.station.send(request).await.json();
    let known = &signed_in["surveys"][0];
    assert_eq!(known["instrument_toml"], survey["instrument_toml"], "so that a station can ask without a network");
    assert_eq!(known["exercises"], json!([]), "after every exercise");
}

#[tokio::test]
async fn answers_are_taken_once_however_often_they_are_sent() {
    let mut debrief = Debrief::after_attempt("pseudonymous").await;
    let begun = debrief.give(&given(&secret("a"), 10, false)).await;
    assert_eq!((begun.status.as_u16(), &begun.json()["state"]), (200, &"begun".into()), "{}", begun.text());
    assert!(!debrief.answers().await.contains(",10,"), "what is not final is no result");
    let mut ada = debrief.school.app.signed_in("ada@example.org").await;
    let own = ada.get(&format!("{}?session={}", debrief.survey, debrief.attempt)).await.text();
    assert!(own.contains("Go to my answers"), "the trainee can go on: {own}");
    for _ in 0..2 {
        let sent = debrief.give(&given(&secret("a"), 55, true)).await;
        assert_eq!((sent.status.as_u16(), &sent.json()["state"]), (200, &"submitted".into()), "{}", sent.text());
    }
    let changed = debrief.give(&given(&secret("a"), 95, true)).await;
    assert_eq!(changed.json()["state"], "submitted");
    assert_eq!(debrief.responses().await, 1);
    let csv = debrief.answers().await;
    assert!(csv.contains(",55,") && !csv.contains(",95,") && csv.contains(",de,"), "the first that are final: {csv}");
    assert!(csv.contains(&debrief.school.ada.person.pseudonym), "{csv}");
    debrief.give(&given(&secret("b"), 5, true)).await.is_problem(409, "already sent");
    let asked = debrief.station.get(&format!("/api/v1/sessions/{}/survey", debrief.attempt)).await.json();
    assert_eq!(asked["surveys"], json!([]), "once for an attempt");
    let told: Vec<String> = sqlx::query_scalar("SELECT actor FROM audit_log WHERE action = 'survey.answered'")
        .fetch_all(debrief.school.app.state.db.reader())
        .await
        .unwrap();
    assert_eq!(told, ["respondent"], "the log says once that somebody has answered, not who");
}

#[tokio::test]
async fn anonymous_station_answer_is_untraceable_and_withdrawable() {
    let mut debrief = Debrief::after_attempt("anonymous").await;
    assert_eq!(debrief.give(&given(&secret("c"), 55, true)).await.status, 200);
    let row: (Option<Vec<u8>>, Option<Vec<u8>>, i64) =
        sqlx::query_as("SELECT person_id, session_id, submitted_at % 86400000000 FROM survey_responses")
            .fetch_one(debrief.school.app.state.db.reader())
            .await
            .unwrap();
    assert_eq!(row, (None, None, 0), "neither person nor attempt nor hour");
    assert_eq!(debrief.give(&given(&secret("c"), 55, true)).await.json()["state"], "submitted", "the answer was lost");
    debrief.give(&given(&secret("d"), 55, true)).await.is_problem(409, "already sent");
    let mut stranger = debrief.school.app.stranger();
    let last = format!("/survey/{}", secret("c"));
    assert_eq!(send(&mut stranger, &last, &[("do", "withdraw")]).await.status, 303);
    assert_eq!(
        debrief.give(&given(&secret("c"), 55, true)).await.json()["state"],
        "withdrawn",
        "it does not come back"
    );
    assert_eq!(debrief.responses().await, 1);
}

#[tokio::test]
async fn what_is_not_allowed_is_named_and_nothing_is_written() {
    let mut debrief = Debrief::after_attempt("named").await;
    let base = given(&secret("e"), 55, true);
    let with = |key: &str, value: Value| {
        let mut given = base.clone();
        given[key] = value;
        given
    };
    for (wrong, says) in [
        (with("consent", false.into()), "consent"),
        (with("secret", "1234".into()), "64 hexadecimal digits"),
        (with("answers", json!({ "mental": 101 })), "answers.mental: \"101\"; allowed: 0 to 100 in steps of 5"),
        (with("answers", json!({ "mental": true })), "answers.mental: allowed: a number, a text"),
        (with("answers", json!({ "mood": 5 })), "answers.mood: no such item; allowed: mental,"),
    ] {
        debrief.give(&wrong).await.is_problem(422, says);
    }
    debrief.give(&with("more", 1.into())).await.is_problem(400, "more");
    let early = debrief.address().replace(&debrief.attempt.to_string(), &SessionId::random().to_string());
    put(&mut debrief.station, &early, &base).await.is_problem(404, "nothing was found");
    let south = debrief.school.app.school("South").await;
    let abroad = debrief.school.app.station(south).await;
    let address = debrief.address();
    put(&mut debrief.school.app.with_token(&abroad), &address, &base).await.is_problem(404, "nothing was found");
    let bo = debrief.school.app.member(debrief.school.id, Role::Trainee, "bo@example.org").await;
    put(&mut debrief.school.app.with_token(&bo.token), &address, &base).await.is_problem(404, "nothing was found");
    assert_eq!(debrief.responses().await, 0);
}

#[tokio::test]
async fn late_answers_are_accepted_if_the_survey_was_open_at_attempt() {
    let mut debrief = Debrief::after_attempt("named").await;
    let mut teacher = debrief.school.app.signed_in("teacher@example.org").await;
    let csrf = csrf_in(&teacher.get(&debrief.survey).await.text());
    let clock = debrief.school.app.state.clock.clone();
    let sql = "UPDATE sessions SET started_at = $1";
    let at = clock.now();
    debrief.school.app.write(async |tx| sqlx::query(sql).bind(at).execute(tx).await.unwrap()).await;
    clock.advance(60);
    let close = [("csrf", csrf.as_str()), ("closed", "true")];
    send(&mut teacher, &format!("{}/close", debrief.survey), &close).await;
    clock.advance(60);
    assert_eq!(debrief.give(&given(&secret("f"), 55, true)).await.status, 200);
    let late = debrief.school.upload().await;
    let at = clock.now();
    let sql = "UPDATE sessions SET started_at = $1 WHERE id = $2";
    debrief.school.app.write(async |tx| sqlx::query(sql).bind(at).bind(late).execute(tx).await.unwrap()).await;
    debrief.attempt = late;
    debrief.give(&given(&secret("0"), 55, true)).await.is_problem(410, "not open");
}
