//! The server's own reading of a recording decides. Fails when the published exercise does not judge, when a forged
//! force goes unnoticed, when a failure that may pass is final, or when a cut recording is not scored.

pub(crate) mod exam_files;
pub(crate) mod exams;
pub(crate) mod experts;
pub(crate) mod fairness;
pub(crate) mod ratings;
pub(crate) mod regrading;
pub(crate) mod review;
pub(crate) mod segments;

use std::fs;

use model::ids::SessionId;
use model::{Moment, Role, SessionKey};
use platform::clock::Clock;
use serde_json::Value;
use store::recordings::sessions;
use store::scoring::{grades, jobs, scores};
use web_admin::worker::work_off_jobs;

use crate::support::App;
use crate::support::client::Client;
use crate::support::recordings::{Attempt, EXERCISE, interrupted, record, tampered, without_samples};

/// A service with a published course and a trainee.
async fn school() -> (App, Client, SessionKey) {
    let app = App::with(Clock::fixed(Moment::from_micros(1_700_000_000_000_000)), |_| {}).await;
    let school_id = app.school("North").await;
    app.publish(school_id).await;
    let ada = app.member(school_id, Role::Trainee, "ada@example.org").await;
    let client = app.with_token(&ada.token);
    let key = SessionKey { school_id, id: Attempt::default().session_id };
    (app, client, key)
}

/// Uploads and works off; the session and the answer to a question for its score.
async fn scored(app: &App, client: &mut Client, (id, bytes): (SessionId, Vec<u8>)) -> (Value, Value) {
    let answer = client.upload(&bytes).await;
    assert_eq!(answer.status, 201, "{}", answer.text());
    let waiting = client.get(&format!("/api/v1/sessions/{id}/score")).await;
    assert_eq!((waiting.status.as_u16(), &waiting.json()["state"]), (202, &"pending".into()));
    work_off_jobs(&app.state).await.unwrap();
    assert_eq!(jobs::count_jobs(app.state.db.reader()).await.unwrap(), 0);
    let session = client.get(&format!("/api/v1/sessions/{id}")).await.json();
    (session, client.get(&format!("/api/v1/sessions/{id}/score")).await.json())
}

#[tokio::test]
async fn a_recording_becomes_the_score_that_the_library_gives_it() {
    let (app, mut ada, mut key) = school().await;
    let attempt = Attempt { session_id: key.id, ..Attempt::default() };
    let bytes = record(&attempt);
    let (session, score) = scored(&app, &mut ada, (attempt.session_id, bytes.clone())).await;
    assert_eq!((&session["state"], &session["unknown_exercise"]), (&"scored".into(), &false.into()));
    assert_eq!(session["verification"]["largest_deviation_n"], 0.0, "the server's own run is the same to the bit");
    assert_eq!(session["verification"]["flagged"], false);
    let recording = recording::Recording::read(bytes.as_slice()).unwrap();
    let ours = assessment::assess(&recording, &EXERCISE).unwrap();
    let mut score = score;
    let proof = score.as_object_mut().and_then(|score| score.remove("proof")).unwrap();
    assert_eq!(proof, serde_json::json!({ "signed": false, "resimulated": true, "supervised": false }));
    assert_eq!(score, serde_json::to_value(&ours).unwrap());
    key.id = attempt.session_id;
    let curve = scores::find_curve(app.state.db.reader(), key).await.unwrap().unwrap();
    assert_eq!(curve, attempt::AttemptCurve::draw(&recording, &EXERCISE));
}

#[tokio::test]
async fn unpublished_exercise_is_scored_by_itself_and_flagged() {
    let app = App::new().await;
    let school = app.school("North").await;
    let token = app.member(school, Role::Trainee, "ada@example.org").await.token;
    let attempt = Attempt::default();
    let (session, score) = scored(&app, &mut app.with_token(&token), (attempt.session_id, record(&attempt))).await;
    assert_eq!((&session["state"], &session["unknown_exercise"]), (&"scored".into(), &true.into()));
    assert!(score["score"].is_number(), "{score}");
}

#[tokio::test]
async fn a_forged_force_is_flagged() {
    let (app, mut ada, _) = school().await;
    let attempt = Attempt::default();
    let (session, _) = scored(&app, &mut ada, (attempt.session_id, tampered(&attempt))).await;
    assert_eq!(session["verification"]["flagged"], true, "{session}");
    assert!(session["verification"]["largest_deviation_n"].as_f64().unwrap() > 1.0, "{session}");
}

#[tokio::test]
async fn a_cut_recording_is_scored_and_told_apart() {
    let (app, mut ada, _) = school().await;
    let attempt = Attempt::default();
    let whole = record(&attempt);
    let (session, score) = scored(&app, &mut ada, (attempt.session_id, whole[..whole.len() * 9 / 10].to_vec())).await;
    assert_eq!((&session["state"], &session["complete"]), (&"scored".into(), &false.into()), "{session}");
    assert!(score["score"].is_number(), "{score}");
}

