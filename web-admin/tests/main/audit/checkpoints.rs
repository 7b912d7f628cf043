//! The end of the audit log is told outside, and the certificates' key is in a backup for whoever has the passphrase. Fails when a log that was cut
//! or made anew passes for the one that was stated, when a forged statement passes for one of ours, when a statement is not mailed,
//! and when a key is restored without its passphrase.

use std::path::Path;
use std::process::Output;

use acts::audit::audit_checkpoints;
use acts::training::certificates;
use model::{Moment, Role};
use platform::clock::Clock;
use platform::config::MailTo;

use crate::support::database::shrink_audit_log;
use crate::support::{App, web_admin};

const NOW: Moment = Moment::from_micros(1_795_269_600_000_000); // 2026-11-21 14:00 UTC

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// A service with some rows, whose audit log is mailed to somebody.
async fn app() -> App {
    let app = App::with(Clock::fixed(NOW), |config| config.anchor_mail = Some("audit@example.org".to_owned())).await;
    let school = app.school("North").await;
    app.member(school, Role::Trainee, "ada@example.org").await;
    app.signed_in("ada@example.org").await;
    app
}

fn letters(app: &App) -> Vec<String> {
    let MailTo::Folder(folder) = &app.state.config.mail else { panic!("mail goes to a folder") };
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let texts = entries.map(|entry| std::fs::read_to_string(entry.unwrap().path()).unwrap());
    texts.filter(|text| text.contains("audit@example.org")).collect()
}

#[tokio::test]
async fn each_day_has_its_statement_which_is_mailed_once() {
    let app = app().await;
    let first = audit_checkpoints::anchor(&app.state).await.unwrap().unwrap();
    assert!(first.ends_with("statements/2026-11-21.json"), "{first}");
    assert_eq!(audit_checkpoints::anchor(&app.state).await.unwrap(), None, "once a day");
    assert_eq!(letters(&app).len(), 1);
    app.state.clock.advance(86_400);
    app.signed_in("ada@example.org").await;
    let second = audit_checkpoints::anchor(&app.state).await.unwrap().unwrap();
    assert_eq!(letters(&app).len(), 2);
    let key = certificates::public_key(&app.state.config.keys_dir).unwrap();
    let of = |file: &str| audit_checkpoints::check(&std::fs::read(file).unwrap(), &key).unwrap();
    assert_eq!((of(&first).rows, of(&second).rows), (2, 3));
    let mut forged = std::fs::read_to_string(&first).unwrap();
    forged = forged.replace("\\\"rows\\\":2", "\\\"rows\\\":1");
    assert!(forged.contains("\\\"rows\\\":1"), "{forged}");
    assert!(audit_checkpoints::check(forged.as_bytes(), &key).is_err());
    assert!(
        audit_checkpoints::check(b"{}", &key).is_err() && audit_checkpoints::check("}ä{".as_bytes(), &key).is_err()
    );
}

#[tokio::test]
async fn what_could_not_be_mailed_is_mailed_later() {
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let nobody = format!("smtp://{}", listener.local_addr().unwrap());
    drop(listener);
    let app = App::with(Clock::fixed(NOW), |config| {
        config.anchor_mail = Some("audit@example.org".to_owned());
        config.mail = MailTo::Smtp(nobody);
    })
    .await;
    assert!(audit_checkpoints::anchor(&app.state).await.is_err());
    let again = App::in_folder(app.folder, Clock::fixed(NOW), |config| {
        config.anchor_mail = Some("audit@example.org".to_owned());
    })
    .await;
    assert!(audit_checkpoints::anchor(&again.state).await.unwrap().is_some());
    assert_eq!(letters(&again).len(), 1);
}

