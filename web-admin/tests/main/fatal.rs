//! Recordings that kill whoever reads or judges them. Fails when one of them is tried for ever, is lost, holds the others up, or takes the
//! service with it.

use std::process::Command;
use std::time::Duration;

use axum::body::Body;
use axum::http::Request;
use serde_json::Value;
use web_admin::clock::Clock;
use web_admin::domain::{Moment, Role};
use web_admin::storage::scores::SessionKey;
use web_admin::storage::{jobs, tries, uploads as rows};
use web_admin::uploads;

use super::support::App;
use super::support::failing_disk::{FailingDisk, Fault};
use super::support::recordings::{Attempt, record};
use super::support::service::{Service, answer, founded};

/// Asks until something is so, for at most a minute.
fn within_a_minute(mut is_so: impl FnMut() -> bool) -> bool {
    (0..600).any(|_| {
        std::thread::sleep(Duration::from_millis(100));
        is_so()
    })
}

#[tokio::test]
async fn a_recording_that_kills_its_judge_is_set_aside_told_and_tried_again_only_when_asked() {
    let (folder, token) = founded().await;
    let attempt = Attempt::default();
    let bytes = record(&attempt);
    let (disk, service) = FailingDisk::under_service(folder.path());
    disk.fail(Fault::Broken, "judge");
    assert_eq!(answer(service.upload(&token, &bytes, bytes.len())).0, 201);
    let metrics = |service: &Service| answer(service.begin("GET /metrics HTTP/1.1", &token, &[])).1;
    assert!(within_a_minute(|| metrics(&service).contains("stylet_set_aside 1\n")), "{}", metrics(&service));
    let state = |service: &Service| {
        let ask = format!("GET /api/v1/sessions/{} HTTP/1.1", attempt.session_id);
        let told: Value = serde_json::from_str(&answer(service.begin(&ask, &token, &[])).1).unwrap();
        told["state"].as_str().unwrap().to_owned()
    };
    assert_eq!(state(&service), "pending", "it is kept, and the service lives");
    drop(service);
    let service = Service::start(folder.path());
    assert!(metrics(&service).contains("stylet_set_aside 1\n"), "nothing tries it again by itself");
    drop(service);
    disk.mend();
    let retry = ["retry", "--data-dir", folder.path().to_str().unwrap()];
    let retried = Command::new(env!("CARGO_BIN_EXE_web-admin")).args(retry).output().unwrap();
    assert!(String::from_utf8_lossy(&retried.stdout).starts_with("1 recordings"), "{retried:?}");
    let service = Service::start(folder.path());
    assert!(within_a_minute(|| state(&service) == "scored"), "a judge with memory scores it");
}

/// A service with two recordings in its queue, in order.
async fn two_jobs() -> (App, [SessionKey; 2]) {
    let app = App::with(Clock::fixed(Moment::from_micros(1_700_000_000_000_000)), |_| {}).await;
    let school_id = app.school("North").await;
    let mut ada = app.with_token(&app.member(school_id, Role::Trainee, "ada@example.org").await.token);
    let mut keys = Vec::new();
    for _ in 0..2 {
        let attempt = Attempt::default();
        assert_eq!(ada.upload(&record(&attempt)).await.status, 201);
        keys.push(SessionKey { school_id, id: attempt.session_id });
        app.state.clock.advance(1);
    }
    (app, [keys[0], keys[1]])
}

#[tokio::test]
async fn who_was_fatal_once_goes_last_and_a_stop_is_no_death() {
    let (app, [first, second]) = two_jobs().await;
    let due = async || jobs::due(app.state.db.reader(), app.state.clock.now()).await.unwrap().map(|job| job.session());
    let mut tx = app.state.db.write().await.unwrap();
    tries::begin_job(&mut tx, first).await.unwrap();
    tries::take_back(&mut tx).await.unwrap();
    assert_eq!(tries::count_deaths(&mut tx).await.unwrap(), []);
    tx.commit().await.unwrap();
    assert_eq!(due().await, Some(first), "it was asked to stop");
    let mut set_aside = Vec::new();
    for expected in [Some(second), Some(second)] {
        let mut tx = app.state.db.write().await.unwrap();
        tries::begin_job(&mut tx, first).await.unwrap();
        // As a start does after the service has died.
        set_aside = tries::count_deaths(&mut tx).await.unwrap();
        tx.commit().await.unwrap();
        assert_eq!(due().await, expected);
    }
    assert_eq!(set_aside.iter().map(|found| found.id).collect::<Vec<_>>(), [first.id]);
    web_admin::worker::work_off(&app.state).await.unwrap();
    assert_eq!(due().await, None, "set aside, it is due no more");
    assert_eq!(jobs::count(app.state.db.reader()).await.unwrap(), 1, "and it is kept");
}

#[tokio::test]
async fn a_job_does_not_wait_for_a_clock_that_was_set_back() {
    let (app, [first, _]) = two_jobs().await;
    let hour_ago = app.state.clock.now().plus_s(-3600);
    let due = jobs::due(app.state.db.reader(), hour_ago).await.unwrap();
    assert_eq!(due.map(|job| job.session()), Some(first));
}

#[tokio::test]
async fn an_upload_that_was_fatal_twice_is_kept_and_read_no_more() {
    let app = App::with(Clock::fixed(Moment::from_micros(1_700_000_000_000_000)), |_| {}).await;
    let school = app.school("North").await;
    let mut ada = app.with_token(&app.member(school, Role::Trainee, "ada@example.org").await.token);
    let bytes = record(&Attempt::default());
    let begin = Request::builder().method("POST").uri("/api/v1/uploads").header("tus-resumable", "1.0.0");
    let begun = ada.send(begin.header("upload-length", bytes.len()).body(Body::empty()).unwrap()).await;
    let place = begun.header("location").to_owned();
    let id = rows::all(app.state.db.reader()).await.unwrap()[0];
    let file = app.state.config.uploads_dir().join(format!("{id}.tus"));
    std::fs::write(&file, &bytes).unwrap();
    for _ in 0..2 {
        let mut tx = app.state.db.write().await.unwrap();
        sqlx::query("UPDATE uploads SET received = length").execute(&mut *tx).await.unwrap();
        tries::mark_upload(&mut tx, id, true).await.unwrap();
        tries::count_deaths(&mut tx).await.unwrap();
        tx.commit().await.unwrap();
    }
    let look = || Request::builder().method("HEAD").uri(&place).header("tus-resumable", "1.0.0");
    assert_eq!(ada.send(look().body(Body::empty()).unwrap()).await.status, 422);
    app.state.clock.advance(30 * 24 * 3600);
    uploads::tidy(&app.state).await.unwrap();
    let listed = async |client: &mut super::support::client::Client| {
        client.get("/api/v1/sessions").await.json()["sessions"].as_array().unwrap().len()
    };
    assert_eq!((listed(&mut ada).await, file.exists()), (0, true));
    let mut tx = app.state.db.write().await.unwrap();
    assert_eq!(tries::forgive(&mut tx, app.state.clock.now().plus_s(60)).await.unwrap(), 1);
    tx.commit().await.unwrap();
    uploads::tidy(&app.state).await.unwrap();
    assert_eq!((listed(&mut ada).await, file.exists()), (1, false), "asked to, the service takes it in");
}
