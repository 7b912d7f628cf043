//! Exams at one station, through HTTP. Fails when a sitting begins twice or without its examiner, when a form is lost, when an attempt
//! outside the sitting or of another person belongs to it, when the second rater sees a name or a first rating before rating, when a
//! candidate sees a result before the exam is closed or one of others, and when an exam is reached from outside its cohort.

use acts::authoring::instruments;
use model::ids::{ExamId, SessionId};
use model::{Moment, Role};
use platform::clock::Clock;
use time::macros::datetime;
use web_admin::worker;

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member, course_folder};

const STEPS: [&str; 10] =
    ["entry", "angle", "skin", "steps", "resistance", "loss", "structures", "redirect", "target", "confirmation"];
const NAME: &str = "Ada Quillfeather";
const MINUTE_S: i64 = 60;

struct School {
    app: App,
    ada: Member,
    ben: Member,
    second: Member,
    colleague: Member,
    teacher: Client,
}

impl School {
    /// Ada and Ben are taught by two instructors; the second rater teaches nobody.
    async fn new() -> Self {
        let app = App::with(Clock::fixed(Moment::from(datetime!(2026-11-30 09:00 UTC))), |_| {}).await;
        let north = app.school("North").await;
        app.publish(north).await;
        let now = app.state.clock.now();
        for name in ["puncture-checklist", "global-rating-puncture", "free-comment"] {
            let document = course_folder().with_file_name("instruments").join(format!("{name}.toml"));
            app.write(async |tx| instruments::publish(tx, north, &document, now).await.unwrap()).await;
        }
        let ada = app.member(north, Role::Trainee, "ada@example.org").await;
        let ben = app.member(north, Role::Trainee, "ben@example.org").await;
        let teacher = app.member(north, Role::Instructor, "teacher@example.org").await;
        let colleague = app.member(north, Role::Instructor, "colleague@example.org").await;
        let second = app.member(north, Role::Instructor, "second@example.org").await;
        app.cohort(north, "Spring", &[&ada.person, &ben.person, &teacher.person, &colleague.person]).await;
        let named = sqlx::query("UPDATE people SET display_name = $1 WHERE id = $2").bind(NAME).bind(ada.person.id);
        app.write(async |tx| named.execute(tx).await.unwrap()).await;
        let teacher = app.signed_in("teacher@example.org").await;
        Self { app, ada, ben, second, colleague, teacher }
    }

    /// Sends the form of an exam by the second rater, with other values of some fields.
    async fn try_exam(&mut self, changed: &[(&str, &str)]) -> Answer {
        let page = self.teacher.get("/exams").await.text();
        let cohort = page.split("name=\"cohort\"").nth(1).unwrap().split("value=\"").nth(1).unwrap();
        let cohort = cohort.split('"').next().unwrap().to_owned();
        let second = self.second.person.id.to_string();
        let fields = [
            ("title", "Epidural station"),
            ("cohort", cohort.as_str()),
            ("exercise", "feel-the-layers"),
            ("instrument", "puncture-checklist"),
            ("limit", "10"),
            ("second", second.as_str()),
        ];
        let csrf = csrf_in(&page);
        let value = |(name, value)| (name, changed.iter().find(|(other, _)| *other == name).map_or(value, |one| one.1));
        let fields: Vec<_> = fields.into_iter().map(value).chain([("csrf", csrf.as_str())]).collect();
        self.teacher.form("/exams", &fields).await
    }

    /// Makes an exam with a second rater, and returns its address.
    async fn exam(&mut self) -> String {
        let made = self.try_exam(&[]).await;
        assert_eq!(made.status, 303, "{}", made.text());
        made.header("location").to_owned()
    }

    fn station(&self, exam: &str, candidate: &Member) -> String {
        format!("{exam}/candidates/{}", candidate.person.id)
    }

    /// Uploads and scores an attempt that starts now.
    async fn attempt(&self, trainee: &Member, seed: u64) -> SessionId {
        let started_at = self.app.state.clock.now().to_utc();
        let attempt = Attempt { started_at, seed, ..Attempt::default() };
        let sent = self.app.with_token(&trainee.token).upload(&record(&attempt)).await;
        assert_eq!(sent.status, 201, "{}", sent.text());
        worker::work_off_jobs(&self.app.state).await.unwrap();
        attempt.session_id
    }

