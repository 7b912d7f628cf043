//! Disks fill up and fail, two services are started on one folder, restores and backups are stopped. Fails when one fault
//! outlasts its cause, when bytes are acknowledged that are not there, or when an empty school takes the place of a full one.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

use crate::support::database::config_in;
use crate::support::failing_disk::{FailingDisk, Fault};
use crate::support::recordings::{Attempt, record};
use crate::support::service::{Service, answer, founded, header, whole_answer};
use crate::support::{App, web_admin};

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// Begins an upload in pieces; its path.
fn begin(service: &Service, token: &str, length: usize) -> String {
    let create = format!("POST /api/v1/uploads HTTP/1.1\r\nTus-Resumable: 1.0.0\r\nUpload-Length: {length}");
    let (status, head, body) = whole_answer(service.begin(&create, token, &[]));
    assert_eq!(status, 201, "{body}");
    header(&head, "location").to_owned()
}

/// Status, and how far an upload has come.
fn offset(service: &Service, token: &str, path: &str) -> (u16, String) {
    let ask = format!("HEAD {path} HTTP/1.1\r\nTus-Resumable: 1.0.0");
    let (status, head, _) = whole_answer(service.begin(&ask, token, &[]));
    (status, header(&head, "upload-offset").to_owned())
}

#[tokio::test]
async fn after_a_full_disk_the_database_is_written_to_again() {
    only_on!(Sqlite, "about SQLite's file");
    let app = App::new().await;
    let mut tx = app.state.db.write().await.unwrap();
    // As many pages as there are.
    sqlx::query("PRAGMA max_page_count = 1").execute(&mut *tx).await.unwrap();
    let full =
        sqlx::query("INSERT INTO schools (id, name, created_at) VALUES (zeroblob(16), hex(zeroblob(1000000)), 0)");
    assert!(full.execute(&mut *tx).await.unwrap_err().to_string().contains("full"));
    drop(tx);
    app.state.db.beat(app.state.clock.now()).await.unwrap();
    app.school("North").await;
}

#[tokio::test]
async fn full_disk_is_reported_and_the_service_recovers_with_space() {
    only_on!(Sqlite, "about SQLite's file");
    let (folder, token) = founded().await;
    let (disk, service) = FailingDisk::under_service(folder.path());
    let bytes = record(&Attempt::default());
    let ready = || answer(service.begin("GET /readyz HTTP/1.1", &token, &[])).0;
    for fault in [Fault::Full, Fault::Broken] {
        disk.fail(fault, "stylet.db");
        let (status, body) = answer(service.upload(&token, &bytes, bytes.len()));
        let expected = if matches!(fault, Fault::Full) { 507 } else { 500 };
        assert_eq!(status, expected, "{body}");
        assert_eq!(body.contains("disk space"), expected == 507, "{body}");
        // What is answered for some seconds may be from before.
        let noticed = (0..80).any(|_| {
            std::thread::sleep(Duration::from_millis(100));
            ready() == 503
        });
        assert!(noticed, "{fault:?}: whoever asks whether it is ready is told");
        disk.mend();
        let attempt = record(&Attempt::default());
        let (status, body) = answer(service.upload(&token, &attempt, attempt.len()));
        assert_eq!(status, 201, "{fault:?}: {body}");
        let mended = (0..80).any(|_| {
            std::thread::sleep(Duration::from_millis(100));
            ready() == 200
        });
        assert!(mended, "{fault:?}");
    }
    assert_eq!(answer(service.upload(&token, &bytes, bytes.len())).0, 201, "what was refused is not lost");
}

#[tokio::test]
async fn no_byte_is_acknowledged_that_the_disk_has_refused() {
    only_on!(Sqlite, "about SQLite's file");
    for (fault, expected) in [(Fault::Full, 507), (Fault::Broken, 500)] {
        let (folder, token) = founded().await;
        let (disk, service) = FailingDisk::under_service(folder.path());
        let attempt = Attempt::default();
        let bytes = record(&attempt);
        let (third, two_thirds) = (bytes.len() / 3, 2 * bytes.len() / 3);
        let path = begin(&service, &token, bytes.len());
        assert_eq!(answer(service.piece(&token, (&path, 0), &bytes[..third], third)).0, 204);
        disk.fail(fault, ".tus");
        let piece = &bytes[third..two_thirds];
        let (status, body) = answer(service.piece(&token, (&path, third), piece, piece.len()));
        assert_eq!(status, expected, "{body}");
        assert_eq!(offset(&service, &token, &path), (200, third.to_string()), "{fault:?}");
        disk.mend();
        let rest = &bytes[third..];
        let (status, head, body) = whole_answer(service.piece(&token, (&path, third), rest, rest.len()));
        assert_eq!((status, header(&head, "stylet-session")), (204, &*attempt.session_id.to_string()), "{body}");
    }
}

#[tokio::test]
async fn an_upload_whose_row_cannot_be_written_is_still_there() {
    only_on!(Sqlite, "about SQLite's file");
    let (folder, token) = founded().await;
    let (disk, service) = FailingDisk::under_service(folder.path());
    let attempt = Attempt::default();
    let bytes = record(&attempt);
    let path = begin(&service, &token, bytes.len());
    let most = bytes.len() - 1;
    assert_eq!(answer(service.piece(&token, (&path, 0), &bytes[..most], most)).0, 204);
    disk.fail(Fault::Full, "stylet.db-wal");
    let status = answer(service.piece(&token, (&path, most), &bytes[most..], 1)).0;
    assert_eq!(status, 507);
    disk.mend();
    assert_eq!(offset(&service, &token, &path), (200, most.to_string()));
    let (status, head, body) = whole_answer(service.piece(&token, (&path, most), &bytes[most..], 1));
    assert_eq!((status, header(&head, "stylet-session")), (204, &*attempt.session_id.to_string()), "{body}");
    drop(service);
    let verified = web_admin(folder.path(), &["verify"]);
    assert!(verified.status.success(), "{}", words(&verified));
}

