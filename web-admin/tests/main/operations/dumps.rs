//! What `pg_dump` has made is checked before it is needed. Fails when a dump passes that lacks rows, or whose recordings are not in the
//! store, and when a database that was made to look at it stays on the server.

use std::path::Path;
use std::process::Command;

use model::Role;
use store::Connection;

use crate::support::database::{connect, drop_trigger, shrink_audit_log, url_of};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, web_admin};

/// Both tests share a server, of which each asks which databases are on it.
static ON_THE_SERVER: tokio::sync::Mutex<()> = tokio::sync::Mutex::const_new(());

/// Dumps the database of a folder.
fn dump(folder: &Path, to: &Path) {
    let url = url_of(folder);
    let dumped =
        Command::new("pg_dump").args(["--format=custom", "--dbname", &url, "--file"]).arg(to).output().unwrap();
    assert!(dumped.status.success(), "{}", String::from_utf8_lossy(&dumped.stderr));
}

/// What a look at a dump says, and how it ends.
fn look(folder: &Path, dump: &Path) -> (Option<i32>, String) {
    let output = web_admin(folder, &["verify", "--dump", dump.to_str().unwrap()]);
    let words = [String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr)].concat();
    assert!(!words.contains("secret"), "{words}");
    (output.status.code(), words)
}

async fn left_databases(connection: &mut Connection) -> i64 {
    let left = "SELECT count(*) FROM pg_database WHERE datname LIKE 'stylet_dump_%'";
    sqlx::query_scalar(left).fetch_one(connection).await.unwrap()
}

#[tokio::test]
async fn dump_is_verified_with_recordings_and_leaves_no_database() {
    only_on!(Postgres, "about a server");
    let _alone = ON_THE_SERVER.lock().await;
    let app = App::new().await;
    let school = app.school("North").await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    assert_eq!(app.with_token(&ada.token).upload(&record(&Attempt::default())).await.status, 201);
    let (folder, file) = (app.folder.path(), app.folder.path().join("school.dump"));
    dump(folder, &file);
    // What comes afterwards is nothing that the dump should have.
    assert_eq!(app.with_token(&ada.token).upload(&record(&Attempt::default())).await.status, 201);
    let (code, words) = look(folder, &file);
    assert!(code == Some(0) && words.contains("1 recordings and ") && words.contains(" 0 findings"), "{words}");
    assert!(web_admin(folder, &["verify"]).status.success(), "what is served is as it was");
    let mut connection = connect(folder).await;
    assert_eq!(left_databases(&mut connection).await, 0);
    for path in app.files().iter().filter(|path| path.extension().is_some_and(|e| e == "mcap")) {
        std::fs::remove_file(app.state.config.recordings_dir.join(path)).unwrap();
    }
    let (code, words) = look(folder, &file);
    assert!(code == Some(1) && words.contains("1 findings") && words.contains(".mcap: "), "{words}");
    assert_eq!(left_databases(&mut connection).await, 0);
}

#[tokio::test]
async fn a_dump_that_lacks_something_is_found() {
    only_on!(Postgres, "about a server");
    let _alone = ON_THE_SERVER.lock().await;
    let app = App::new().await;
    let school = app.school("North").await;
    for email in ["ada@example.org", "ben@example.org"] {
        app.member(school, Role::Trainee, email).await;
    }
    let (folder, file) = (app.folder.path(), app.folder.path().join("school.dump"));
    let mut connection = connect(folder).await;
    sqlx::raw_sql(drop_trigger("scores_never_go", "scores")).execute(&mut connection).await.unwrap();
    shrink_audit_log(&mut connection, "DELETE FROM audit_log WHERE seq = 1").await;
    dump(folder, &file);
    let (code, words) = look(folder, &file);
    assert!(
        code == Some(1) && words.contains("row 1 is missing") && words.contains("trigger scores_never_go"),
        "{words}"
    );
    let bytes = std::fs::read(&file).unwrap();
    for broken in [&bytes[..bytes.len() / 2], b"no dump at all"] {
        std::fs::write(&file, broken).unwrap();
        let (code, words) = look(folder, &file);
        assert!(code == Some(2) && words.contains("school.dump: pg_restore"), "{words}");
    }
    let (code, words) = look(folder, &folder.join("nothing.dump"));
    assert!(code == Some(2) && words.contains("nothing.dump"), "{words}");
}
