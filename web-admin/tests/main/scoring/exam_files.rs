//! Exam files through the front door and the command line. Fails when a later decision changes one, when a changed byte is not found, and when
//! it is frozen or read by somebody who may not.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;

use acts::training::certificates;
use model::Role;
use model::ids::SessionId;
use model::scoring::exam_file::{ExamManifest, check};
use serde_json::Value;
use sha2::{Digest, Sha256};
use store::privacy::exports;
use web_admin::worker;

use crate::people::post;
use crate::support::client::{Client, csrf_in};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member, web_admin};

struct School {
    app: App,
    ada: Member,
    attempt: SessionId,
    recorded: Vec<u8>,
}

impl School {
    async fn new() -> Self {
        let app = App::new().await;
        let north = app.school("North").await;
        app.publish(north).await;
        let ada = app.member(north, Role::Trainee, "ada@example.org").await;
        let teacher = app.member(north, Role::Instructor, "teacher@example.org").await;
        app.member(north, Role::Instructor, "colleague@example.org").await;
        app.member(north, Role::Administrator, "head@example.org").await;
        let south = app.school("South").await;
        app.member(south, Role::Administrator, "abroad@example.org").await;
        app.cohort(north, "Spring", &[&ada.person, &teacher.person]).await;
        let attempt = Attempt { session_id: SessionId::random(), ..Attempt::default() };
        let recorded = record(&attempt);
        assert_eq!(app.with_token(&ada.token).upload(&recorded).await.status, 201);
        worker::work_off_jobs(&app.state).await.unwrap();
        Self { app, ada, attempt: attempt.session_id, recorded }
    }

    fn page(&self) -> String {
        format!("/sessions/{}", self.attempt)
    }

    async fn browser(&self, name: &str) -> Client {
        self.app.signed_in(&format!("{name}@example.org")).await
    }

    /// Freezes the attempt; the address of the newest file.
    async fn freeze(&self, teacher: &mut Client) -> String {
        let path = format!("{}/exam-files", self.page());
        let done = post(teacher, &self.page(), &path, &[]).await;
        assert_eq!(done.status, 303, "{}", done.text());
        let page = teacher.get(&self.page()).await.text();
        let last = page.rsplit(&format!("href=\"{path}/")).next().unwrap().split('"').next().unwrap().to_owned();
        format!("{path}/{last}")
    }

    fn key(&self) -> String {
        certificates::public_key(&self.app.state.config.keys_dir).unwrap()
    }

    fn checked(&self, file: &[u8]) -> Result<ExamManifest, String> {
        check(file, &self.key()).map_err(|error| format!("{error:#}"))
    }
}

fn entries_of(file: &[u8]) -> BTreeMap<String, Vec<u8>> {
    let mut archive = tar::Archive::new(file);
    let entry = |entry: std::io::Result<tar::Entry<'_, &[u8]>>| {
        let mut entry = entry.unwrap();
        let (name, mut content) = (entry.path().unwrap().display().to_string(), Vec::new());
        entry.read_to_end(&mut content).unwrap();
        (name, content)
    };
    archive.entries().unwrap().map(entry).collect()
}

#[tokio::test]
async fn exam_file_has_the_attempt_as_it_was_frozen() {
    let school = School::new().await;
    let mut teacher = school.browser("teacher").await;
    post(&mut teacher, &school.page(), &format!("{}/supervision", school.page()), &[("confirm", "yes")]).await;
    let file = school.freeze(&mut teacher).await;
    let sent = teacher.get(&file).await;
    assert_eq!((sent.status.as_u16(), sent.header("content-type")), (200, "application/x-tar"));
    assert_eq!(sent.header("content-length"), sent.body.len().to_string());
    let manifest = school.checked(&sent.body).unwrap();
    assert_eq!((manifest.school.as_str(), manifest.person.name.as_str()), ("North", "Somebody"));
    assert_eq!(manifest.attempt.id, school.attempt.to_string());
    assert!(manifest.proof.supervised && manifest.proof.counts && manifest.proof.resimulated, "{manifest:?}");
    assert!(manifest.proof.needed.contains("supervised"), "{manifest:?}");
    let [course] = &manifest.courses[..] else { panic!("{manifest:?}") };
    assert_eq!((course.id.as_str(), &course.course_mastered_at), ("lower-back-basics", &None));
    let entries = entries_of(&sent.body);
    assert_eq!(entries["recording.mcap"], school.recorded);
    let document = |name: &str| data_encoding::HEXLOWER.encode(&Sha256::digest(&entries[name]));
    assert_eq!(document("documents/exercise.toml"), manifest.attempt.exercise_sha256);
    assert_eq!(document("documents/scene.toml"), manifest.attempt.scene_sha256);
    assert_eq!(document(&format!("documents/course-{}.toml", course.sha256)), course.sha256);
    let json = |name: &str| serde_json::from_slice::<Value>(&entries[name]).unwrap();
    let scores = json("scores.json");
    assert_eq!(scores["computed"][0]["score"], manifest.grade.score);
    assert!(scores["metrics"].as_array().unwrap().len() > 10, "{scores}");
    assert_eq!(json("proofs.json")["supervised"]["by"], "Somebody");

    let grade = [("score", "12"), ("result", "failed"), ("reason", "The needle was bent")];
    let override_path = format!("{}/override", school.page());
    assert_eq!(post(&mut teacher, &school.page(), &override_path, &grade).await.status, 303);
    school.app.publish_with_pass_mark(school.ada.person.school_id, 99).await;
    let regrade = [("reason", "a new pass mark")];
    let regrade_path = format!("{}/regrade", school.page());
    assert_eq!(post(&mut teacher, &school.page(), &regrade_path, &regrade).await.status, 303);
    assert!(teacher.get(&file).await.body == sent.body, "later decisions do not change the file");
    let again = school.freeze(&mut teacher).await;
    assert_ne!(again, file, "a list");
    let later = teacher.get(&again).await.body;
    let manifest = school.checked(&later).unwrap();
    assert!(manifest.grade.overridden && (manifest.grade.score - 12.0).abs() < 1e-9, "{manifest:?}");
    let entries = entries_of(&later);
    assert!(
        entries.contains_key("documents/rubric.toml"),
        "the rubric is that of another revision: {:?}",
        entries.keys()
    );
    let decisions = String::from_utf8(entries["decisions.json"].clone()).unwrap();
    assert!(decisions.contains("The needle was bent") && decisions.contains("a new pass mark"), "{decisions}");
    let log: i64 = sqlx::query_scalar("SELECT count(*) FROM audit_log WHERE action = 'session.frozen'")
        .fetch_one(school.app.state.db.reader())
        .await
        .unwrap();
    assert_eq!(log, 2);
}

