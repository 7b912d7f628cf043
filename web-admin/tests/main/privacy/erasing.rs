//! What goes with somebody who is erased: free texts as it is wished, recordings if the school's rule says so. Fails when a text or a recording
//! stays that was to go, when one goes that was to stay, when a judgement changes with its words, and when a backup brings them back.

use std::path::PathBuf;
use std::process::Output;

use acts::privacy::erasures::ERASURES_FILE;
use model::Role;
use model::ids::SessionId;
use model::privacy::texts::TextCounts;
use platform::clock::Clock;
use store::EngineKind;
use store::privacy::texts;
use store::privacy::texts::TextOwner;
use web_admin::AppState;

use crate::every_route::World;
use crate::support::client::{Answer, Client, csrf_in};
use crate::support::database::{config_in, engine};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member, web_admin};

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

async fn post(client: &mut Client, page: &str, path: &str, fields: &[(&str, &str)]) -> Answer {
    let csrf = csrf_in(&client.get(page).await.text());
    let done = client.form(path, &[&[("csrf", csrf.as_str())], fields].concat()).await;
    assert!(done.status.as_u16() < 400, "{path}: {} {}", done.status, done.text());
    done
}

/// Ana and Bo, an attempt of each, and what was said: by Ana, by their teacher about Ana, and by their teacher about Bo, naming Ana.
struct Said {
    app: App,
    head: Client,
    ana: Member,
    attempt: Attempt,
}

impl Said {
    async fn new() -> Self {
        let app = App::new().await;
        let school = app.school("North").await;
        app.member(school, Role::Administrator, "head@example.org").await;
        let teacher = app.member(school, Role::Instructor, "teacher@example.org").await;
        let ana = app.member(school, Role::Trainee, "ana@example.org").await;
        let bo = app.member(school, Role::Trainee, "bo@example.org").await;
        app.cohort(school, "A", &[&teacher.person, &ana.person, &bo.person]).await;
        app.publish(school).await;
        let (attempt, other) = (Attempt::default(), Attempt::default());
        assert_eq!(app.with_token(&ana.token).upload(&record(&attempt)).await.status, 201);
        assert_eq!(app.with_token(&bo.token).upload(&record(&other)).await.status, 201);
        worker::work_off_jobs(&app.state).await.unwrap();
        let mut head = app.signed_in("head@example.org").await;
        let page = format!("/people/{}", ana.person.id);
        let named = [("name", "Ana Özil"), ("email", "ana@example.org"), ("role", "trainee")];
        post(&mut head, &page, &format!("{page}/change"), &named).await;
        let (own, others) = (format!("/sessions/{}", attempt.session_id), format!("/sessions/{}", other.session_id));
        let comment = |body: &'static str| [("kind", "praise"), ("from_s", "0.1"), ("body", body)];
        let mut ana_herself = app.signed_in("ana@example.org").await;
        post(&mut ana_herself, &own, &format!("{own}/comments"), &comment("My own hand")).await;
        let mut teaching = app.signed_in("teacher@example.org").await;
        post(&mut teaching, &own, &format!("{own}/comments"), &comment("Ana trembles")).await;
        let grade = [("score", "55"), ("result", "failed"), ("reason", "she was led")];
        post(&mut teaching, &own, &format!("{own}/override"), &grade).await;
        let again = [("reason", "Ana was promised it")];
        post(&mut teaching, &own, &format!("{own}/regrade"), &again).await;
        post(&mut teaching, &others, &format!("{others}/comments"), &comment("Calmer than ÖZIL was")).await;
        post(&mut teaching, &others, &format!("{others}/comments"), &comment("Banana-shaped anatomy")).await;
        Self { app, head, ana, attempt }
    }

    fn page(&self) -> String {
        format!("/people/{}/erase", self.ana.person.id)
    }

    async fn erase(&mut self, more: &[(&str, &str)]) {
        let page = self.page();
        post(&mut self.head, &page, &page, &[&[("confirm", "ana@example.org")], more].concat()).await;
    }

    async fn texts(&self) -> Vec<String> {
        sqlx::query_scalar("SELECT body FROM comments UNION ALL SELECT reason FROM score_overrides UNION ALL SELECT reason FROM regrade_reasons")
            .fetch_all(self.app.state.db.reader())
            .await
            .unwrap()
    }

