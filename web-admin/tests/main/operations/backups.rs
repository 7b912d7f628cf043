//! A backup made while the service runs brings everything back; what is damaged is neither served, backed up nor
//! restored. Fails when a backup lacks a recording, when a restore overwrites something or keeps half of it, or when a
//! flipped byte passes unnoticed.

use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::Duration;

use model::Role;
use platform::clock::Clock;
use platform::config::Config;
use store::audit;
use store::recordings::sessions;
use web_admin::AppState;

use crate::support::database::{config_in, drop_trigger};
use crate::support::recordings::{Attempt, record};
use crate::support::service::Service;
use crate::support::{App, web_admin};

/// Fails with a code and one line; the line.
fn refused(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = web_admin(folder, arguments);
    let words = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {words}");
    assert_eq!(words.trim_end().lines().count(), 1, "{arguments:?}: {words}");
    words
}

/// A running service with two attempts, and its backup.
struct Drill {
    app: App,
    attempts: Vec<Attempt>,
    backup: PathBuf,
}

impl Drill {
    async fn new() -> Self {
        let app = App::new().await;
        let school = app.school("North").await;
        let ada = app.member(school, Role::Trainee, "ada@example.org").await;
        let attempts: Vec<_> = (0..2).map(|_| Attempt::default()).collect();
        for attempt in &attempts {
            assert_eq!(app.with_token(&ada.token).upload(&record(attempt)).await.status, 201);
        }
        let backup = app.folder.path().join("backup.tar");
        Self { app, attempts, backup }
    }

    /// What the administrator reads of backups.
    async fn page_of_backups(&self) -> String {
        let school = self.app.school("South").await;
        self.app.member(school, Role::Administrator, "head@example.org").await;
        self.app.signed_in("head@example.org").await.get("/admin/backups").await.text()
    }

    fn back_up(&self) -> Output {
        web_admin(self.app.folder.path(), &["backup", "--to", self.backup.to_str().unwrap()])
    }

    fn restore_into(&self, folder: &Path) -> Output {
        web_admin(folder, &["restore", self.backup.to_str().unwrap()])
    }
}

#[tokio::test]
async fn a_backup_of_a_running_service_brings_everything_back() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let drill = Drill::new().await;
    let made = drill.back_up();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    assert!(String::from_utf8_lossy(&made.stdout).contains("2 recordings"));
    let place = tempfile::tempdir().unwrap();
    let restored = drill.restore_into(place.path());
    assert!(restored.status.success(), "{}", String::from_utf8_lossy(&restored.stderr));
    assert!(web_admin(place.path(), &["verify"]).status.success());
    let state = AppState::open(config_in(place.path()), Clock::system()).await.unwrap();
    let (old, new) = (drill.app.state.db.reader(), state.db.reader());
    assert_eq!(audit::check_audit_chain(old).await.unwrap(), audit::check_audit_chain(new).await.unwrap());
    let files = sessions::list_recordings(new).await.unwrap();
    assert_eq!(files, sessions::list_recordings(old).await.unwrap());
    for attempt in &drill.attempts {
        let file = files.iter().find(|file| file.id == attempt.session_id).unwrap();
        let bytes = |config: &Config| std::fs::read(config.recordings_dir.join(&file.recording_path)).unwrap();
        assert_eq!(bytes(&state.config), bytes(&drill.app.state.config));
    }
}

#[tokio::test]
async fn administrator_reads_time_and_size_of_the_last_backup() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let drill = Drill::new().await;
    assert!(drill.back_up().status.success());
    let page = drill.page_of_backups().await;
    let size = pages::format::format_size(std::fs::metadata(&drill.backup).unwrap().len().try_into().unwrap());
    assert!(page.contains("backup.tar") && page.contains("2 recordings") && page.contains(&size), "{page}");
    assert!(!page.contains("Tell the operator"), "{page}");
}

#[tokio::test]
async fn an_administrator_reads_why_a_backup_failed() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let drill = Drill::new().await;
    assert!(drill.page_of_backups().await.contains("There is no backup yet"));
    let file = drill.app.files().into_iter().find(|file| file.extension().is_some_and(|e| e == "mcap")).unwrap();
    std::fs::remove_file(drill.app.state.config.recordings_dir.join(&file)).unwrap();
    assert_eq!(drill.back_up().status.code(), Some(1));
    let page = drill.app.signed_in("head@example.org").await.get("/admin/backups").await.text();
    assert!(page.contains("Failed") && page.contains(file.file_name().unwrap().to_str().unwrap()), "{page}");
}