#[tokio::test]
async fn second_service_on_a_folder_is_refused_and_names_the_first() {
    let (folder, _) = founded().await;
    let service = Service::start(folder.path());
    let second = web_admin(folder.path(), &["serve", "--listen", "127.0.0.1:0"]);
    let said = words(&second);
    assert!(!second.status.success() && said.contains(&service.child.id().to_string()), "{said}");
    let restored = web_admin(folder.path(), &["restore", "nothing.tar"]);
    assert!(words(&restored).contains("web-admin serve"), "{}", words(&restored));
    service.signal("-KILL");
    drop(service);
    Service::start(folder.path());
}

#[tokio::test]
async fn a_new_folder_is_its_owners_alone() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("data");
    drop(Service::start(&folder));
    let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!(mode(&folder), 0o700);
    for file in std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
        let allowed = if file.is_dir() { 0o700 } else { 0o600 };
        assert_eq!(mode(&file), allowed, "{}", file.display());
    }
}

/// A folder with an attempt in it, and its backup.
async fn backed_up() -> (App, std::path::PathBuf) {
    let app = App::new().await;
    let school = app.school("North").await;
    let ada = app.member(school, model::Role::Trainee, "ada@example.org").await;
    assert_eq!(app.with_token(&ada.token).upload(&record(&Attempt::default())).await.status, 201);
    app.state.db.close().await;
    let backup = app.folder.path().join("backup.tar");
    // What a backup that was killed has left.
    for suffix in ["part", "database"] {
        std::fs::write(backup.with_extension(format!("tar.{suffix}")), "half of it").unwrap();
    }
    let made = web_admin(app.folder.path(), &["backup", "--to", backup.to_str().unwrap()]);
    assert!(made.status.success(), "{}", words(&made));
    (app, backup)
}

#[tokio::test]
async fn killed_restore_is_resumed_and_never_served_half_done() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let (_app, backup) = backed_up().await;
    let backup = backup.to_str().unwrap();
    let place = tempfile::tempdir().unwrap();
    assert!(web_admin(place.path(), &["restore", backup]).status.success());
    // As if it had been killed between its renames.
    let (database, staging) = (place.path().join("stylet.db"), place.path().join("recordings.restoring"));
    std::fs::create_dir(&staging).unwrap();
    for left in ["stylet.db-wal", "stylet.db-shm"] {
        let _ = std::fs::remove_file(place.path().join(left));
    }
    std::fs::rename(&database, staging.join("stylet.db")).unwrap();
    let manifest = Command::new("tar").args(["-xOf", backup, "manifest.json"]).output().unwrap().stdout;
    std::fs::write(staging.join("whole.json"), manifest).unwrap();
    let served = web_admin(place.path(), &["serve", "--listen", "127.0.0.1:0"]);
    assert!(words(&served).contains("restore was interrupted"), "{}", words(&served));
    assert!(!database.exists(), "no empty school");
    let again = web_admin(place.path(), &["restore", backup]);
    assert!(again.status.success(), "{}", words(&again));
    assert!(web_admin(place.path(), &["verify"]).status.success() && !staging.exists());
    // Killed before it had unpacked everything, it begins anew.
    let place = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(place.path().join("recordings.restoring/recordings")).unwrap();
    assert!(web_admin(place.path(), &["restore", backup]).status.success());
}

#[tokio::test]
async fn a_log_without_its_database_is_not_restored_into() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let (_app, backup) = backed_up().await;
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("stylet.db-wal"), "another database's").unwrap();
    let refused = web_admin(place.path(), &["restore", backup.to_str().unwrap()]);
    assert!(words(&refused).contains("stylet.db-wal"), "{}", words(&refused));
}

#[tokio::test]
async fn recordings_without_a_database_or_a_row_are_reported() {
    only_on!(Sqlite, "about SQLite's file");
    let (app, _) = backed_up().await;
    let config = config_in(app.folder.path());
    let kept = app.files().into_iter().find(|file| file.extension().is_some_and(|e| e == "mcap")).unwrap();
    let stray = kept.with_file_name(format!("{}.mcap", uuid::Uuid::new_v4()));
    std::fs::copy(config.recordings_dir.join(&kept), config.recordings_dir.join(&stray)).unwrap();
    let verified = web_admin(app.folder.path(), &["verify"]);
    assert_eq!(verified.status.code(), Some(1));
    assert!(words(&verified).contains(stray.to_str().unwrap()), "{}", words(&verified));
    for empty in [false, true] {
        let database = app.folder.path().join("stylet.db");
        let _ = std::fs::remove_file(&database);
        if empty {
            std::fs::write(&database, "").unwrap();
        }
        let served = web_admin(app.folder.path(), &["serve", "--listen", "127.0.0.1:0"]);
        assert!(!served.status.success() && words(&served).contains("contains recordings"), "{}", words(&served));
    }
}