    fn wait(&self, minutes: i64) {
        self.app.state.clock.advance(minutes * MINUTE_S);
    }

    /// Holds Ada's sitting with an attempt, of which all but the first steps are done.
    async fn examine_ada(&mut self, exam: &str) -> SessionId {
        let ada = self.station(exam, &self.ada);
        press(&mut self.teacher, &format!("{ada}/begin")).await;
        self.wait(1);
        let session = self.attempt(&self.ada, 7).await;
        self.wait(3);
        assert_eq!(fill_in(&mut self.teacher, &ada, 3, "finish").await.status, 303);
        session
    }
}

/// Sends a form without fields.
async fn press(client: &mut Client, path: &str) -> Answer {
    let csrf = csrf_in(&client.get("/account").await.text());
    client.form(path, &[("csrf", &csrf)]).await
}

/// Sends a checklist in which the first steps are not done.
async fn fill_in(client: &mut Client, page: &str, not_done: usize, step: &str) -> Answer {
    let csrf = csrf_in(&client.get("/account").await.text());
    let names = STEPS.map(|step| format!("q.{step}"));
    let mut fields = vec![("csrf", csrf.as_str()), ("do", step)];
    fields.extend(names.iter().enumerate().map(|(at, name)| (name.as_str(), if at < not_done { "0" } else { "1" })));
    client.form(page, &fields).await
}

#[tokio::test]
async fn sitting_begins_once_and_belongs_to_its_examiner() {
    let mut school = School::new().await;
    let exam = school.exam().await;
    let ada = school.station(&exam, &school.ada);
    let mut colleague = school.app.signed_in("colleague@example.org").await;
    assert_eq!(fill_in(&mut school.teacher, &ada, 0, "finish").await.status, 404, "not begun");
    assert_eq!(press(&mut school.teacher, &format!("{ada}/begin")).await.status, 303);
    for client in [&mut school.teacher, &mut colleague] {
        assert_eq!(press(client, &format!("{ada}/begin")).await.status, 409, "only once");
    }
    let page = school.teacher.get(&ada).await.text();
    assert!(page.contains("until 09:10, 10\u{a0}min left") && page.contains("name=\"q.entry\""), "{page}");
    let page = colleague.get(&ada).await.text();
    assert!(page.contains("filled in by the examiner") && !page.contains("name=\"q.entry\""), "{page}");
    assert_eq!(fill_in(&mut colleague, &ada, 0, "finish").await.status, 403);
    assert_eq!(fill_in(&mut school.teacher, &ada, 2, "save").await.status, 204);
    assert_eq!(school.teacher.get(&ada).await.text().matches("value=\"0\" checked").count(), 2);
    assert_eq!(fill_in(&mut school.teacher, &ada, 2, "finish").await.status, 303);
    for step in ["save", "finish"] {
        assert_eq!(fill_in(&mut school.teacher, &ada, 0, step).await.status, 409, "{step} after the finish");
    }
    let page = school.teacher.get(&exam).await.text();
    assert!(page.contains(">8<") && page.contains("not received") && page.contains("Not started"), "{page}");
    let acts = "SELECT count(*) FROM audit_log WHERE action IN ('exam.made', 'exam.begun', 'exam.finished')";
    let acts: i64 = sqlx::query_scalar(acts).fetch_one(school.app.state.db.reader()).await.unwrap();
    assert_eq!(acts, 3);
}

#[tokio::test]
async fn late_form_is_accepted_and_marked_as_late() {
    let mut school = School::new().await;
    let exam = school.exam().await;
    let ada = school.station(&exam, &school.ada);
    press(&mut school.teacher, &format!("{ada}/begin")).await;
    school.wait(12);
    assert!(school.teacher.get(&exam).await.text().contains("Time is over"));
    let csrf = csrf_in(&school.teacher.get(&ada).await.text());
    let blank = school.teacher.form(&ada, &[("csrf", &csrf), ("do", "finish"), ("q.entry", "1")]).await;
    assert_eq!(blank.status, 422);
    assert_eq!(blank.text().matches("Choose one, or tick").count(), 9, "{}", blank.text());
    assert_eq!(fill_in(&mut school.teacher, &ada, 0, "finish").await.status, 303);
    let page = school.teacher.get(&exam).await.text();
    assert!(page.contains("Finished late") && page.contains("after 12\u{a0}min, 2\u{a0}min late"), "{page}");
    let csv = school.teacher.get(&format!("{exam}/exam.csv")).await.text();
    let line = csv.lines().find(|line| line.starts_with(NAME)).unwrap();
    assert!(line.contains(",120,") && line.contains(",10,,,"), "{csv}");
    assert_eq!(csv.lines().count(), 3, "{csv}");
}

