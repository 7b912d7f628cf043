//! Whoever was erased stays erased. Fails when a backup that is restored, or a database that is put back by hand, brings somebody
//! back, when the list of erasures tells a name, or when a backup leaves the list out.

use std::path::{Path, PathBuf};
use std::process::Output;

use acts::privacy::erasing;
use acts::privacy::erasures::{ERASURES_FILE, Erasure, ErasureList, ErasureScope};
use model::Role;
use platform::clock::Clock;
use store::people;
use web_admin::AppState;

use crate::support::client::{Client, csrf_in};
use crate::support::database::config_in;
use crate::support::recordings::{Attempt, record};
use crate::support::service::Service;
use crate::support::{App, Member, web_admin};

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// A school with an attempt of Ada's, its backup, and Ada erased afterwards.
struct Drill {
    app: App,
    head: Client,
    ada: Member,
    backup: PathBuf,
}

impl Drill {
    async fn new() -> Self {
        let app = App::new().await;
        let school = app.school("North").await;
        app.member(school, Role::Administrator, "head@example.org").await;
        let ada = app.member(school, Role::Trainee, "ada@example.org").await;
        app.member(school, Role::Trainee, "bo@example.org").await;
        assert_eq!(app.with_token(&ada.token).upload(&record(&Attempt::default())).await.status, 201);
        let backup = app.folder.path().join("backup.tar");
        let made = web_admin(app.folder.path(), &["backup", "--to", backup.to_str().unwrap()]);
        assert!(made.status.success(), "{}", words(&made));
        let head = app.signed_in("head@example.org").await;
        let mut drill = Self { app, head, ada, backup };
        drill.erase().await;
        drill
    }

    async fn erase(&mut self) {
        let page = format!("/people/{}", self.ada.person.id);
        let csrf = csrf_in(&self.head.get(&page).await.text());
        let fields = [("csrf", csrf.as_str()), ("confirm", "ada@example.org")];
        assert_eq!(self.head.form(&format!("{page}/erase"), &fields).await.status, 303);
    }

    fn list(&self) -> PathBuf {
        self.app.folder.path().join(ERASURES_FILE)
    }

    fn restore_into(&self, folder: &Path, more: &[&str]) -> String {
        let restored = web_admin(folder, &[&["restore", self.backup.to_str().unwrap()], more].concat());
        assert!(restored.status.success(), "{}", words(&restored));
        let verified = web_admin(folder, &["verify"]);
        assert!(verified.status.success(), "{}", words(&verified));
        words(&restored)
    }
}

/// Who of the two is known there by their address.
async fn known(folder: &Path) -> Vec<&'static str> {
    let state = AppState::open(config_in(folder), Clock::system()).await.unwrap();
    let mut found = Vec::new();
    for email in ["ada@example.org", "bo@example.org"] {
        if people::find_person_by_email(state.db.reader(), email).await.unwrap().is_some() {
            found.push(email);
        }
    }
    state.db.close().await;
    found
}

#[tokio::test]
async fn restore_with_the_list_brings_back_no_erased_person() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let drill = Drill::new().await;
    let place = tempfile::tempdir().unwrap();
    let said = drill.restore_into(place.path(), &[]);
    assert!(!said.contains("erased again"), "a new machine without the list cannot know: {said}");
    assert_eq!(known(place.path()).await, ["ada@example.org", "bo@example.org"]);
    let place = tempfile::tempdir().unwrap();
    let said = drill.restore_into(place.path(), &["--erasures", drill.list().to_str().unwrap()]);
    assert!(said.contains("after the backup: 1"), "{said}");
    assert_eq!(known(place.path()).await, ["bo@example.org"]);
    for file in
        std::fs::read_dir(place.path()).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_file())
    {
        let bytes = std::fs::read(&file).unwrap();
        assert!(!bytes.windows(15).any(|part| part == b"ada@example.org"), "{}", file.display());
    }
    // From there on it is the place's own list, and in its backups.
    let backup = place.path().join("again.tar");
    assert!(web_admin(place.path(), &["backup", "--to", backup.to_str().unwrap()]).status.success());
    let third = tempfile::tempdir().unwrap();
    assert!(web_admin(third.path(), &["restore", backup.to_str().unwrap()]).status.success());
    let kept = |folder: &Path| ErasureList::at(&folder.join(ERASURES_FILE)).read().unwrap();
    assert_eq!(kept(third.path()), kept(drill.app.folder.path()));
}