#[tokio::test]
async fn nothing_is_ever_overwritten() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let drill = Drill::new().await;
    let folder = drill.app.folder.path();
    assert!(drill.back_up().status.success());
    let to = drill.backup.to_str().unwrap();
    assert!(refused(folder, &["backup", "--to", to], 2).contains("never overwritten"));
    assert!(refused(folder, &["restore", to], 2).contains("never over data"));
    let place = tempfile::tempdir().unwrap();
    std::fs::create_dir(place.path().join("recordings")).unwrap();
    std::fs::write(place.path().join("recordings/mine"), "x").unwrap();
    assert!(refused(place.path(), &["restore", to], 2).contains("not empty"));
}

#[tokio::test]
async fn a_damaged_backup_restores_nothing() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let drill = Drill::new().await;
    assert!(drill.back_up().status.success());
    let whole = std::fs::read(&drill.backup).unwrap();
    let (third, length) = (whole.len() / 3, whole.len());
    let mut flipped = whole.clone();
    // The recordings are the last of the archive, before two empty blocks.
    flipped[length - 4096] ^= 1;
    for (bytes, what) in [(flipped, "flipped"), (whole[..third].to_vec(), "cut"), (b"no tar".to_vec(), "no archive")] {
        std::fs::write(&drill.backup, bytes).unwrap();
        let place = tempfile::tempdir().unwrap();
        let words = refused(place.path(), &["restore", drill.backup.to_str().unwrap()], 2);
        assert!(words.contains("backup.tar"), "{what}: {words}");
        assert!(!place.path().join("stylet.db").exists(), "{what}");
        let left = std::fs::read_dir(place.path()).unwrap().map(|entry| entry.unwrap().path());
        let left: Vec<_> = left.filter(|path| path.extension().is_none_or(|extension| extension != "lock")).collect();
        assert!(left.is_empty(), "{what}: {words} {left:?}");
    }
}

#[tokio::test]
async fn a_lost_recording_is_named_and_no_backup_is_kept() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let drill = Drill::new().await;
    let file = drill.app.files().into_iter().find(|file| file.extension().is_some_and(|e| e == "mcap")).unwrap();
    std::fs::remove_file(drill.app.state.config.recordings_dir.join(&file)).unwrap();
    let output = drill.back_up();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains(file.to_str().unwrap()));
    let left = std::fs::read_dir(drill.app.folder.path()).unwrap().map(|e| e.unwrap().file_name());
    assert!(left.into_iter().all(|name| !name.to_string_lossy().starts_with("backup")), "nothing is left behind");
}

#[tokio::test]
async fn a_database_with_flipped_bytes_is_not_served() {
    only_on!(Sqlite, "about SQLite's file");
    let drill = Drill::new().await;
    let folder = drill.app.folder.path();
    drill.app.state.db.close().await;
    let database = folder.join("stylet.db");
    let length = std::fs::metadata(&database).unwrap().len();
    let mut file = std::fs::OpenOptions::new().write(true).open(&database).unwrap();
    // The heads of all pages but the first: SQLite can still open the file.
    for page in 1..length / 4096 {
        file.seek(SeekFrom::Start(page * 4096)).unwrap();
        file.write_all(&[0xff; 16]).unwrap();
    }
    file.sync_all().unwrap();
    let before = std::fs::read(&database).unwrap();
    for arguments in [&["serve", "--listen", "127.0.0.1:0"][..], &["backup", "--to", drill.backup.to_str().unwrap()]] {
        let words = String::from_utf8(web_admin(folder, arguments).stderr).unwrap();
        assert!(words.contains("damaged") || words.contains("malformed"), "{arguments:?}: {words}");
    }
    assert_eq!(std::fs::read(&database).unwrap(), before, "nothing is written to it");
    assert!(!drill.backup.exists());
}