#[tokio::test]
async fn sitting_has_the_first_own_attempt_within_its_times() {
    let mut school = School::new().await;
    let exam = school.exam().await;
    let ada = school.station(&exam, &school.ada);
    let before = school.attempt(&school.ada, 1).await;
    school.wait(1);
    press(&mut school.teacher, &format!("{ada}/begin")).await;
    let ben = school.station(&exam, &school.ben);
    press(&mut school.teacher, &format!("{ben}/begin")).await;
    let shown = async |school: &mut School| {
        let page = school.teacher.get(&exam).await.text();
        [&school.ada, &school.ben].map(|one| {
            let row = page.split("<tr>").find(|row| row.contains(&format!("candidates/{}", one.person.id))).unwrap();
            row.split("/sessions/").nth(1).map(|rest| rest[..36].to_owned())
        })
    };
    assert_eq!(shown(&mut school).await, [None, None], "{before} was before");
    school.wait(1);
    let of_ben = school.attempt(&school.ben, 2).await.to_string();
    assert_eq!(shown(&mut school).await, [None, Some(of_ben.clone())], "an attempt of another person");
    school.wait(1);
    let first = school.attempt(&school.ada, 3).await.to_string();
    school.wait(1);
    school.attempt(&school.ada, 4).await;
    assert_eq!(shown(&mut school).await, [Some(first.clone()), Some(of_ben.clone())], "the first counts");
    assert_eq!(fill_in(&mut school.teacher, &ada, 0, "finish").await.status, 303);
    assert_eq!(shown(&mut school).await, [Some(first), Some(of_ben)]);

    let late = school.exam().await;
    let station = school.station(&late, &school.ada);
    press(&mut school.teacher, &format!("{station}/begin")).await;
    school.wait(11);
    let after = school.attempt(&school.ada, 5).await.to_string();
    school.wait(1);
    assert_eq!(fill_in(&mut school.teacher, &station, 0, "finish").await.status, 303);
    let page = school.teacher.get(&late).await.text();
    assert!(!page.contains(&after) && page.contains("not received"), "it began after the limit: {page}");
}

#[tokio::test]
async fn second_rater_rates_blinded_and_agreement_follows() {
    let mut school = School::new().await;
    let exam = school.exam().await;
    let session = school.examine_ada(&exam).await;
    let page = school.teacher.get(&exam).await.text();
    assert!(page.contains("1 attempt waits") && page.contains(">7<"), "{page}");
    assert_eq!(press(&mut school.teacher, &format!("{exam}/second-ratings")).await.status, 303);
    let mut second = school.app.signed_in("second@example.org").await;
    let round = school.teacher.get(&exam).await.link("/ratings/");
    let own = second.get(&round).await.link("/rate/");
    for path in ["/ratings", &round, &own] {
        let text = second.get(path).await.text();
        for hidden in [NAME, &school.ada.person.pseudonym, &session.to_string(), "ICC", "Not done</td>"] {
            assert!(!text.contains(hidden), "{path} contains {hidden}: {text}");
        }
    }
    for path in [exam.clone(), format!("{exam}/exam.csv"), school.station(&exam, &school.ada)] {
        assert_eq!(second.get(&path).await.status, 404, "{path}: they do not teach the cohort");
    }
    assert_eq!(fill_in(&mut second, &own, 4, "finish").await.status, 303);
    let page = school.teacher.get(&exam).await.text();
    for wanted in [">7<", ">6<", "−1", "not computable", "0 excluded", &session.to_string()] {
        assert!(page.contains(wanted), "{wanted} is missing in {page}");
    }
    let told: i64 = sqlx::query_scalar("SELECT count(*) FROM notices WHERE person_id = $1")
        .bind(school.ada.person.id)
        .fetch_one(school.app.state.db.reader())
        .await
        .unwrap();
    assert_eq!(told, 0, "the candidate gets no notice of the second rating");
    let grade = school.teacher.get(&format!("/sessions/{session}/grade")).await.text();
    assert!(!grade.contains("Epidural station"), "a second rating alone is no result: {grade}");
    assert_eq!(press(&mut school.teacher, &format!("{round}/withdraw")).await.status, 303);
    let page = school.teacher.get(&exam).await.text();
    assert!(page.contains("1 attempt waits") && !page.contains(">6<"), "a withdrawn round is asked anew: {page}");
}