#[tokio::test]
async fn truncated_or_rebuilt_audit_log_contradicts_its_checkpoint() {
    let app = app().await;
    let folder = app.folder.path();
    let file = audit_checkpoints::anchor(&app.state).await.unwrap().unwrap();
    let kept = folder.join("kept.json");
    std::fs::copy(&file, &kept).unwrap();
    let letter = folder.join("letter.txt");
    // As it is saved out of a letter, with what stands around it.
    std::fs::write(&letter, format!("Keep this email.\n\n{}\n", std::fs::read_to_string(&file).unwrap())).unwrap();
    app.signed_in("ada@example.org").await;
    for statement in [&kept, &letter] {
        let verified = web_admin(folder, &["verify", "--statement", statement.to_str().unwrap()]);
        assert!(verified.status.success(), "a log that grew is whole: {}", words(&verified));
    }
    let published = certificates::public_key(folder).unwrap();
    let with_key = |key: &str| {
        let arguments = ["verify", "--statement", kept.to_str().unwrap(), "--statement-key", key];
        web_admin(folder, &arguments)
    };
    assert!(with_key(&published).status.success());
    let other = with_key(&"ab".repeat(32));
    assert!(words(&other).contains("not genuine"), "{}", words(&other));
    // What somebody does who has the file: the last rows go, and others come in their place.
    app.write(async |tx| shrink_audit_log(tx, "DELETE FROM audit_log WHERE seq >= 2").await).await;
    app.state.clock.advance(60);
    app.signed_in("ada@example.org").await;
    let verified = web_admin(folder, &["verify"]);
    assert!(verified.status.success(), "alone it does not tell: {}", words(&verified));
    let verified = web_admin(folder, &["verify", "--statement", kept.to_str().unwrap()]);
    assert_eq!(verified.status.code(), Some(1), "{}", words(&verified));
    assert!(words(&verified).contains("row 2 does not have the hash"), "{}", words(&verified));
}

#[tokio::test]
async fn an_address_that_is_none_is_refused_at_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let refused = web_admin(folder.path(), &["serve", "--anchor-mail", "nobody"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(words(&refused).contains("--anchor-mail: \"nobody\""), "{}", words(&refused));
}

#[tokio::test]
async fn backup_restores_the_certificate_key_only_by_passphrase() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let app = app().await;
    let folder = app.folder.path();
    let key = certificates::public_key(folder).unwrap();
    let secret = std::fs::read_to_string(folder.join("certificate-key")).unwrap();
    let (right, wrong, short) = (folder.join("right"), folder.join("wrong"), folder.join("short"));
    for (file, text) in [(&right, "seven green horses\n"), (&wrong, "seven blue horses\n"), (&short, "short\n")] {
        std::fs::write(file, text).unwrap();
    }
    let backup = folder.join("backup.tar");
    let back_up = |passphrase: &Path| {
        web_admin(
            folder,
            &["backup", "--to", backup.to_str().unwrap(), "--passphrase-file", passphrase.to_str().unwrap()],
        )
    };
    let refused = back_up(&short);
    assert!(refused.status.code() == Some(2) && words(&refused).contains("at least 12"), "{}", words(&refused));
    let made = back_up(&right);
    assert!(made.status.success() && words(&made).contains("sealed in the backup"), "{}", words(&made));
    let bytes = std::fs::read(&backup).unwrap();
    assert!(!bytes.windows(64).any(|part| part == secret.as_bytes()), "the key is readable");
    let restore = |place: &Path, passphrase: Option<&Path>| {
        let file = passphrase.map(|file| file.to_str().unwrap().to_owned());
        let more = file.as_deref().map(|file| vec!["--passphrase-file", file]).unwrap_or_default();
        web_admin(place, &[&["restore", backup.to_str().unwrap()], &more[..]].concat())
    };
    let place = tempfile::tempdir().unwrap();
    let refused = restore(place.path(), Some(&wrong));
    assert!(refused.status.code() == Some(2) && words(&refused).contains("passphrase"), "{}", words(&refused));
    assert!(!place.path().join("stylet.db").exists() && !place.path().join("recordings.restoring").exists());
    let restored = restore(place.path(), Some(&right));
    assert!(restored.status.success(), "{}", words(&restored));
    assert_eq!(certificates::public_key(place.path()).unwrap(), key);
    let place = tempfile::tempdir().unwrap();
    let restored = restore(place.path(), None);
    assert!(restored.status.success() && words(&restored).contains("were not restored"), "{}", words(&restored));
    assert!(!place.path().join("certificate-key").exists());
    let place = tempfile::tempdir().unwrap();
    assert_ne!(certificates::public_key(place.path()).unwrap(), key);
    let refused = restore(place.path(), Some(&right));
    assert!(words(&refused).contains("already contains another key"), "{}", words(&refused));
}
