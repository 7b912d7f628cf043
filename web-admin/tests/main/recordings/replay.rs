//! A replay and what is said about it, through the front door. Fails when the first picture would need the recording,
//! a comment lands outside the attempt or in another one, or somebody takes back what another has said.

use axum::body::Body;
use axum::http::{Request, header};
use model::ids::SessionId;
use model::{Moment, Role};
use platform::clock::Clock;
use web_admin::worker;

use crate::support::client::{Client, csrf_in};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member};

/// A trainee with a scored attempt, and their teacher.
struct Lesson {
    app: App,
    ada: Member,
    attempt: SessionId,
}

impl Lesson {
    async fn new() -> Self {
        Self::with(Clock::system()).await
    }

    async fn with(clock: Clock) -> Self {
        let app = App::with(clock, |_| {}).await;
        let north = app.school("North").await;
        app.publish(north).await;
        let ada = app.member(north, Role::Trainee, "ada@example.org").await;
        let teacher = app.member(north, Role::Instructor, "teacher@example.org").await;
        app.member(north, Role::Instructor, "other@example.org").await;
        app.cohort(north, "Spring", &[&ada.person, &teacher.person]).await;
        let attempt = Attempt { session_id: SessionId::random(), ..Attempt::default() };
        assert_eq!(app.with_token(&ada.token).upload(&record(&attempt)).await.status, 201);
        worker::work_off_jobs(&app.state).await.unwrap();
        Self { app, ada, attempt: attempt.session_id }
    }

    fn path(&self, rest: &str) -> String {
        format!("/sessions/{}{rest}", self.attempt)
    }

    async fn say(&self, browser: &mut Client, fields: &[(&str, &str)]) -> crate::support::client::Answer {
        let csrf = csrf_in(&browser.get(&self.path("/replay")).await.text());
        let fields: Vec<_> = fields.iter().copied().chain([("csrf", csrf.as_str())]).collect();
        browser.form(&self.path("/comments"), &fields).await
    }
}

const WELL_HELD: [(&str, &str); 3] = [("kind", "praise"), ("from_s", "0.5"), ("body", "Well held")];

#[tokio::test]
async fn replay_is_made_at_scoring_and_again_when_missing() {
    let lesson = Lesson::new().await;
    let replays = lesson.app.state.config.replays_dir();
    assert_eq!(std::fs::read_dir(&replays).unwrap().count(), 1);
    let mut ada = lesson.app.with_token(&lesson.ada.token);
    let api = format!("/api/v1/sessions/{}", lesson.attempt);
    let stage = ada.get(&format!("{api}/replay")).await.json();
    assert_eq!(stage["layers"][0]["name"], "skin", "{stage}");
    assert!(stage["events"].as_array().unwrap().iter().any(|event| event["kind"] == "tip_rupture"));
    let frames = ada.get(&format!("{api}/replay/frames")).await.body;
    let row = 4 * stage["columns"].as_array().unwrap().len();
    assert!(frames.len() > 60 * row && frames.len() % row == 0, "{} bytes in rows of {row}", frames.len());
    let part =
        Request::get(format!("{api}/replay/frames")).header(header::RANGE, format!("bytes={row}-{}", 2 * row - 1));
    let part = ada.send(part.body(Body::empty()).unwrap()).await;
    assert_eq!((part.status.as_u16(), part.body.as_slice()), (206, &frames[row..2 * row]));
    std::fs::remove_dir_all(&replays).unwrap();
    std::fs::create_dir(&replays).unwrap();
    assert_eq!(ada.get(&format!("{api}/replay/frames")).await.body, frames);
}

#[tokio::test]
async fn a_series_can_be_of_a_stretch() {
    let lesson = Lesson::new().await;
    let mut ada = lesson.app.with_token(&lesson.ada.token);
    let path = format!("/api/v1/sessions/{}/series", lesson.attempt);
    let spans = ada.get(&format!("{path}?points=20&from_s=0.4&to_s=0.6")).await.json()["spans"].clone();
    let times: Vec<f64> = spans.as_array().unwrap().iter().map(|span| span["t_s"].as_f64().unwrap()).collect();
    assert_eq!(times.len(), 20);
    assert!(times[0] <= 0.4 && times[0] > 0.37 && times[19] <= 0.61, "{times:?}");
    for (query, word) in [("from_s=x", "from_s"), ("to_s=NaN", "to_s"), ("from_s=2&to_s=1", "before from_s")] {
        ada.get(&format!("{path}?{query}")).await.is_problem(400, word);
    }
}