#[tokio::test]
async fn second_rater_of_the_own_cohort_sees_ratings_after_all() {
    let mut school = School::new().await;
    let mut colleague = school.app.signed_in("colleague@example.org").await;
    let id = school.colleague.person.id.to_string();
    let exam = school.try_exam(&[("second", &id)]).await.header("location").to_owned();
    let ada = school.station(&exam, &school.ada);
    assert_eq!(press(&mut colleague, &format!("{ada}/begin")).await.status, 403, "the second rater does not examine");
    let session = school.examine_ada(&exam).await.to_string();
    press(&mut school.teacher, &format!("{exam}/second-ratings")).await;
    for path in [&exam, &ada] {
        let page = colleague.get(path).await.text();
        for hidden in [session.as_str(), ">7<", "Not done", "ICC"] {
            assert!(!page.contains(hidden), "{path} contains {hidden}: {page}");
        }
    }
    assert_eq!(colleague.get(&format!("{exam}/exam.csv")).await.status, 403);
    for act in ["close", "second-ratings"] {
        assert_eq!(press(&mut colleague, &format!("{exam}/{act}")).await.status, 403, "{act}");
    }
    let round = school.teacher.get(&exam).await.link("/ratings/");
    let own = colleague.get(&round).await.link("/rate/");
    assert_eq!(fill_in(&mut colleague, &own, 4, "finish").await.status, 303);
    assert!(!colleague.get(&exam).await.text().contains(">7<"), "not before the exam is closed");
    assert_eq!(press(&mut school.teacher, &format!("{exam}/close")).await.status, 303);
    assert!(colleague.get(&exam).await.text().contains(">7<"));
    let known: bool =
        sqlx::query_scalar("SELECT may_know FROM ratings").fetch_one(school.app.state.db.reader()).await.unwrap();
    assert!(known, "the rater teaches the candidate, and the rating is marked");
}

#[tokio::test]
async fn candidate_sees_the_own_result_after_closing_alone() {
    let mut school = School::new().await;
    let exam = school.exam().await;
    let session = school.examine_ada(&exam).await;
    let mut ada = school.app.signed_in("ada@example.org").await;
    let mut ben = school.app.signed_in("ben@example.org").await;
    assert!(ada.get("/exams").await.text().contains("No results yet"));
    let held = ada.get("/account/export").await.json();
    assert_eq!(held["exam_sittings"][0]["answers"], serde_json::json!([]), "{held}");
    let station = school.station(&exam, &school.ben);
    press(&mut school.teacher, &format!("{station}/begin")).await;
    let page = school.teacher.get(&exam).await.text();
    assert!(page.contains("1 sitting is not finished"), "{page}");
    assert_eq!(press(&mut school.teacher, &format!("{exam}/close")).await.status, 303);
    let page = ada.get("/exams").await.text();
    for wanted in ["Epidural station", ">7<", "Not done", &format!("/sessions/{session}")] {
        assert!(page.contains(wanted), "{wanted} is missing in {page}");
    }
    assert!(ben.get("/exams").await.text().contains("No results yet"), "his sitting was not finished");
    for path in [exam.clone(), school.station(&exam, &school.ada)] {
        assert_eq!(ada.get(&path).await.status, 403, "{path}");
    }
    assert_eq!(fill_in(&mut school.teacher, &station, 0, "finish").await.status, 409, "the exam is closed");
    assert_eq!(press(&mut school.teacher, &format!("{exam}/close")).await.status, 409);
    let held = ada.get("/account/export").await.json();
    assert_eq!(held["exam_sittings"][0]["answers"].as_array().unwrap().len(), 10, "{held}");
}

