//! How long results take with 5 000 responses to 30 items. Ignored by default, for it only means something in release:
//! `cargo test --release -p web-admin -- --ignored --nocapture results_of_5_000`. Fails when the median passes 300 ms.

use std::fmt::Write;
use std::time::{Duration, Instant};

use assessment::questionnaire::Answer;
use scene::Instrument;
use sqlx::types::Json;
use web_admin::domain::survey::Identity;
use web_admin::domain::{Role, survey::ResponseState};
use web_admin::secret;
use web_admin::storage::audit::Actor;
use web_admin::storage::instruments;
use web_admin::storage::surveys::{self, NewResponse, NewSurvey, Response, Submission};

use super::support::App;

const RESPONSES: usize = 5_000;
const ITEMS: usize = 30;
const REPEATS: usize = 11;
const BAR: Duration = Duration::from_millis(300);

/// An instrument of thirty items in three scores.
fn document() -> String {
    let mut text = "id = \"long\"\ntitle = { en = \"Long\" }\nlanguages = [\"en\"]\nduration_min = 5\nsource = \"here\"\nlicence = \"any\"\n[[scale]]\nid = \"agree\"\nkind = \"likert\"\npoints = 5\n".to_owned();
    for item in 0..ITEMS {
        let _ = write!(text, "[[item]]\nid = \"q{item}\"\ntext = {{ en = \"Question {item}\" }}\nscale = \"agree\"\n");
    }
    for score in 0..3 {
        let items: Vec<String> = (0..10).map(|n| format!("\"q{}\"", score * 10 + n)).collect();
        let _ = write!(
            text,
            "[[score]]\nid = \"s{score}\"\ntitle = {{ en = \"Score {score}\" }}\nitems = [{}]\ncombine = \"mean\"\n",
            items.join(", ")
        );
    }
    text
}

#[tokio::test]
#[ignore = "a measurement, in release: cargo test --release -p web-admin -- --ignored --nocapture results_of_5_000"]
async fn results_of_5_000_responses_to_30_items_within_300_ms() {
    let app = App::new().await;
    let school_id = app.school("North").await;
    let teacher = app.member(school_id, Role::Instructor, "teacher@example.org").await;
    let (now, text) = (app.state.clock.now(), document());
    let instrument = Instrument::from_bytes("long", text.as_bytes()).unwrap();
    let survey_id = app
        .write(async |tx| {
            web_admin::surveys::publish_text(tx, school_id, (&instrument, text.as_bytes()), (Actor::CommandLine, now))
                .await
                .unwrap();
            let revision = instruments::current(&mut *tx, school_id, "long").await.unwrap().unwrap();
            let new = NewSurvey {
                school_id,
                revision_id: revision.id,
                title: "Long",
                owner_id: Some(teacher.person.id),
                identity: Identity::Anonymous,
                after_attempts: false,
                generated: true,
                opens_at: now,
                closes_at: None,
            };
            let survey_id = surveys::insert(tx, &new, now).await.unwrap();
            for n in 0..RESPONSES {
                let new = NewResponse {
                    school_id,
                    survey_id,
                    token_sha256: secret::token_sha256(&n.to_string()),
                    role: if n % 2 == 0 { "professional" } else { "trainee" },
                    label: None,
                    person_id: None,
                    session_id: None,
                    language: "en",
                    consented_at: Some(now),
                    expires_at: None,
                };
                let id = surveys::add(tx, &new).await.unwrap();
                let point = |item: usize| Some(Answer::Number(((n * 7 + item * n) % 5 + 1) as f64));
                let response = Response {
                    id,
                    school_id,
                    survey_id,
                    state: ResponseState::Begun,
                    person_id: None,
                    session_id: None,
                    language: "en".to_owned(),
                    answers: Json((0..ITEMS).map(point).collect()),
                    expires_at: None,
                };
                surveys::put_answers(tx, &response, now).await.unwrap();
                let submission = Submission { response: &response, identity: Identity::Anonymous, at: now };
                assert!(surveys::submit(tx, submission).await.unwrap());
            }
            survey_id
        })
        .await;
    let mut browser = app.signed_in("teacher@example.org").await;
    let mut times = Vec::new();
    for _ in 0..REPEATS {
        #[expect(clippy::disallowed_methods, reason = "this test measures")]
        let start = Instant::now();
        let page = browser.get(&format!("/surveys/{survey_id}/results")).await;
        times.push(start.elapsed());
        assert_eq!(page.status, 200, "{}", page.text());
    }
    times.sort();
    println!("results of {RESPONSES} responses to {ITEMS} items: median {:?} of {REPEATS}", times[REPEATS / 2]);
    assert!(times[REPEATS / 2] <= BAR, "{:?}", times[REPEATS / 2]);
}
