//! What programs read. Fails when a range is not the bytes asked for, when a peak is lost in a series, or when
//! somebody is sent to an exercise whose prerequisites are not mastered.

use axum::body::Body;
use axum::http::{Request, header};
use model::{Moment, Role};
use platform::clock::Clock;
use platform::config::Config;
use web_admin::worker::work_off_jobs;

use crate::support::App;
use crate::support::client::Client;
use crate::support::recordings::{Attempt, EXERCISE, record};

async fn trainee(app: &App) -> Client {
    let school = app.school("North").await;
    app.publish(school).await;
    app.with_token(&app.member(school, Role::Trainee, "ada@example.org").await.token)
}

#[tokio::test]
async fn a_recording_can_be_read_in_ranges() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    let attempt = Attempt::default();
    let bytes = record(&attempt);
    assert_eq!(ada.upload(&bytes).await.status, 201);
    let path = format!("/api/v1/sessions/{}/recording", attempt.session_id);
    let end = bytes.len() - 1;
    for (range, expected) in [
        ("bytes=0-9".to_owned(), &bytes[..10]),
        (format!("bytes={}-", bytes.len() - 5), &bytes[bytes.len() - 5..]),
        ("bytes=-7".to_owned(), &bytes[bytes.len() - 7..]),
        (format!("bytes=100-{}", end + 1000), &bytes[100..]),
    ] {
        let request = Request::get(&path).header(header::RANGE, &range).body(Body::empty()).unwrap();
        let answer = ada.send(request).await;
        assert_eq!((answer.status.as_u16(), answer.body.as_slice()), (206, expected), "{range}");
        assert!(answer.header("content-range").ends_with(&format!("/{}", bytes.len())), "{range}");
    }
    let beyond = format!("bytes={}-", bytes.len());
    let request = Request::get(&path).header(header::RANGE, beyond).body(Body::empty()).unwrap();
    assert_eq!(ada.send(request).await.status, 416);
}

#[tokio::test]
async fn a_series_keeps_the_peak_and_refuses_nonsense() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    let attempt = Attempt::default();
    let bytes = record(&attempt);
    assert_eq!(ada.upload(&bytes).await.status, 201);
    let path = format!("/api/v1/sessions/{}/series", attempt.session_id);
    let recorded = recording::Recording::read(bytes.as_slice()).unwrap();
    let peak_n = attempt::HandForces::measure(&recorded).iter().map(|hand| hand.force_n).fold(f64::MIN, f64::max);
    for points in [1_usize, 50, 1000] {
        let answer = ada.get(&format!("{path}?points={points}")).await.json();
        let spans = answer["spans"].as_array().unwrap();
        assert_eq!(spans.len(), points);
        let highest = spans.iter().map(|span| span["force_max_n"].as_f64().unwrap()).fold(f64::MIN, f64::max);
        assert_eq!(highest.to_bits(), peak_n.to_bits(), "{points} points");
    }
    for nonsense in ["0", "-1", "10001", "many", "1e3"] {
        ada.get(&format!("{path}?points={nonsense}")).await.is_problem(400, "from 1 to 10000");
    }
    assert_eq!(ada.get(&path).await.status, 200);
}

#[tokio::test]
async fn a_malformed_id_is_nobodys() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    for path in ["/sessions/x", "/sessions/0/score", "/exercises/none", "/nothing"] {
        ada.get(&format!("/api/v1{path}")).await.is_problem(404, "nothing was found");
    }
}

#[tokio::test]
async fn an_exercise_comes_with_its_documents() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    let answer = ada.get("/api/v1/exercises/feel-the-layers").await.json();
    assert_eq!(answer["exercise_toml"].as_str().unwrap().as_bytes(), EXERCISE.exercise_bytes);
    assert_eq!(answer["scene_toml"].as_str().unwrap().as_bytes(), EXERCISE.scene_bytes);
    assert_eq!(answer["exercise_sha256"], EXERCISE.exercise.sha256);
    let south = app.school("South").await;
    let mut abroad = app.with_token(&app.member(south, Role::Trainee, "eve@example.org").await.token);
    abroad.get("/api/v1/exercises/feel-the-layers").await.is_problem(404, "nothing was found");
}

