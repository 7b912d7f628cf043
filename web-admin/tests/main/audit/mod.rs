//! The audit log only grows, and a change to it shows. Fails when a statement can alter a row, or when a row that was
//! altered behind the triggers' back goes unnoticed.

pub(crate) mod checkpoints;
pub(crate) mod page;

use acts::operations::verification;
use model::Role;
use sqlx::SqlSafeStr;
use store::EngineKind;
use store::audit::check_audit_chain;

use crate::support::App;
use crate::support::database::{drop_trigger, engine};
use crate::support::recordings::{Attempt, record};

async fn with_some_rows() -> App {
    let app = App::new().await;
    let school = app.school("North").await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    app.signed_in("ada@example.org").await;
    assert_eq!(app.with_token(&ada.token).upload(&record(&Attempt::default())).await.status, 201);
    app
}

async fn execute(app: &App, statement: impl SqlSafeStr) -> Result<(), sqlx::Error> {
    let mut tx = app.state.db.write().await.unwrap();
    sqlx::raw_sql(statement).execute(&mut *tx).await?;
    tx.commit().await
}

#[tokio::test]
async fn what_is_done_is_in_the_log_in_order() {
    let app = with_some_rows().await;
    let actions: Vec<String> =
        sqlx::query_scalar("SELECT action FROM audit_log ORDER BY seq").fetch_all(app.state.db.reader()).await.unwrap();
    assert_eq!(actions, ["person.added", "person.signed_in", "session.uploaded"]);
    let chain = check_audit_chain(app.state.db.reader()).await.unwrap();
    assert_eq!((chain.rows, chain.findings.len()), (3, 0), "{chain:?}");
}

#[tokio::test]
async fn no_statement_alters_or_deletes_a_row() {
    let app = with_some_rows().await;
    let replaced = match engine() {
        EngineKind::Postgres => "INSERT INTO audit_log SELECT * FROM audit_log WHERE seq = 2 ON CONFLICT (seq) DO UPDATE SET actor = 'nobody'",
        EngineKind::Sqlite => {
            "INSERT OR REPLACE INTO audit_log SELECT 2, at, school_id, 'nobody', action, object, details, prev_hash, hash
             FROM audit_log WHERE seq = 2"
        }
    };
    for statement in [
        replaced,
        "UPDATE audit_log SET actor = 'nobody' WHERE seq = 1",
        "DELETE FROM audit_log WHERE seq = 3",
        "INSERT INTO audit_log SELECT 9, at, school_id, actor, action, object, details, prev_hash, hash
         FROM audit_log WHERE seq = 3",
    ] {
        let refused = execute(&app, statement).await.unwrap_err().to_string();
        assert!(refused.contains("append-only"), "{statement}: {refused}");
    }
    assert!(check_audit_chain(app.state.db.reader()).await.unwrap().findings.is_empty());
}

#[tokio::test]
async fn a_row_changed_behind_the_triggers_back_is_found() {
    for (tampering, finding) in [
        ("UPDATE audit_log SET object = 'x' WHERE seq = 2", "row 2 was changed"),
        ("UPDATE audit_log SET prev_hash = hash WHERE seq = 2", "row 2 does not follow"),
        ("DELETE FROM audit_log WHERE seq = 2", "row 2 is missing"),
    ] {
        let app = with_some_rows().await;
        for trigger in ["audit_log_never_changes", "audit_log_never_shrinks"] {
            execute(&app, drop_trigger(trigger, "audit_log")).await.unwrap();
        }
        execute(&app, tampering).await.unwrap();
        let chain = check_audit_chain(app.state.db.reader()).await.unwrap();
        assert!(chain.findings.iter().any(|found| found.contains(finding)), "{tampering}: {chain:?}");
    }
}

#[tokio::test]
async fn a_dropped_trigger_and_a_cut_tail_are_found() {
    let app = with_some_rows().await;
    let reader = app.state.db.reader();
    let head = check_audit_chain(reader).await.unwrap().head;
    assert_eq!(app.state.db.lost_triggers().await.unwrap(), Vec::<String>::new());
    assert_eq!(verification::cut_tail(&app.state.db, &head).await.unwrap(), None);
    app.signed_in("ada@example.org").await;
    assert_eq!(verification::cut_tail(&app.state.db, &head).await.unwrap(), None, "a log that grew is whole");
    execute(&app, drop_trigger("audit_log_never_shrinks", "audit_log")).await.unwrap();
    execute(&app, "DELETE FROM audit_log WHERE seq >= 3").await.unwrap();
    assert!(check_audit_chain(reader).await.unwrap().findings.is_empty(), "the chain alone does not tell");
    let report = verification::everything(&app.state.db, &app.state.recordings).await.unwrap();
    assert!(report.findings.iter().any(|found| found.contains("audit_log_never_shrinks")), "{report:?}");
    let cut = verification::cut_tail(&app.state.db, &head).await.unwrap();
    assert!(cut.unwrap().contains(&head));
}

#[tokio::test]
async fn what_is_deleted_is_overwritten() {
    only_on!(Sqlite, "about SQLite's file");
    let app = App::new().await;
    let mut tx = app.state.db.write().await.unwrap();
    let secure: i64 = sqlx::query_scalar("PRAGMA secure_delete").fetch_one(&mut *tx).await.unwrap();
    assert_eq!(secure, 1);
}

#[tokio::test]
async fn scores_and_revisions_stay_as_they_are() {
    let app = with_some_rows().await;
    let school = app.school("North").await;
    app.publish(school).await;
    worker::work_off_jobs(&app.state).await.unwrap();
    for statement in [
        "UPDATE scores SET score = 100",
        "DELETE FROM scores",
        "UPDATE exercise_revisions SET title = ''",
        "DELETE FROM exercise_revisions",
        "UPDATE curriculum_revisions SET title = ''",
        "DELETE FROM curriculum_revisions",
    ] {
        assert!(
            execute(&app, statement).await.unwrap_err().to_string().contains("never")
                || execute(&app, statement).await.unwrap_err().to_string().contains("re-grading"),
            "{statement}"
        );
    }
}
