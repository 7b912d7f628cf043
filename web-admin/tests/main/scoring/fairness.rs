//! Costly recordings of one school beside those of another. Fails when the other's wait for more than one deadline, or at all where there is
//! a second judge.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::time::Duration;

use model::ids::{SchoolId, SessionId};
use model::{Role, SessionKey};
use platform::clock::Clock;
use platform::helper::Helper;
use store::recordings::sessions;
use store::recordings::sessions::SessionState;
use web_admin::worker;

use crate::support::App;
use crate::support::recordings::{Attempt, record};

/// A judge who never comes to an end with what this folder names as costly, and notes what it is given to judge.
fn helper(folder: &Path, time: Duration) -> Helper {
    let program = folder.join("helper.sh");
    let (judge, log, costly) = (env!("CARGO_BIN_EXE_web-admin"), folder.join("log"), folder.join("costly"));
    let text = format!(
        "#!/bin/sh\nquestion=$(cat)\ncase \"$question\" in\n*Judge*\"$(cat {costly})\"*|*\"$(cat {costly})\"*Judge*) \
         echo costly >> {log}; exec sleep 1000 ;;\n*Judge*) echo other >> {log} ;;\nesac\n\
         printf %s \"$question\" | exec {judge} \"$@\"\n",
        costly = costly.display(),
        log = log.display()
    );
    std::fs::write(&program, text).unwrap();
    std::fs::write(&costly, "nothing yet").unwrap();
    std::fs::set_permissions(&program, PermissionsExt::from_mode(0o700)).unwrap();
    Helper { program, memory_mb: 2000, time }
}

/// How many of one school's ten costly jobs were begun before the one job of another, which is done.
async fn begun_before_the_other(judges: usize, deadline: Duration) -> usize {
    let place = tempfile::tempdir().unwrap();
    let app = App::with(Clock::system(), |config| {
        config.helper = Some(helper(place.path(), deadline));
        config.judges = judges;
    })
    .await;
    let (north, south) = (app.school("North").await, app.school("South").await);
    std::fs::write(place.path().join("costly"), north.to_string()).unwrap();
    let (ada, eve) = (
        app.member(north, Role::Trainee, "ada@example.org").await.token,
        app.member(south, Role::Trainee, "eve@example.org").await.token,
    );
    for _ in 0..10 {
        assert_eq!(app.with_token(&ada).upload(&record(&Attempt::default())).await.status, 201);
    }
    let log = || std::fs::read_to_string(place.path().join("log")).unwrap_or_default();
    let worker = tokio::spawn(worker::run_worker(app.state.clone()));
    while log().is_empty() {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let attempt = Attempt::default();
    assert_eq!(app.with_token(&eve).upload(&record(&attempt)).await.status, 201);
    while !is_scored(&app, south, attempt.session_id).await {
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    worker.abort();
    log().lines().take_while(|&line| line == "costly").count()
}

async fn is_scored(app: &App, school_id: SchoolId, id: SessionId) -> bool {
    let key = SessionKey { school_id, id };
    let found = sessions::find_session(app.state.db.reader(), key.school_id, key.id).await.unwrap();
    found.is_some_and(|session| session.state == SessionState::Scored)
}

#[tokio::test]
async fn one_scorer_delays_another_school_by_one_costly_job_at_most() {
    assert_eq!(begun_before_the_other(1, Duration::from_secs(15)).await, 1);
}

#[tokio::test]
async fn with_two_judges_another_school_does_not_wait() {
    // The first costly job is still under way: its deadline is far away.
    assert_eq!(begun_before_the_other(2, Duration::from_secs(300)).await, 1);
}