#[tokio::test]
async fn in_its_own_folder_a_restore_knows_who_was_erased() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let drill = Drill::new().await;
    drill.app.state.db.close().await;
    let folder = drill.app.folder.path();
    for lost in ["stylet.db", "stylet.db-wal", "stylet.db-shm"] {
        let _ = std::fs::remove_file(folder.join(lost));
    }
    std::fs::remove_dir_all(folder.join("recordings")).unwrap();
    assert!(drill.restore_into(folder, &[]).contains("after the backup: 1"));
    assert_eq!(known(folder).await, ["bo@example.org"]);
}

#[tokio::test]
async fn restored_database_is_served_only_after_repeating_erasures() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let drill = Drill::new().await;
    let place = tempfile::tempdir().unwrap();
    drill.restore_into(place.path(), &[]);
    std::fs::copy(drill.list(), place.path().join(ERASURES_FILE)).unwrap();
    let found = web_admin(place.path(), &["verify"]);
    assert_eq!(found.status.code(), Some(1), "{}", words(&found));
    assert!(words(&found).contains(&format!("person {}: erased", drill.ada.person.id)), "{}", words(&found));
    drop(Service::start(place.path()));
    assert_eq!(known(place.path()).await, ["bo@example.org"]);
    let verified = web_admin(place.path(), &["verify"]);
    assert!(verified.status.success(), "{}", words(&verified));
}

#[tokio::test]
async fn erasure_list_holds_no_names_and_withdrawn_lines_do_nothing() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let drill = Drill::new().await;
    let text = std::fs::read_to_string(drill.list()).unwrap();
    assert!(text.contains(&drill.ada.person.pseudonym), "{text}");
    for telling in ["ada", "Somebody", "example.org", "North"] {
        assert!(!text.contains(telling), "{telling} is told by {text}");
    }
    let bo = people::find_person_by_email(drill.app.state.db.reader(), "bo@example.org").await.unwrap().unwrap();
    let erasure = Erasure {
        at: drill.app.state.clock.now(),
        school_id: bo.school_id,
        person_id: bo.id,
        pseudonym: bo.pseudonym.clone(),
        wish: ErasureScope::default(),
    };
    let list = ErasureList::at(&drill.list());
    list.add(&erasure).unwrap();
    list.take_back(&erasure).unwrap();
    assert_eq!(erasing::catch_up(&drill.app.state).await.unwrap(), 0);
    // As a service leaves it that is killed after the line and before the commit.
    list.add(&erasure).unwrap();
    assert_eq!(erasing::catch_up(&drill.app.state).await.unwrap(), 1);
    assert_eq!(erasing::catch_up(&drill.app.state).await.unwrap(), 0, "once");
    assert!(people::find_person_by_email(drill.app.state.db.reader(), "bo@example.org").await.unwrap().is_none());
}

#[tokio::test]
async fn unreadable_erasure_list_blocks_restore_and_service() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let drill = Drill::new().await;
    let strange = drill.app.folder.path().join("strange");
    std::fs::write(&strange, "Ana Ek, 3 March\n").unwrap();
    let place = tempfile::tempdir().unwrap();
    for list in [strange.to_str().unwrap(), "nowhere"] {
        let refused = web_admin(place.path(), &["restore", drill.backup.to_str().unwrap(), "--erasures", list]);
        assert_eq!(refused.status.code(), Some(2), "{}", words(&refused));
        assert!(words(&refused).contains("--erasures") && words(&refused).contains(list), "{}", words(&refused));
        assert!(!place.path().join("stylet.db").exists());
    }
    drill.restore_into(place.path(), &[]);
    std::fs::copy(&strange, place.path().join(ERASURES_FILE)).unwrap();
    let served = web_admin(place.path(), &["serve", "--listen", "127.0.0.1:0"]);
    assert!(!served.status.success() && words(&served).contains("line 1"), "{}", words(&served));
}
