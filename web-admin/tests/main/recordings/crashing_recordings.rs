//! Recordings that kill whoever reads or judges them. Fails when one of them is tried for ever, is lost, holds the others up, or takes the
//! service with it.

use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use acts::recordings::uploads;
use acts::sandbox_jobs::{Brief, JudgingTask, SandboxRequest, SandboxResponse};
use acts::{replicas, sandbox_jobs};
use axum::body::Body;
use axum::http::Request;
use data_encoding::HEXLOWER;
use model::{Moment, Role, SessionKey};
use platform::clock::Clock;
use platform::fail_points;
use platform::fail_points::FailPoint;
use platform::helper::Helper;
use serde_json::Value;
use sha2::{Digest, Sha256};
use store::Connection;
use store::recordings::{parse_attempts, uploads as rows};
use store::scoring::jobs;
use store::scoring::jobs::{JobHold, JobReturn};

use crate::people::send;
use crate::support::failing_disk::{FailingDisk, Fault};
use crate::support::recordings::{Attempt, record};
use crate::support::service::{Service, answer, founded};
use crate::support::{App, web_admin};

/// Asks until something is so, for at most a minute.
fn within_a_minute(mut is_so: impl FnMut() -> bool) -> bool {
    (0..600).any(|_| {
        std::thread::sleep(Duration::from_millis(100));
        is_so()
    })
}