#[tokio::test]
async fn truncated_recording_is_scored_or_rejected_with_a_reason() {
    let (app, mut ada, _) = school().await;
    let mut taken = 0;
    for tenth in 1..10 {
        let attempt = Attempt::default();
        let whole = record(&attempt);
        let answer = ada.upload(&whole[..whole.len() * tenth / 10]).await;
        if answer.status == 422 {
            assert!(!answer.json()["detail"].as_str().unwrap().is_empty());
            continue;
        }
        assert_eq!(answer.status, 201, "{}", answer.text());
        taken += 1;
        work_off_jobs(&app.state).await.unwrap();
        let session = ada.get(&format!("/api/v1/sessions/{}", attempt.session_id)).await.json();
        assert_eq!(session["complete"], false, "{session}");
        let told = session["state"] == "scored" || session["refusal"].is_string();
        assert!(told, "{tenth} tenths: {session}");
    }
    assert!(taken > 0, "not one cut recording was taken");
}

#[tokio::test]
async fn nothing_to_score_is_refused_with_the_reason() {
    let (app, mut ada, _) = school().await;
    let attempt = Attempt::default();
    let (session, score) = scored(&app, &mut ada, (attempt.session_id, without_samples(&attempt))).await;
    assert_eq!(session["state"], "refused");
    assert!(session["refusal"].as_str().unwrap().contains("cannot be scored"), "{session}");
    assert_eq!((&score["status"], score["detail"].as_str().unwrap().contains("cannot be scored")), (&404.into(), true));
}

#[tokio::test]
async fn attempt_ended_by_a_lost_device_is_kept_and_never_counts() {
    let (app, mut ada, key) = school().await;
    let attempt = Attempt { session_id: key.id, ..Attempt::default() };
    let (session, score) = scored(&app, &mut ada, (attempt.session_id, interrupted(&attempt))).await;
    assert_eq!(session["state"], "refused");
    assert_eq!(session["refusal"], "void: ended after 1.0 s: device lost: the device is gone");
    assert_eq!(score["status"], 404);
    assert_eq!(
        grades::find_grade(app.state.db.reader(), key).await.unwrap(),
        None,
        "no page, export or rule counts it"
    );
    let kept = ada.get(&format!("/api/v1/sessions/{}/recording", key.id)).await;
    assert_eq!(kept.status, 200, "it is kept");
}

#[tokio::test]
async fn transient_failure_is_retried_when_due() {
    let (app, mut ada, key) = school().await;
    let attempt = Attempt { session_id: key.id, ..Attempt::default() };
    assert_eq!(ada.upload(&record(&attempt)).await.status, 201);
    let path = app.state.config.recordings_dir.join(format!("{}/{}.mcap", key.school_id, key.id));
    let away = path.with_extension("away");
    fs::rename(&path, &away).unwrap();
    work_off_jobs(&app.state).await.unwrap();
    assert_eq!(jobs::count_jobs(app.state.db.reader()).await.unwrap(), 1, "it is put off");
    fs::rename(&away, &path).unwrap();
    work_off_jobs(&app.state).await.unwrap();
    assert_eq!(jobs::count_jobs(app.state.db.reader()).await.unwrap(), 1, "and not due yet");
    app.state.clock.advance(11);
    work_off_jobs(&app.state).await.unwrap();
    let found = sessions::find_session(app.state.db.reader(), key.school_id, key.id).await.unwrap().unwrap();
    assert_eq!(found.state, sessions::SessionState::Scored);
}

#[tokio::test]
async fn what_keeps_failing_is_refused() {
    let (app, mut ada, key) = school().await;
    assert_eq!(ada.upload(&record(&Attempt { session_id: key.id, ..Attempt::default() })).await.status, 201);
    fs::remove_file(app.state.config.recordings_dir.join(format!("{}/{}.mcap", key.school_id, key.id))).unwrap();
    for _ in 0..6 {
        work_off_jobs(&app.state).await.unwrap();
        app.state.clock.advance(3600);
    }
    assert_eq!(jobs::find_next_job_time(app.state.db.reader(), app.state.clock.now()).await.unwrap(), None);
    let found = sessions::find_session(app.state.db.reader(), key.school_id, key.id).await.unwrap().unwrap();
    assert!(found.refusal.unwrap().contains("6 tries"));
}

#[tokio::test]
async fn the_score_that_was_added_last_counts_whatever_the_clock_said() {
    let (app, mut ada, key) = school().await;
    let attempt = Attempt { session_id: key.id, ..Attempt::default() };
    let bytes = record(&attempt);
    scored(&app, &mut ada, (key.id, bytes.clone())).await;
    let recording = recording::Recording::read(bytes.as_slice()).unwrap();
    let mut again = assessment::assess(&recording, &EXERCISE).unwrap();
    again.score = 12.0;
    let mut tx = app.state.db.write().await.unwrap();
    scores::add_score(&mut tx, key, &again, app.state.clock.now().plus_s(-3600)).await.unwrap();
    tx.commit().await.unwrap();
    let reader = app.state.db.reader();
    let (newest, counts) =
        (scores::find_newest_score(reader, key).await.unwrap(), grades::find_grade(reader, key).await.unwrap());
    assert_eq!((newest.unwrap().score, counts.unwrap().score), (12.0, 12.0));
    let all: Vec<f64> = scores::list_scores(reader, key).await.unwrap().iter().map(|score| score.score).collect();
    assert_eq!((all.len(), all.last()), (2, Some(&12.0)));
}
