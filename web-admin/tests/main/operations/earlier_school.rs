//! A school that an earlier program has kept (migration 200 of the time, deductions as prose, two attempts of one trainee) is
//! restored, migrated, verified, shown and graded again. Fails when a step of the schema breaks what is there, when a
//! command asks an old database what only a new one knows, or when an old score's words are lost.

use std::path::{Path, PathBuf};
use std::process::Command;

use platform::clock::Clock;

use crate::support::client::Client;
use crate::support::{App, web_admin};

const DEEP: &str = "019f0000-0000-7000-8000-000000000002";
const OBLIQUE: &str = "019f0000-0000-7000-8000-000000000001";

fn backup() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/school-of-before/backup.tar")
}

/// What a command that must succeed has said.
fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = web_admin(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

async fn signed_in(app: &App, email: &str, password: &str) -> Client {
    let mut client = app.stranger();
    assert_eq!(client.sign_in(email, password).await.status, 303);
    client
}

#[tokio::test]
async fn a_school_of_before_is_restored_and_shown() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let folder = tempfile::tempdir().unwrap();
    let restored = succeeds(folder.path(), &["restore", backup().to_str().unwrap()]);
    assert!(restored.contains("2 recordings and the database with 26 audit rows"), "{restored}");
    assert!(succeeds(folder.path(), &["verify"]).contains(" 0 findings"));
    let app = App::in_folder(folder, Clock::system(), |_| {}).await;
    let mut ada = signed_in(&app, "ada@example.org", "correct-horse-2").await;
    let page = ada.get(&format!("/sessions/{DEEP}")).await;
    assert_eq!(page.status, 200, "{}", page.text());
    assert!(page.text().contains("the position is too far from the target"), "the words of before are gone");
    for path in ["/", "/account", &format!("/sessions/{OBLIQUE}"), &format!("/sessions/{OBLIQUE}/replay")] {
        assert_eq!(ada.get(path).await.status, 200, "{path}");
    }
    let mut head = signed_in(&app, "head@example.org", "correct-horse-1").await;
    for path in ["/admin", "/progress"] {
        assert_eq!(head.get(path).await.status, 200, "{path}");
    }
}

#[tokio::test]
async fn attempts_of_before_are_graded_again() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &["restore", backup().to_str().unwrap()]);
    let reason = ["--apply", "--reason", "the rubric of today"];
    let said = succeeds(folder.path(), &[&["rescore", "stop-in-the-fat"], &reason[..]].concat());
    assert!(said.contains("of 1 attempts re-graded"), "{said}");
    assert!(succeeds(folder.path(), &["verify"]).contains(" 0 findings"));
}

#[tokio::test]
async fn earlier_database_is_backed_up_and_verified_after_migration() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let folder = tempfile::tempdir().unwrap();
    let unpacked = Command::new("tar").arg("-xf").arg(backup()).arg("-C").arg(folder.path()).status().unwrap();
    assert!(unpacked.success());
    let refused = web_admin(folder.path(), &["verify"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("run `web-admin migrate` first"));
    let again = folder.path().join("again.tar");
    succeeds(folder.path(), &["backup", "--to", again.to_str().unwrap()]);
    let place = tempfile::tempdir().unwrap();
    assert!(succeeds(place.path(), &["restore", again.to_str().unwrap()]).contains("26 audit rows"));
    succeeds(folder.path(), &["migrate"]);
    assert!(succeeds(folder.path(), &["verify"]).contains(" 0 findings"));
}