#[tokio::test]
async fn exam_file_is_frozen_and_read_by_teachers_only() {
    let school = School::new().await;
    let path = format!("{}/exam-files", school.page());
    let file = school.freeze(&mut school.browser("teacher").await).await;
    for (name, frozen, read) in
        [("ada", 403, 403), ("colleague", 404, 404), ("abroad", 404, 404), ("head", 303, 200), ("teacher", 303, 200)]
    {
        let mut browser = school.browser(name).await;
        let csrf = csrf_in(&browser.get("/account").await.text());
        assert_eq!(browser.form(&path, &[("csrf", &csrf)]).await.status, frozen, "{name} freezes");
        assert_eq!(browser.get(&file).await.status, read, "{name} reads");
    }
    let own = school.browser("ada").await.get(&school.page()).await.text();
    assert!(!own.contains("exam-files"), "a trainee is not shown what is refused");
    let mut teacher = school.browser("teacher").await;
    let other = file.rsplit_once('/').unwrap().1;
    let elsewhere = format!("/sessions/{}/exam-files/{other}", SessionId::random());
    assert_eq!(teacher.get(&elsewhere).await.status, 404, "by the id of another attempt");
    let ada = &school.ada.person;
    let export = exports::of_person(school.app.state.db.reader(), ada.school_id, ada.id).await.unwrap().unwrap();
    assert_eq!(export.held["exam_files"].len(), 3, "their own data name each file");
    for _ in 0..17 {
        school.freeze(&mut teacher).await;
    }
    let most = post(&mut teacher, &school.page(), &path, &[]).await;
    assert!(most.status == 409 && most.text().contains("20 times"), "{}", most.text());
}

#[tokio::test]
async fn exam_file_is_erased_with_its_person() {
    let school = School::new().await;
    let mut head = school.browser("head").await;
    let file = school.freeze(&mut head).await;
    let erase = format!("/people/{}/erase", school.ada.person.id);
    assert_eq!(post(&mut head, &erase, &erase, &[("confirm", "ada@example.org")]).await.status, 303);
    assert_eq!(head.get(&file).await.status, 410);
    let page = head.get(&school.page()).await.text();
    assert!(page.contains("erased with its person"), "{page}");
    let left: i64 = sqlx::query_scalar("SELECT CAST(sum(length(head)) AS BIGINT) FROM exam_files")
        .fetch_one(school.app.state.db.reader())
        .await
        .unwrap();
    assert_eq!(left, 0);
}

#[tokio::test]
async fn changed_byte_of_any_entry_is_named_at_the_terminal() {
    let school = School::new().await;
    let mut teacher = school.browser("teacher").await;
    let file = school.freeze(&mut teacher).await;
    let file = teacher.get(&file).await.body;
    let folder = tempfile::tempdir().unwrap();
    let verify = |bytes: &[u8], key: &str| {
        let path = folder.path().join("exam.tar");
        fs::write(&path, bytes).unwrap();
        let done = web_admin(folder.path(), &["exam", "verify", &path.to_string_lossy(), "--key", key]);
        (done.status.code(), String::from_utf8(done.stdout).unwrap())
    };
    let key = school.key();
    let (code, printed) = verify(&file, &key);
    assert!(code == Some(0) && printed.starts_with("genuine: exam file"), "{printed}");
    assert!(printed.contains("recording.mcap") && printed.contains("Somebody at North"), "{printed}");
    let (code, printed) = verify(&file, &"0".repeat(64));
    assert!(code == Some(1) && printed.starts_with("not genuine"), "{printed}");
    let mut archive = tar::Archive::new(&file[..]);
    for entry in archive.entries().unwrap().map(Result::unwrap) {
        let (name, middle) =
            (entry.path().unwrap().display().to_string(), entry.raw_file_position() + entry.size() / 2);
        let mut changed = file.clone();
        changed[usize::try_from(middle).unwrap()] ^= 1;
        let (code, printed) = verify(&changed, &key);
        assert!(code == Some(1) && printed.contains(&format!(" {name}")), "{name}: {printed}");
    }
    let gone = web_admin(folder.path(), &["exam", "verify", "nowhere.tar", "--key", &key]);
    assert_eq!(gone.status.code(), Some(2));
}
