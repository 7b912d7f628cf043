//! Several services on one database. Fails when two of them do the same work, when nobody does that of one that has died, or when what comes
//! of the hands of one that was taken for dead counts.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::Duration;

use acts::auth::rate_limits;
use acts::replicas::{self, Colleagues, Duty};
use acts::scoring;
use model::Role;
use platform::config::Config;
use platform::locks::DataLock;
use serde_json::Value;
use store::locks::LockError;
use store::scoring::jobs;
use store::scoring::jobs::JobQuery;
use web_admin::{AppState, worker};

use crate::support::App;
use crate::support::database::program;
use crate::support::recordings::{Attempt, record};
use crate::support::service::{Service, answer, founded};

/// More looks than it takes until somebody silent is dead.
const LOOKS: usize = 10;

/// Another service on the same database.
async fn colleague(app: &App) -> AppState {
    AppState::open((*app.state.config).clone(), app.state.clock.clone()).await.unwrap()
}

/// Uploads so many attempts of one trainee.
async fn queue(app: &App, attempts: usize) {
    let school = app.school("North").await;
    let mut ada = app.with_token(&app.member(school, Role::Trainee, "ada@example.org").await.token);
    for _ in 0..attempts {
        assert_eq!(ada.upload(&record(&Attempt::default())).await.status, 201);
    }
}

async fn count(app: &App, what: &'static str) -> i64 {
    sqlx::query_scalar(what).fetch_one(app.state.db.reader()).await.unwrap()
}

const SCORED: &str = "SELECT count(*) FROM audit_log WHERE action = 'session.scored'";
const SCORES: &str = "SELECT count(*) FROM scores";

#[tokio::test]
async fn two_services_score_every_recording_once() {
    let app = App::new().await;
    queue(&app, 12).await;
    let other = colleague(&app).await;
    let (first, second) = futures::future::join(worker::work_off_jobs(&app.state), worker::work_off_jobs(&other)).await;
    first.unwrap();
    second.unwrap();
    assert_eq!((count(&app, SCORED).await, count(&app, SCORES).await), (12, 12));
    assert_eq!(jobs::count_jobs(app.state.db.reader()).await.unwrap(), 0);
}

#[tokio::test]
async fn lease_of_a_dead_service_passes_on_and_its_score_is_dropped() {
    let app = App::new().await;
    queue(&app, 1).await;
    let school = app.school("North").await;
    let other = colleague(&app).await;
    let due = JobQuery { now: app.state.clock.now(), deaths: 0 };
    let held = scoring::claim(&other, school, due).await.unwrap().unwrap();
    worker::work_off_jobs(&app.state).await.unwrap();
    assert_eq!(count(&app, SCORES).await, 0, "it is in other hands");
    let (mut ours, mut theirs) = (Colleagues::default(), Colleagues::default());
    for _ in 0..LOOKS {
        replicas::look_round(&other, &mut theirs).await.unwrap();
        replicas::look_round(&app.state, &mut ours).await.unwrap();
    }
    worker::work_off_jobs(&app.state).await.unwrap();
    assert_eq!(count(&app, SCORES).await, 0, "who is heard is not dead");
    for _ in 0..LOOKS {
        replicas::look_round(&app.state, &mut ours).await.unwrap();
    }
    worker::work_off_jobs(&app.state).await.unwrap();
    assert_eq!(count(&app, SCORES).await, 1, "who is silent is");
    scoring::score_recording(&other, &held).await.unwrap();
    assert_eq!(
        (count(&app, SCORED).await, count(&app, SCORES).await),
        (1, 1),
        "it was only held up, and comes too late"
    );
}

#[tokio::test]
async fn one_service_holds_a_duty_until_it_leaves_or_dies() {
    let app = App::new().await;
    let other = colleague(&app).await;
    let on_duty = async || {
        let first = replicas::is_on_duty(&app.state, Duty::Letters).await.unwrap();
        [first, replicas::is_on_duty(&other, Duty::Letters).await.unwrap()]
    };
    assert_eq!(on_duty().await, [true, false]);
    assert_eq!(on_duty().await, [true, false], "and goes on");
    replicas::leave(&app.state).await.unwrap();
    assert!(replicas::is_on_duty(&other, Duty::Letters).await.unwrap());
    assert_eq!(on_duty().await, [false, true]);
    replicas::mark_others_dead(&app.state).await.unwrap();
    assert_eq!(on_duty().await, [true, false]);
}