    fn recording(&self) -> PathBuf {
        let name = format!("{}.mcap", self.attempt.session_id);
        self.app.state.config.recordings_dir.join(self.ana.person.school_id.to_string()).join(name)
    }

    async fn erase_recordings_too(&mut self) {
        let rule = [("months", ""), ("warn_days", "30"), ("recordings", "yes")];
        post(&mut self.head, "/admin/retention", "/admin/retention", &rule).await;
    }
}

#[tokio::test]
async fn texts_are_counted_looked_through_and_go_only_as_it_is_wished() {
    let mut said = Said::new().await;
    let page = said.head.get(&said.page()).await.text();
    assert!(page.contains("Make 1 text by them") && page.contains("Make 3 texts by others"), "{page}");
    assert!(page.contains("Calmer than ÖZIL was") && !page.contains("Banana"), "a name is a word: {page}");
    said.erase(&[("about", "yes")]).await;
    let texts = said.texts().await;
    for stays in ["My own hand", "Calmer than ÖZIL was", "Banana-shaped anatomy"] {
        assert!(texts.iter().any(|text| text == stays), "{stays}: {texts:?}");
    }
    assert_eq!(texts.iter().filter(|text| *text == texts::ERASED).count(), 3, "{texts:?}");
    let grade: (f64, bool) = sqlx::query_as("SELECT score, passed FROM grades WHERE session_id = $1")
        .bind(said.attempt.session_id)
        .fetch_one(said.app.state.db.reader())
        .await
        .unwrap();
    assert_eq!(grade, (55.0, false), "the grade stays as it was given");
    let verified = web_admin(said.app.folder.path(), &["verify"]);
    assert!(verified.status.success(), "{}", words(&verified));
    let log: Vec<String> =
        sqlx::query_scalar("SELECT details FROM audit_log").fetch_all(said.app.state.db.reader()).await.unwrap();
    assert!(
        !log.iter().any(|details| details.contains("promised")),
        "no text stands where none can be erased: {log:?}"
    );
    let history = said.head.get(&format!("/sessions/{}/grade", said.attempt.session_id)).await.text();
    assert!(history.contains("[erased]") && !history.contains("promised"), "{history}");
    assert!(said.recording().exists(), "recordings stay, unless the school says otherwise");
    // A server overwrites when it gets to it.
    if engine() == EngineKind::Sqlite {
        let bytes = std::fs::read(said.app.folder.path().join("stylet.db")).unwrap();
        assert!(!bytes.windows(12).any(|part| part == b"Ana trembles"), "free pages are overwritten");
    }
}

#[tokio::test]
async fn a_backup_brings_neither_texts_nor_recordings_back() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let mut said = Said::new().await;
    let backup = said.app.folder.path().join("backup.tar");
    let made = web_admin(said.app.folder.path(), &["backup", "--to", backup.to_str().unwrap()]);
    assert!(made.status.success(), "{}", words(&made));
    said.erase_recordings_too().await;
    let page = said.head.get(&said.page()).await.text();
    assert!(page.contains("recordings are deleted, too"), "{page}");
    said.erase(&[("written", "yes"), ("about", "yes")]).await;
    let place = tempfile::tempdir().unwrap();
    let list = said.app.folder.path().join(ERASURES_FILE);
    let restore = ["restore", backup.to_str().unwrap(), "--erasures", list.to_str().unwrap()];
    let restored = web_admin(place.path(), &restore);
    assert!(restored.status.success(), "{}", words(&restored));
    let verified = web_admin(place.path(), &["verify"]);
    assert!(verified.status.success(), "{}", words(&verified));
    let state = AppState::open(config_in(place.path()), Clock::system()).await.unwrap();
    let whose =
        TextOwner { school_id: said.ana.person.school_id, person_id: said.ana.person.id, until: state.clock.now() };
    let left = texts::count_texts(state.db.reader(), whose).await.unwrap();
    assert_eq!(left, TextCounts { written: 0, about: 0, sealed: 0 });
    let gone = said.recording().strip_prefix(&said.app.state.config.recordings_dir).unwrap().to_owned();
    assert!(!state.config.recordings_dir.join(gone).exists());
}