#[tokio::test]
async fn a_comment_is_shown_and_answered_by_the_trainee() {
    let lesson = Lesson::new().await;
    let mut teacher = lesson.app.signed_in("teacher@example.org").await;
    let said = lesson.say(&mut teacher, &WELL_HELD).await;
    assert_eq!(said.status, 303, "{}", said.text());
    let mut ada = lesson.app.signed_in("ada@example.org").await;
    let page = ada.get(&lesson.path("/replay")).await.text();
    assert!(page.contains("Well held") && page.contains("Praise") && page.contains("0.50"), "{page}");
    let answers = page.split("action=\"").find(|rest| rest.contains("/answers\"")).unwrap().split('"').next().unwrap();
    let answer = ada.form(answers, &[("csrf", &csrf_in(&page)), ("body", "Thank you")]).await;
    assert_eq!(answer.status, 303, "{}", answer.text());
    assert!(teacher.get(&lesson.path("/replay")).await.text().contains("Thank you"));
    let empty = ada.form(answers, &[("csrf", &csrf_in(&page)), ("body", " ")]).await;
    assert_eq!(empty.status, 422);
    let listed = lesson.app.with_token(&lesson.ada.token).get(&format!("/api/v1{}", lesson.path("/comments"))).await;
    let comments = listed.json()["comments"].clone();
    assert_eq!((&comments[0]["kind"], &comments[1]["answers"]), (&"praise".into(), &comments[0]["id"]), "{comments}");
}

#[tokio::test]
async fn a_comment_beyond_the_end_is_refused_and_what_was_typed_stays() {
    let lesson = Lesson::new().await;
    let mut teacher = lesson.app.signed_in("teacher@example.org").await;
    for (field, value) in [("from_s", "1000"), ("to_s", "1000"), ("from_s", "-1"), ("kind", "shout"), ("body", " ")] {
        let fields: Vec<_> =
            WELL_HELD.iter().copied().filter(|(name, _)| *name != field).chain([(field, value)]).collect();
        let refused = lesson.say(&mut teacher, &fields).await;
        assert_eq!(refused.status, 422, "{field}={value}");
        assert!(refused.text().contains("role=\"alert\""), "{}", refused.text());
        if field.ends_with("_s") {
            assert!(refused.text().contains("Well held") && refused.text().contains(&format!("value=\"{value}\"")));
        }
    }
    let page = teacher.get(&lesson.path("/replay")).await.text();
    assert!(page.contains("No comments on this attempt yet"), "nothing was kept: {page}");
    let mut by_token = lesson.app.with_token(&lesson.ada.token);
    let body = r#"{"kind":"question","from_s":1000,"body":"why"}"#;
    let request = Request::post(format!("/api/v1{}", lesson.path("/comments")))
        .header(header::CONTENT_TYPE, "application/json")
        .body(Body::from(body))
        .unwrap();
    by_token.send(request).await.is_problem(422, "within the attempt");
}

#[tokio::test]
async fn only_its_author_withdraws_a_comment_hidden_from_outsiders() {
    let lesson = Lesson::new().await;
    let mut teacher = lesson.app.signed_in("teacher@example.org").await;
    assert_eq!(lesson.say(&mut teacher, &WELL_HELD).await.status, 303);
    let page = teacher.get(&lesson.path("/replay")).await.text();
    let withdraw =
        page.split("action=\"").find(|rest| rest.contains("/withdraw\"")).unwrap().split('"').next().unwrap();
    let mut ada = lesson.app.signed_in("ada@example.org").await;
    let hers = ada.get(&lesson.path("/replay")).await.text();
    assert!(!hers.contains("/withdraw"), "a trainee takes back no teacher's words");
    assert_eq!(ada.form(withdraw, &[("csrf", &csrf_in(&hers))]).await.status, 404);
    let mut other = lesson.app.signed_in("other@example.org").await;
    assert_eq!(other.get(&lesson.path("/replay")).await.status, 404);
    let csrf = csrf_in(&other.get("/").await.text());
    let fields: Vec<_> = WELL_HELD.iter().copied().chain([("csrf", csrf.as_str())]).collect();
    assert_eq!(other.form(&lesson.path("/comments"), &fields).await.status, 404);
    assert_eq!(teacher.form(withdraw, &[("csrf", &csrf_in(&page))]).await.status, 303);
    assert!(!ada.get(&lesson.path("/replay")).await.text().contains("Well held"));
}