#[tokio::test]
async fn exam_is_not_found_from_outside_its_cohort() {
    let mut school = School::new().await;
    let exam = school.exam().await;
    let south = school.app.school("South").await;
    school.app.member(south, Role::Administrator, "chief@example.org").await;
    let ada = school.station(&exam, &school.ada);
    for email in ["chief@example.org", "second@example.org"] {
        let mut client = school.app.signed_in(email).await;
        for path in [exam.clone(), ada.clone(), format!("{exam}/exam.csv")] {
            assert_eq!(client.get(&path).await.status, 404, "{email}: {path}");
        }
        for path in [format!("{ada}/begin"), format!("{exam}/close"), format!("{exam}/second-ratings")] {
            assert_eq!(press(&mut client, &path).await.status, 404, "{email}: {path}");
        }
        assert!(!client.get("/exams").await.text().contains("Epidural station"));
    }
    let nobody = format!("{exam}/candidates/{}/begin", school.colleague.person.id);
    assert_eq!(press(&mut school.teacher, &nobody).await.status, 404, "no trainee of the cohort");
    assert_eq!(school.teacher.get(&format!("/exams/{}", ExamId::random())).await.status, 404);
}

#[tokio::test]
async fn refused_exam_keeps_its_input() {
    let mut school = School::new().await;
    for (field, value, word) in [
        ("limit", "121", "1 to 120 minutes"),
        ("limit", "", "1 to 120 minutes"),
        ("title", "", "title: 0 characters"),
        ("instrument", "free-comment", "without free text"),
        ("instrument", "nothing", "does not exist"),
        ("second", "nobody", "instructors of the school"),
    ] {
        let refused = school.try_exam(&[(field, value)]).await;
        assert_eq!(refused.status, 422, "{field}");
        let page = refused.text();
        assert!(page.to_lowercase().contains(word), "{word} is missing in {page}");
        assert!(field == "title" || page.contains("value=\"Epidural station\""), "{page}");
    }
    for (field, value) in [("cohort", "x"), ("exercise", "x")] {
        assert_eq!(school.try_exam(&[(field, value)]).await.status, 404, "{field}");
    }
    let made: i64 =
        sqlx::query_scalar("SELECT count(*) FROM exams").fetch_one(school.app.state.db.reader()).await.unwrap();
    assert_eq!(made, 0);
}

#[tokio::test]
async fn a_frozen_attempt_contains_the_rating_of_its_examiner() {
    let mut school = School::new().await;
    let exam = school.exam().await;
    let session = school.examine_ada(&exam).await;
    let page = format!("/sessions/{session}");
    assert_eq!(press(&mut school.teacher, &format!("{page}/exam-files")).await.status, 303);
    let (shown, files) = (school.teacher.get(&page).await.text(), format!("{page}/exam-files/"));
    let file = shown.split(&files).nth(1).expect("a file").split('"').next().unwrap();
    let tar = school.teacher.get(&format!("{files}{file}")).await.body;
    let tar = String::from_utf8_lossy(&tar);
    assert!(tar.contains("\"round\": \"Epidural station\"") && tar.contains("\"item\": \"entry\""), "{tar}");
}

#[tokio::test]
async fn second_rater_reads_no_exam_file_before_rating() {
    let mut school = School::new().await;
    let colleague = school.colleague.person.id.to_string();
    let exam = school.try_exam(&[("second", &colleague)]).await.header("location").to_owned();
    let session = school.examine_ada(&exam).await;
    let (page, files) = (format!("/sessions/{session}"), format!("/sessions/{session}/exam-files"));
    let mut colleague = school.app.signed_in("colleague@example.org").await;
    assert_eq!(press(&mut colleague, &files).await.status, 409, "the second rating is not requested yet");
    assert_eq!(press(&mut school.teacher, &files).await.status, 303);
    let frozen = school.teacher.get(&page).await.link(&format!("{files}/"));
    assert_eq!(colleague.get(&frozen).await.status, 409);
    assert_eq!(school.teacher.get(&frozen).await.status, 200);
}