/// Ids of the exercises that a trainee may train, and the one to do first.
async fn assigned(client: &mut Client) -> (Vec<String>, String) {
    let answer = client.get("/api/v1/me/assignments").await.json();
    let all = answer["assignments"].as_array().unwrap().clone();
    let id = |assignment: &serde_json::Value| assignment["exercise_id"].as_str().unwrap().to_owned();
    let next: Vec<String> = all.iter().filter(|a| a["next"] == true).map(id).collect();
    assert_eq!(next.len(), 1, "{answer}");
    (all.iter().map(id).collect(), next[0].clone())
}

#[tokio::test]
async fn what_comes_next_waits_for_what_comes_first() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    assert_eq!(assigned(&mut ada).await, (vec!["feel-the-layers".to_owned()], "feel-the-layers".to_owned()));
    for seed in 0..3 {
        let attempt = Attempt { seed, ..Attempt::default() };
        assert_eq!(ada.upload(&record(&attempt)).await.status, 201);
        work_off_jobs(&app.state).await.unwrap();
        let score = ada.get(&format!("/api/v1/sessions/{}/score", attempt.session_id)).await.json();
        assert_eq!(score["passed"], true, "the straight hand passes the first exercise: {score}");
    }
    let (open, next) = assigned(&mut ada).await;
    assert_eq!(open, ["stop-in-the-fat", "reach-the-muscle"]);
    assert_eq!(next, "stop-in-the-fat");
}

#[tokio::test]
async fn the_description_names_every_address() {
    let app = App::new().await;
    let description = app.stranger().get("/api/v1/openapi.json").await.json();
    for path in [
        "/sessions",
        "/sessions/{id}",
        "/sessions/{id}/score",
        "/uploads",
        "/uploads/{id}",
        "/stations/pair",
        "/stations/me",
        "/stations/sign-in",
        "/me/assignments",
        "/exercises",
        "/exercises/{id}",
    ] {
        assert!(description["paths"][path].is_object(), "{path} is missing");
    }
    assert!(description["paths"]["/sessions"]["post"].is_object());
    assert_eq!(description["components"]["securitySchemes"]["token"]["scheme"], "bearer");
}

#[tokio::test]
async fn whoever_keeps_the_service_running_is_answered() {
    let app = App::with(Clock::fixed(Moment::from_micros(1_790_000_000_000_000)), |_| {}).await;
    let mut ada = trainee(&app).await;
    assert_eq!(ada.upload(&record(&Attempt::default())).await.status, 201);
    let mut stranger = app.stranger();
    assert_eq!(stranger.get("/healthz").await.text(), "ok\n");
    assert_eq!(stranger.get("/readyz").await.text(), "ready\n");
    let metrics = stranger.get("/metrics").await.text();
    for line in ["stylet_jobs_waiting 1", "stylet_sessions{state=\"pending\"} 1", "status=\"2xx\"} 3"] {
        assert!(metrics.contains(line), "{line} is missing:\n{metrics}");
    }
    for (token, behind_tls, given, status) in [
        (None, true, None, 404),
        (Some("figures"), true, None, 401),
        (Some("figures"), true, Some("figurex"), 401),
        (Some("figures"), true, Some("figures"), 200),
    ] {
        let change =
            |config: &mut Config| (config.metrics_token, config.behind_tls) = (token.map(str::to_owned), behind_tls);
        let guarded = App::with(Clock::system(), change).await;
        let mut asker = guarded.stranger();
        asker.token = given.map(str::to_owned);
        assert_eq!(asker.get("/metrics").await.status, status, "{token:?} {given:?}");
    }
    app.state.db.close().await;
    // It is tried every few seconds, however often somebody asks.
    app.state.clock.advance(6);
    assert_eq!(stranger.get("/readyz").await.status, 503);
    let broken = stranger.get("/metrics").await;
    broken.is_problem(503, "is unavailable");
    assert!(!broken.text().to_lowercase().contains("pool"), "a user never sees the database: {}", broken.text());
}