#[tokio::test]
async fn recording_that_crashes_its_scorer_is_quarantined_until_retry() {
    let (folder, token) = founded().await;
    let attempt = Attempt::default();
    let bytes = record(&attempt);
    let (disk, service) = FailingDisk::under_service(folder.path());
    // It reads what arrives, for 60 s at most, and dies of judging it, for which it has 30, and 300 then.
    disk.fail(Fault::Broken, "judge/30");
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
    let retried = web_admin(folder.path(), &["retry"]);
    assert!(String::from_utf8_lossy(&retried.stdout).starts_with("released 1 recordings"), "{retried:?}");
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

/// Takes the job that is due first; dropped without a commit, it is nobody's.
async fn claim_first(app: &App, tx: &mut Connection, now: Moment) -> Option<JobHold> {
    for deaths in 0..parse_attempts::MAX_CRASHES {
        let due = jobs::JobQuery { now, deaths };
        for school in jobs::list_waiting_schools(&mut *tx, due).await.unwrap() {
            if let Some(job) = jobs::claim_due_job(tx, school, due, app.state.replica).await.unwrap() {
                return Some(job.held_by(app.state.replica));
            }
        }
    }
    None
}

/// The job that is due first.
async fn due_first(app: &App, now: Moment) -> Option<SessionKey> {
    let mut tx = app.state.db.write().await.unwrap();
    claim_first(app, &mut tx, now).await.map(|hold| hold.session)
}

/// Begins a job, whichever is due before it.
async fn begin(app: &App, wanted: SessionKey) {
    let mut tx = app.state.db.write().await.unwrap();
    let mut held = Vec::new();
    while let Some(hold) = claim_first(app, &mut tx, app.state.clock.now()).await {
        held.push(hold);
    }
    for hold in held {
        let done = match hold.session == wanted {
            true => jobs::begin_job_try(&mut tx, hold).await,
            false => jobs::return_job(&mut tx, hold, JobReturn::Untried).await,
        };
        assert!(done.unwrap());
    }
    tx.commit().await.unwrap();
}

/// The service dies, and another finds what it has left.
async fn die(app: &App) -> Vec<parse_attempts::QuarantinedItem> {
    app.write(async |tx| parse_attempts::bury_replica(tx, app.state.replica).await.unwrap()).await;
    parse_attempts::list_quarantined(app.state.db.reader()).await.unwrap()
}

#[tokio::test]
async fn who_was_fatal_once_goes_last_and_a_stop_is_no_death() {
    let (app, [first, second]) = two_jobs().await;
    let due = async || due_first(&app, app.state.clock.now()).await;
    begin(&app, first).await;
    assert_eq!(due().await, Some(second), "what is held is not due");
    replicas::leave(&app.state).await.unwrap();
    assert_eq!(die(&app).await, []);
    assert_eq!(due().await, Some(first), "it was asked to stop");
    begin(&app, first).await;
    assert_eq!((die(&app).await, due().await), (Vec::new(), Some(second)), "whoever was fatal goes last");
    begin(&app, first).await;
    let set_aside = die(&app).await;
    assert_eq!(set_aside.iter().map(|found| found.id).collect::<Vec<_>>(), [first.id.uuid()]);
    worker::work_off_jobs(&app.state).await.unwrap();
    assert_eq!(due().await, None, "set aside, it is due no more");
    assert_eq!(jobs::count_jobs(app.state.db.reader()).await.unwrap(), 1, "and it is kept");
}

#[tokio::test]
async fn a_job_does_not_wait_for_a_clock_that_was_set_back() {
    let (app, [first, _]) = two_jobs().await;
    let hour_ago = app.state.clock.now().plus_s(-3600);
    assert_eq!(due_first(&app, hour_ago).await, Some(first));
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
    let id = rows::list_uploads(app.state.db.reader()).await.unwrap()[0];
    let file = app.state.config.uploads_dir().join(format!("{id}.tus"));
    std::fs::write(&file, &bytes).unwrap();
    for _ in 0..2 {
        let mut tx = app.state.db.write().await.unwrap();
        sqlx::query("UPDATE uploads SET received = length").execute(&mut *tx).await.unwrap();
        assert!(parse_attempts::hold_upload(&mut tx, id, app.state.replica).await.unwrap());
        parse_attempts::bury_replica(&mut tx, app.state.replica).await.unwrap();
        tx.commit().await.unwrap();
    }
    let look = || Request::builder().method("HEAD").uri(&place).header("tus-resumable", "1.0.0");
    assert_eq!(ada.send(look().body(Body::empty()).unwrap()).await.status, 424);
    app.state.clock.advance(30 * 24 * 3600);
    uploads::tidy(&app.state).await.unwrap();
    let listed = async |client: &mut crate::support::client::Client| {
        client.get("/api/v1/sessions").await.json()["sessions"].as_array().unwrap().len()
    };
    assert_eq!((listed(&mut ada).await, file.exists()), (0, true));
    let mut tx = app.state.db.write().await.unwrap();
    assert_eq!(parse_attempts::forgive_deaths(&mut tx, app.state.clock.now().plus_s(60)).await.unwrap(), 1);
    tx.commit().await.unwrap();
    uploads::tidy(&app.state).await.unwrap();
    assert_eq!((listed(&mut ada).await, file.exists()), (1, false), "asked to, the service takes it in");
}

/// A helper that does as a script says with questions that hold a word, and as it should with others.
fn helper(folder: &Path, word: &str, script: &str) -> Helper {
    let program = folder.join("helper.sh");
    let judge = env!("CARGO_BIN_EXE_web-admin");
    let text = format!(
        "#!/bin/sh\nquestion=$(cat)\ncase \"$question\" in\n*'{word}'*) {script} ;;\n\
         *) printf %s \"$question\" | exec {judge} \"$@\" ;;\nesac\n"
    );
    std::fs::write(&program, text).unwrap();
    std::fs::set_permissions(&program, PermissionsExt::from_mode(0o700)).unwrap();
    Helper { program, memory_mb: 2000, time: Duration::from_secs(60) }
}

#[tokio::test]
async fn upload_that_crashes_its_reader_is_read_twice_at_most() {
    let place = tempfile::tempdir().unwrap();
    let (asked, program) = (place.path().join("asked"), place.path().to_owned());
    let app = App::with(Clock::system(), |config| {
        let script = format!("echo >> {}; kill -KILL $$", asked.display());
        config.helper = Some(helper(&program, "Arrival", &script));
    })
    .await;
    let school = app.school("North").await;
    let mut ada = app.with_token(&app.member(school, Role::Trainee, "ada@example.org").await.token);
    let bytes = record(&Attempt::default());
    let tries_made = || std::fs::read_to_string(&asked).unwrap_or_default().lines().count();
    for made in 1..=2 {
        let answer = ada.upload(&bytes).await;
        answer.is_problem(503, "quarantined");
        assert_eq!((answer.header("retry-after"), tries_made()), ("10", made));
    }
    ada.upload(&bytes).await.is_problem(424, "crashed its reader twice");
    assert_eq!(tries_made(), 2, "it is read no more");
    let metrics = app.stranger().get("/metrics").await.text();
    assert!(metrics.contains("stylet_set_aside 1\n"), "{metrics}");
    assert!(app.files().is_empty(), "{:?}", app.files());
    app.write(async |tx| parse_attempts::forgive_deaths(tx, app.state.clock.now()).await.unwrap()).await;
    helper(&program, "nothing such", "exit 1");
    assert_eq!(ada.upload(&bytes).await.status, 201, "asked to, the service tries it again");
    let left: i64 = sqlx::query_scalar("SELECT count(*) FROM readings").fetch_one(app.state.db.reader()).await.unwrap();
    assert_eq!(left, 0, "what its reader outlives is forgotten");
}

#[tokio::test]
async fn workbook_that_exhausts_memory_is_rejected_without_a_crash() {
    let app = App::with(Clock::system(), |config| {
        let program = env!("CARGO_BIN_EXE_web-admin").into();
        config.helper = Some(Helper { program, memory_mb: 300, time: Duration::from_secs(60) });
    })
    .await;
    let school = app.school("North").await;
    app.member(school, Role::Administrator, "head@example.org").await;
    let mut head = app.signed_in("head@example.org").await;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/rosters");
    // 20 000 formats of cells share a font with a name of 4 MB, which the library copies for each: 80 GB from 11 kB.
    let refused = send(&mut head, &std::fs::read(folder.join("fonts.xlsx")).unwrap(), &[]).await;
    assert_eq!(refused.status, 422);
    assert!(refused.text().contains("the workbook is too large"), "{}", refused.text());
    assert_eq!(send(&mut head, &std::fs::read(folder.join("excel.xlsx")).unwrap(), &[]).await.status, 303);
}

#[tokio::test]
async fn service_crash_during_reading_quarantines_no_recording() {
    let (folder, token) = founded().await;
    let bytes = record(&Attempt::default());
    for _ in 0..3 {
        let kill_at = Path::new(FailPoint::ReadingBegun.name());
        let mut service = Service::start_with(folder.path(), &[(fail_points::VARIABLE, kill_at)]);
        let _sent = service.upload(&token, &bytes, bytes.len());
        assert!(within_a_minute(|| service.child.try_wait().unwrap().is_some()));
    }
    let service = Service::start(folder.path());
    let (status, body) = answer(service.upload(&token, &bytes, bytes.len()));
    assert_eq!(status, 201, "{body}");
}

/// Asks a judge that has so much memory; none where it dies.
fn asked(question: &SandboxRequest, memory_mb: u64) -> Option<SandboxResponse> {
    let mut child = Command::new(env!("CARGO_BIN_EXE_web-admin"))
        .args(["judge", "--seconds", "60", "--memory-mb", &memory_mb.to_string()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let question = serde_json::to_vec(question).unwrap();
    // Who has died already does not listen.
    let _ = child.stdin.take().unwrap().write_all(&question);
    let output = child.wait_with_output().unwrap();
    serde_json::from_slice(&output.stdout).ok().filter(|_| output.status.success())
}

/// Whatever memory runs out first, it is not the recording that is damaged.
#[test]
fn with_whatever_memory_nobody_calls_a_recording_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let (mut judged, mut died) = (0, 0);
    for depth_mm in [4.0, 18.0] {
        let path = folder.path().join("attempt.mcap");
        let bytes = record(&Attempt { depth_mm, ..Attempt::default() });
        std::fs::write(&path, &bytes).unwrap();
        let sha256 = HEXLOWER.encode(&Sha256::digest(&bytes));
        for memory_mb in (1..16).chain([400]) {
            let (recording, replay) = (path.clone(), folder.path().join(format!("{depth_mm}-{memory_mb}")));
            let brief = Brief { recording, sha256: sha256.clone(), replay, task: JudgingTask::Judge(None) };
            for question in [SandboxRequest::Recording(brief), SandboxRequest::Arrival(path.clone())] {
                match asked(&question, memory_mb) {
                    Some(SandboxResponse::Judged(_) | SandboxResponse::Metadata(_)) => judged += 1,
                    None | Some(SandboxResponse::Died(_)) => died += 1,
                    other => panic!("{depth_mm} mm, {memory_mb} MB: {other:?}"),
                }
            }
        }
    }
    assert!(judged > 3 && died > 3, "{judged} judged, {died} died");
}

#[tokio::test]
async fn accepted_recording_is_quarantined_and_a_changed_one_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("attempt.mcap");
    std::fs::write(&path, "not a recording").unwrap();
    let brief = |sha256: &str| {
        let (recording, replay) = (path.clone(), folder.path().join("replay"));
        SandboxRequest::Recording(Brief {
            recording,
            sha256: sha256.to_owned(),
            replay,
            task: JudgingTask::Judge(None),
        })
    };
    let answer = |arrived: &str| {
        sandbox_jobs::answer(brief(&HEXLOWER.encode(&Sha256::digest(arrived))), sandbox_jobs::leave_unexamined)
    };
    let same = answer("not a recording");
    assert!(matches!(&same, SandboxResponse::Died(why) if why.contains("it was read when it arrived")), "{same:?}");
    let changed = answer("a recording");
    assert!(matches!(&changed, SandboxResponse::Permanent(why) if why.contains("not what has arrived")), "{changed:?}");
}