#[tokio::test]
async fn comments_are_added_to_a_copy_and_the_original_is_unchanged() {
    let lesson = Lesson::new().await;
    let mut ada = lesson.app.with_token(&lesson.ada.token);
    let path = format!("/api/v1{}", lesson.path("/recording"));
    let original = ada.get(&path).await.body;
    let mut teacher = lesson.app.signed_in("teacher@example.org").await;
    assert_eq!(lesson.say(&mut teacher, &WELL_HELD).await.status, 303);
    let copy = ada.get(&format!("{path}?with=comments")).await;
    assert_eq!(copy.status, 200, "{}", copy.text());
    let (original_read, copy) = (
        recording::Recording::read(original.as_slice()).unwrap(),
        recording::Recording::read(copy.body.as_slice()).unwrap(),
    );
    assert!(copy.complete && copy.samples == original_read.samples && copy.attachments == original_read.attachments);
    let remarks: Vec<_> = copy.events.iter().filter(|event| !original_read.events.contains(event)).collect();
    assert_eq!(remarks.len(), 1);
    assert_eq!(
        (remarks[0].text.as_str(), remarks[0].kind),
        ("praise by instructor: Well held", recording::EventKind::Coaching)
    );
    assert!(copy.events.is_sorted_by(|a, b| a.t_s <= b.t_s), "in chronological order");
    assert_eq!(ada.get(&path).await.body, original);
    ada.get(&format!("{path}?with=names")).await.is_problem(400, "with");
}

#[tokio::test]
async fn linked_recording_is_read_in_ranges_by_viewers_until_expiry() {
    let lesson = Lesson::with(Clock::fixed(Moment::from_micros(1_767_268_800_000_000))).await;
    let mut browser = lesson.app.signed_in("ada@example.org").await;
    let csrf = csrf_in(&browser.get(&lesson.path("/replay")).await.text());
    let page = browser.form(&lesson.path("/links"), &[("csrf", &csrf)]).await.text();
    let path = format!("/recordings/{}", page.split("/recordings/").nth(1).unwrap().split('<').next().unwrap());
    let mut stranger = lesson.app.stranger();
    let mut ask = async |method: &str, origin: &str| {
        let request = Request::builder().method(method).uri(&path).header(header::ORIGIN, origin);
        let request = request.header(header::RANGE, "bytes=0-7").body(Body::empty()).unwrap();
        stranger.send(request).await
    };
    for origin in ["https://app.foxglove.dev", "https://lichtblick-suite.github.io", "https://app.rerun.io"] {
        let answer = ask("GET", origin).await;
        assert_eq!((answer.status.as_u16(), answer.body.as_slice()), (206, b"\x89MCAP0\r\n".as_slice()));
        assert_eq!(answer.header("access-control-allow-origin"), origin);
        assert!(answer.header("access-control-expose-headers").contains("content-range"));
        let asked = ask("OPTIONS", origin).await;
        assert_eq!((asked.status.as_u16(), asked.header("access-control-allow-headers")), (204, "range"));
    }
    for elsewhere in ["https://evil.example", "https://app.foxglove.dev.evil.example", "null", "http://app.rerun.io"] {
        let answer = ask("GET", elsewhere).await;
        assert_eq!(
            (answer.header("access-control-allow-origin"), answer.header("vary")),
            ("", "origin"),
            "{elsewhere}"
        );
    }
    lesson.app.state.clock.advance(15 * 60);
    assert_eq!(ask("GET", "https://app.rerun.io").await.status, 404);
}