/// What somebody does who has the file.
async fn change_audit_log(drill: &Drill) {
    let mut tx = drill.app.state.db.write().await.unwrap();
    sqlx::raw_sql(drop_trigger("audit_log_never_changes", "audit_log")).execute(&mut *tx).await.unwrap();
    sqlx::raw_sql("UPDATE audit_log SET object = 'x' WHERE seq = 2").execute(&mut *tx).await.unwrap();
    tx.commit().await.unwrap();
    drill.app.state.db.close().await;
}

#[tokio::test]
async fn a_database_whose_audit_log_was_changed_is_not_served() {
    let drill = Drill::new().await;
    change_audit_log(&drill).await;
    let words = String::from_utf8(web_admin(drill.app.folder.path(), &["serve"]).stderr).unwrap();
    assert!(words.contains("row 2 was changed") && words.contains("restore"), "{words}");
}

#[tokio::test]
async fn damage_found_late_is_reported_and_blocks_the_next_start() {
    let drill = Drill::new().await;
    let (folder, log) = (drill.app.folder.path(), drill.app.folder.path().join("serve.log"));
    change_audit_log(&drill).await;
    // Nothing is waited for.
    let service = Service::start_logging(folder, &["--check-s", "0"], &log);
    let ready = || service.get("/readyz");
    let told = (0..100).any(|_| {
        std::thread::sleep(Duration::from_millis(100));
        ready().1.contains("the database is damaged")
    });
    assert!(told && ready().0 == 503, "{:?}", ready());
    let written = std::fs::read_to_string(&log).unwrap();
    assert!(written.contains("row 2 was changed") && written.contains("web-admin restore"), "{written}");
    assert!(service.get("/metrics").1.contains("stylet_database_findings 1\n"));
    drop(service);
    let words = String::from_utf8(web_admin(folder, &["serve", "--check-s", "0"]).stderr).unwrap();
    assert!(words.contains("row 2 was changed"), "a start after a finding waits for the whole look: {words}");
}

#[tokio::test]
async fn a_whole_database_is_told_and_forgets_an_earlier_finding() {
    let drill = Drill::new().await;
    drill.app.state.db.close().await;
    let (folder, mark) = (drill.app.folder.path(), drill.app.folder.path().join("damaged"));
    std::fs::write(&mark, "audit log: row 2 was changed after it was written\n").unwrap();
    let service = Service::start(folder);
    assert_eq!(service.get("/readyz"), (200, "ready\n".to_owned()));
    assert!(service.get("/metrics").1.contains("stylet_database_checked 1\n") && !mark.exists());
}

#[test]
fn a_service_that_is_about_to_stop_says_so_and_still_serves() {
    let folder = tempfile::TempDir::new().unwrap();
    let log = folder.path().join("serve.log");
    let mut service = Service::start_logging(folder.path(), &["--leave-s", "600"], &log);
    assert_eq!(service.get("/readyz").0, 200);
    service.signal("-TERM");
    let said = (0..100).any(|_| {
        std::thread::sleep(Duration::from_millis(50));
        service.get("/readyz") == (503, "this service is shutting down\n".to_owned())
    });
    assert!(said && service.get("/login").0 == 200, "{:?}", service.get("/readyz"));
    service.signal("-TERM");
    assert!(service.child.wait().unwrap().success());
}

#[tokio::test]
async fn a_score_that_is_not_what_the_log_tells_of_is_found() {
    let drill = Drill::new().await;
    worker::work_off_jobs(&drill.app.state).await.unwrap();
    let verify = || web_admin(drill.app.folder.path(), &["verify"]);
    assert!(verify().status.success(), "{:?}", verify());
    let mut tx = drill.app.state.db.write().await.unwrap();
    // What somebody does who has the file.
    sqlx::query(drop_trigger("scores_never_change", "scores")).execute(&mut *tx).await.unwrap();
    sqlx::query("UPDATE scores SET score = score / 2 + 1 WHERE rowid = 1").execute(&mut *tx).await.unwrap();
    tx.commit().await.unwrap();
    let found = verify();
    let words = String::from_utf8(found.stdout).unwrap();
    assert_eq!(found.status.code(), Some(1), "{words}");
    let session = drill.attempts[0].session_id.to_string();
    assert!(words.contains(&format!("scores of session {session}")), "{words}");
    assert!(words.contains(&format!("grade of session {session}")), "{words}");
}