#[tokio::test]
async fn who_guesses_has_no_more_tries_at_two_services_than_at_one() {
    let app = App::new().await;
    let other = colleague(&app).await;
    let mut taken = 0;
    for n in 0..40 {
        let state = if n % 2 == 0 { &app.state } else { &other };
        taken += u32::from(
            rate_limits::take_sign_in(state, [192, 0, 2, 1].into(), "ada@example.org", Vec::new()).await.is_ok(),
        );
    }
    assert!((10..12).contains(&taken), "{taken} of 40 were taken");
}

/// Ends the connections of whoever has joined, as a server does that is started anew.
async fn forget_joined(app: &App) {
    let forget = "SELECT pg_terminate_backend(pid, 5000) FROM pg_stat_activity
                  WHERE datname = current_database() AND application_name LIKE 'web-admin serve%'";
    sqlx::query(forget).execute(app.state.db.reader()).await.unwrap();
}

#[tokio::test]
async fn lost_lock_is_rejoined_unless_another_holds_the_database() {
    only_on!(Postgres, "about a server");
    let app = App::new().await;
    let (ours, theirs) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let config = |folder: &tempfile::TempDir| Config {
        database: app.state.config.database.clone(),
        ..Config::in_folder(folder.path())
    };
    let now = app.state.clock.now();
    let mut served = DataLock::join(&config(&ours), "web-admin serve", now).await.unwrap();
    forget_joined(&app).await;
    served.rejoin_if_lost().await.unwrap();
    let refused = DataLock::take(&config(&theirs), "web-admin restore", now).await.unwrap_err().to_string();
    assert!(refused.contains("web-admin serve"), "{refused}");
    forget_joined(&app).await;
    let _taken = DataLock::take(&config(&theirs), "web-admin restore", now).await.unwrap();
    let late = served.rejoin_if_lost().await.unwrap_err();
    assert!(matches!(&late, LockError::Held { holder, .. } if holder.contains("web-admin restore")), "{late}");
}

#[tokio::test]
async fn unavailable_database_gives_503_and_a_retry_time() {
    let app = App::new().await;
    let token = app.member(app.school("North").await, Role::Trainee, "ada@example.org").await.token;
    let mut browser = app.signed_in("ada@example.org").await;
    app.state.db.close().await;
    let answer = app.with_token(&token).get("/api/v1/sessions").await;
    assert_eq!(answer.header("retry-after"), "5");
    answer.is_problem(503, "the database is unavailable");
    let page = browser.get("/").await;
    assert!(page.status == 503 && page.text().contains("database is unavailable"), "{}", page.text());
    let mut stranger = app.stranger();
    assert_eq!(
        [stranger.get("/healthz").await.status, stranger.get("/readyz").await.status].map(|status| status.as_u16()),
        [200, 503]
    );
}

/// What has become of the only attempt.
fn state_of_attempt(service: &Service, token: &str) -> String {
    let (status, body) = answer(service.begin("GET /api/v1/sessions HTTP/1.1", token, &[]));
    assert_eq!(status, 200, "{body}");
    let list: Value = serde_json::from_str(&body).unwrap();
    list["sessions"][0]["state"].as_str().unwrap().to_owned()
}

#[tokio::test]
async fn a_service_without_judges_leaves_scoring_to_one_without_pages() {
    let (folder, token) = founded().await;
    let log = folder.path().join("log");
    let pages = ["--judges", "0"];
    let service = Service::start_logging(folder.path(), &pages, &log);
    let bytes = record(&Attempt::default());
    assert_eq!(answer(service.upload(&token, &bytes, bytes.len())).0, 201);
    std::thread::sleep(Duration::from_secs(2));
    assert_eq!(state_of_attempt(&service, &token), "pending");
    let work = || program(folder.path()).arg("work").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let refused = work().unwrap().wait_with_output().unwrap();
    assert!(
        String::from_utf8_lossy(&refused.stderr).contains("web-admin serve"),
        "one folder of recordings, one service: {refused:?}"
    );
    drop(service);
    let mut worker = work().unwrap();
    let mut lines = BufReader::new(worker.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.contains("recording scored")));
    assert!(Command::new("kill").args(["-TERM", &worker.id().to_string()]).status().unwrap().success());
    let ended = worker.wait_with_output().unwrap();
    assert!(ended.status.success() && ended.stdout == b"Working\n", "{ended:?}");
    assert_eq!(state_of_attempt(&Service::start_logging(folder.path(), &pages, &log), &token), "scored");
}