#[tokio::test]
async fn erasure_deletes_recordings_by_rule_and_pages_still_work() {
    let mut said = Said::new().await;
    said.erase_recordings_too().await;
    let session = said.attempt.session_id;
    let replays = || std::fs::read_dir(said.app.state.config.replays_dir()).unwrap().count();
    assert_eq!((said.recording().exists(), replays()), (true, 2));
    said.erase(&[]).await;
    let replays = std::fs::read_dir(said.app.state.config.replays_dir()).unwrap().count();
    assert_eq!((said.recording().exists(), replays), (false, 1));
    for path in ["", "?with=comments"] {
        let mut head = said.head.clone();
        let answer = head.get(&format!("/api/v1/sessions/{session}/recording{path}")).await;
        assert_eq!(answer.status, 410, "{path}: {}", answer.text());
    }
    for (path, expected) in [("", 200), ("/grade", 200), ("/replay", 200)] {
        let answer = said.head.get(&format!("/sessions/{session}{path}")).await;
        assert_eq!(answer.status, expected, "{path}: {}", answer.text());
    }
    assert_eq!(said.head.get(&format!("/api/v1/sessions/{session}/replay")).await.status, 410);
    let folder = said.app.folder.path().to_owned();
    let backup = folder.join("after.tar");
    let to_do = [&["verify"][..], &["backup", "--to", backup.to_str().unwrap()]];
    // A backup holds a file of SQLite.
    for arguments in &to_do[..if engine() == EngineKind::Sqlite { 2 } else { 1 }] {
        let done = web_admin(&folder, arguments);
        assert!(done.status.success(), "{}", words(&done));
    }
    // What a service leaves that is killed after its commit goes at the next start.
    std::fs::write(said.recording(), "left over").unwrap();
    assert_eq!(web_admin(&folder, &["verify"]).status.code(), Some(1));
    assert_eq!(acts::privacy::erasing::catch_up(&said.app.state).await.unwrap(), 0);
    assert!(!said.recording().exists());
}

async fn execute(app: &App, statement: &'static str) -> Result<(), sqlx::Error> {
    let mut tx = app.state.db.write().await.unwrap();
    sqlx::raw_sql(statement).execute(&mut *tx).await?;
    tx.commit().await
}

#[tokio::test]
async fn of_a_judgement_nothing_changes_but_its_words_into_the_mark() {
    let world = World::new().await;
    let app = world.open().await;
    let session: SessionId =
        sqlx::query_scalar("SELECT session_id FROM ratings").fetch_one(app.state.db.reader()).await.unwrap();
    assert_ne!(session, SessionId::nil());
    execute(&app, "UPDATE ratings SET answers = '[3, \"a calm hand\", null]', finished_at = 5").await.unwrap();
    execute(
        &app,
        "INSERT INTO score_overrides (id, school_id, session_id, score, passed, reason, made_by, made_at)
         SELECT randomblob(16), school_id, session_id, 50, TRUE, 'why', rater_id, 5 FROM ratings LIMIT 1",
    )
    .await
    .unwrap();
    for refused in [
        "UPDATE ratings SET answers = '[3, \"another text\", null]'",
        "UPDATE ratings SET answers = '[4, \"[erased]\", null]'",
        "UPDATE ratings SET answers = '[\"[erased]\", \"a calm hand\", null]'",
        "UPDATE ratings SET answers = '[3, \"[erased]\"]'",
        "UPDATE ratings SET answers = '[3, \"[erased]\", 1]'",
        "UPDATE ratings SET answers = '[3, \"[erased]\", null]', finished_at = 6",
        "UPDATE score_overrides SET reason = 'another'",
        "UPDATE score_overrides SET reason = '[erased]', score = 51",
        "UPDATE score_overrides SET reason = '[erased]', passed = NULL, score = NULL",
        "DELETE FROM score_overrides",
        "DELETE FROM ratings",
    ] {
        assert!(execute(&app, refused).await.is_err(), "{refused}");
    }
    execute(&app, "UPDATE ratings SET answers = '[3, \"[erased]\", null]'").await.unwrap();
    execute(&app, "UPDATE score_overrides SET reason = '[erased]'").await.unwrap();
}
