//! Every attempt at an exercise by another rubric, through the front door. Fails when a grade changes that nobody was shown,
//! when an attempt of somebody else's trainee is touched, when an override stops counting, or when a confirmation is
//! taken after attempts have changed.

use acts::scoring::regrading::{Rubric, exercise};
use model::Role;
use model::ids::{RevisionId, SessionId};
use store::Connection;
use store::authoring::exercises;
use store::recordings::sessions;
use store::scoring::regradings;
use web_admin::worker;

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, FORGED, record};
use crate::support::{App, Member};

const EXERCISE: &str = "/exercises/feel-the-layers";
const REASON: (&str, &str) = ("reason", "The department has voted for a stricter mark");

/// Ada is taught by the teacher, Ben by the colleague; one attempt of each, and then a stricter pass mark.
struct School {
    app: App,
    ada: Member,
    attempts: [SessionId; 2],
    lenient: RevisionId,
    strict: RevisionId,
}

async fn try_it(app: &App, trainee: &Member) -> SessionId {
    let attempt = Attempt { bundle: &FORGED, ..Attempt::default() };
    assert_eq!(app.with_token(&trainee.token).upload(&record(&attempt)).await.status, 201);
    worker::work_off_jobs(&app.state).await.unwrap();
    attempt.session_id
}

impl School {
    async fn new() -> Self {
        let app = App::new().await;
        let north = app.school("North").await;
        app.publish_with_pass_mark(north, 0).await;
        let ada = app.member(north, Role::Trainee, "ada@example.org").await;
        let ben = app.member(north, Role::Trainee, "ben@example.org").await;
        let teacher = app.member(north, Role::Instructor, "teacher@example.org").await;
        let colleague = app.member(north, Role::Instructor, "colleague@example.org").await;
        app.member(north, Role::Administrator, "admin@example.org").await;
        app.cohort(north, "A", &[&ada.person, &teacher.person]).await;
        app.cohort(north, "B", &[&ben.person, &colleague.person]).await;
        let attempts = [try_it(&app, &ada).await, try_it(&app, &ben).await];
        app.publish_with_pass_mark(north, 100).await;
        let revisions =
            exercises::list_exercise_revisions(app.state.db.reader(), north, "feel-the-layers").await.unwrap();
        let [strict, lenient] = [revisions[0].id, revisions[1].id];
        Self { app, ada, attempts, lenient, strict }
    }

    async fn send(&self, browser: &mut Client, path: &str, fields: &[(&str, &str)]) -> Answer {
        let csrf = csrf_in(&browser.get("/account").await.text());
        let fields: Vec<_> = fields.iter().copied().chain([("csrf", csrf.as_str())]).collect();
        browser.form(path, &fields).await
    }

    /// Looks by the rubric of a revision; the page of what it would change.
    async fn look(&self, browser: &mut Client, revision: RevisionId) -> String {
        let begun = self.send(browser, &format!("{EXERCISE}/regrade"), &[("revision", &revision.to_string())]).await;
        assert_eq!(begun.status, 303, "{}", begun.text());
        let page = begun.header("location").to_owned();
        assert!(browser.get(&page).await.text().contains("0 of "), "nothing was looked at yet");
        worker::work_off_jobs(&self.app.state).await.unwrap();
        page
    }

    async fn confirm(&self, browser: &mut Client, page: &str, reason: (&str, &str)) -> Answer {
        let shown = browser.get(page).await.text();
        let digest = shown.split("name=\"digest\" value=\"").nth(1).expect("a digest").split('"').next().unwrap();
        self.send(browser, page, &[("digest", digest), reason]).await
    }

    async fn scores(&self, attempt: SessionId) -> i64 {
        let count = sqlx::query_scalar("SELECT count(*) FROM scores WHERE session_id = $1").bind(attempt);
        count.fetch_one(self.app.state.db.reader()).await.unwrap()
    }

    /// Whether the grade that counts is a pass.
    async fn passes(&self, attempt: SessionId) -> bool {
        let passed = sqlx::query_scalar("SELECT passed FROM grades WHERE session_id = $1").bind(attempt);
        passed.fetch_one(self.app.state.db.reader()).await.unwrap()
    }

    async fn acts(&self, object: &str) -> Vec<(String, String)> {
        let rows = sqlx::query_as("SELECT action, actor FROM audit_log WHERE object = $1 ORDER BY seq");
        rows.bind(object).fetch_all(self.app.state.db.reader()).await.unwrap()
    }

    async fn lose_recording(&self, attempt: SessionId) {
        let path = sqlx::query_scalar("SELECT recording_path FROM sessions WHERE id = $1").bind(attempt);
        let path: String = path.fetch_one(self.app.state.db.reader()).await.unwrap();
        std::fs::remove_file(self.app.state.config.recordings_dir.join(path)).unwrap();
    }

    /// As if they had been measured before their definitions were changed.
    async fn forget_metrics(&self, attempt: SessionId) {
        let older = async |tx: &mut Connection| {
            let later = sqlx::query("DELETE FROM metrics WHERE version > 1 AND session_id = $1").bind(attempt);
            later.execute(&mut *tx).await.unwrap();
            let older = sqlx::query("UPDATE metrics SET version = 0 WHERE session_id = $1").bind(attempt);
            assert!(older.execute(tx).await.unwrap().rows_affected() > 0);
        };
        self.app.write(older).await;
    }

    async fn override_ada(&self, browser: &mut Client) {
        let path = format!("/sessions/{}/override", self.attempts[0]);
        let fields = [("score", "97"), ("result", "passed"), ("reason", "The device slipped")];
        assert_eq!(self.send(browser, &path, &fields).await.status, 303);
    }
}

/// How many attempts a page says there are of an outcome.
fn tile(page: &str, word: &str) -> u32 {
    let after = page.split(&format!("?show={word}#attempts")).nth(1).unwrap_or_else(|| panic!("no {word} in {page}"));
    after.split("<dd>").nth(1).unwrap().split('<').next().unwrap().trim().parse().unwrap()
}

#[tokio::test]
async fn regrading_applies_the_preview_to_own_trainees_only() {
    let school = School::new().await;
    let [adas, bens] = school.attempts;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let page = school.look(&mut teacher, school.strict).await;
    let shown = teacher.get(&page).await.text();
    assert_eq!([tile(&shown, "passes"), tile(&shown, "fails")], [0, 1], "{shown}");
    assert!(shown.contains(&adas.to_string()) && !shown.contains(&bens.to_string()), "{shown}");
    assert_eq!(school.scores(adas).await, 1, "looking changes nothing");
    let refused = school.confirm(&mut teacher, &page, ("reason", " ")).await;
    assert_eq!(refused.status, 422);
    assert!(refused.text().contains("role=\"alert\"") && refused.text().contains("reason"), "{}", refused.text());

    assert_eq!(school.confirm(&mut teacher, &page, REASON).await.status, 303);
    assert!(teacher.get(&page).await.text().contains("0 of 1"), "its scores wait for the worker");
    worker::work_off_jobs(&school.app.state).await.unwrap();
    assert!(teacher.get(&page).await.text().contains("1 attempt was re-graded"));
    assert_eq!([school.scores(adas).await, school.scores(bens).await], [2, 1]);
    assert_eq!([school.passes(adas).await, school.passes(bens).await], [false, true]);
    let judged = teacher.get(&format!("/sessions/{adas}")).await.text();
    assert!(
        judged.contains("the pass mark is 100"),
        "that of the rubric that has judged, not of the one that was shown: {judged}"
    );
    let mut ada = school.app.signed_in("ada@example.org").await;
    let history = ada.get(&format!("/sessions/{adas}/grade")).await.text();
    assert!(history.contains("Re-graded") && history.contains(REASON.1), "{history}");
    let listed = teacher.get(&format!("{EXERCISE}/regrade")).await.text();
    assert!(listed.contains(REASON.1) && listed.contains(&page), "{listed}");

    let (action, by) = school.acts("feel-the-layers").await.pop().unwrap();
    assert_eq!(action, "exercise.regraded");
    assert_eq!(school.acts(&adas.to_string()).await.pop().unwrap(), ("session.regraded".to_owned(), by));
    let again = school.look(&mut teacher, school.strict).await;
    assert!(teacher.get(&again).await.text().contains("already graded with this rubric"));
}

#[tokio::test]
async fn an_earlier_rubric_is_chosen_and_an_override_goes_on_counting() {
    let school = School::new().await;
    let [adas, bens] = school.attempts;
    let mut admin = school.app.signed_in("admin@example.org").await;
    let page = school.look(&mut admin, school.strict).await;
    assert_eq!(tile(&admin.get(&page).await.text(), "fails"), 2, "an administrator grades the whole school's");
    assert_eq!(school.confirm(&mut admin, &page, REASON).await.status, 303);
    worker::work_off_jobs(&school.app.state).await.unwrap();
    school.override_ada(&mut admin).await;
    let page = school.look(&mut admin, school.lenient).await;
    let shown = admin.get(&page).await.text();
    assert_eq!([tile(&shown, "passes"), tile(&shown, "overridden")], [1, 1], "{shown}");
    let listed = admin.get(&format!("{page}?show=overridden")).await.text();
    assert!(listed.contains("97 continues to count") && !listed.contains(&bens.to_string()), "{listed}");
    assert_eq!(school.confirm(&mut admin, &page, REASON).await.status, 303);
    worker::work_off_jobs(&school.app.state).await.unwrap();
    assert_eq!([school.scores(adas).await, school.scores(bens).await], [3, 3]);
    let counts: f64 = sqlx::query_scalar("SELECT score FROM grades WHERE session_id = $1")
        .bind(adas)
        .fetch_one(school.app.state.db.reader())
        .await
        .unwrap();
    assert!((counts - 97.0).abs() < 1e-9 && school.passes(bens).await);
}

#[tokio::test]
async fn attempts_that_have_changed_since_are_not_graded_unseen() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let page = school.look(&mut teacher, school.strict).await;
    try_it(&school.app, &school.ada).await;
    let stale = school.confirm(&mut teacher, &page, REASON).await;
    assert_eq!(stale.status, 409);
    assert!(
        stale.text().contains("Nothing was changed") && stale.text().contains("Preview the changes again"),
        "{}",
        stale.text()
    );
    let page = school.look(&mut teacher, school.strict).await;
    assert_eq!(tile(&teacher.get(&page).await.text(), "fails"), 2);
    school.override_ada(&mut teacher).await;
    assert_eq!(school.confirm(&mut teacher, &page, REASON).await.status, 409, "an override was put in place since");
    worker::work_off_jobs(&school.app.state).await.unwrap();
    assert_eq!(school.scores(school.attempts[0]).await, 1);
    assert!(school.acts("feel-the-layers").await.iter().all(|(act, _)| act != "exercise.regraded"));
    let page = school.look(&mut teacher, school.strict).await;
    assert_eq!(school.confirm(&mut teacher, &page, REASON).await.status, 303);
    let digest = [("digest", "x"), REASON];
    assert_eq!(school.send(&mut teacher, &page, &digest).await.status, 409, "once is enough");
    assert_eq!(school.send(&mut teacher, &format!("{page}/forget"), &[]).await.status, 409);
}

#[tokio::test]
async fn regrading_skips_attempts_graded_since_or_unreadable() {
    let school = School::new().await;
    let (adas, mut teacher) = (school.attempts[0], school.app.signed_in("teacher@example.org").await);
    let lost = try_it(&school.app, &school.ada).await;
    school.lose_recording(lost).await;
    school.forget_metrics(lost).await;
    let page = school.look(&mut teacher, school.strict).await;
    let shown = teacher.get(&format!("{page}?show=left")).await.text();
    assert_eq!([tile(&shown, "left"), tile(&shown, "fails")], [1, 1], "{shown}");
    assert!(shown.contains("unchanged: "), "{shown}");
    assert_eq!(school.confirm(&mut teacher, &page, REASON).await.status, 303);
    assert_eq!(school.send(&mut teacher, &format!("/sessions/{adas}/regrade"), &[REASON]).await.status, 303);
    worker::work_off_jobs(&school.app.state).await.unwrap();
    assert_eq!([school.scores(adas).await, school.scores(lost).await], [2, 1], "not a third time");
    let shown = teacher.get(&format!("{page}?show=left")).await.text();
    assert!(shown.contains("graded by another person since then") && tile(&shown, "left") == 2, "{shown}");
}

#[tokio::test]
async fn what_was_measured_is_judged_as_the_recording_is() {
    let school = School::new().await;
    let (state, [adas, bens]) = (&school.app.state, school.attempts);
    let school_id = school.ada.person.school_id;
    let rubric = Rubric::of_revision(state, school_id, school.strict).await.unwrap();
    let judge = async |attempt: SessionId| {
        let attempt = sessions::find_session(state.db.reader(), school_id, attempt).await.unwrap().unwrap();
        rubric.judge(state, &attempt).await
    };
    let measured = judge(adas).await.unwrap();
    assert!(!measured.passed && measured.deductions.iter().any(|line| line.points > 0.0), "{measured:?}");
    school.forget_metrics(adas).await;
    assert_eq!(judge(adas).await.unwrap(), measured, "from the recording");
    school.lose_recording(bens).await;
    assert_eq!(judge(bens).await.unwrap().score.to_bits(), measured.score.to_bits(), "the same motion, without it");
    school.forget_metrics(bens).await;
    judge(bens).await.unwrap_err();
}

#[tokio::test]
async fn only_a_teacher_previews_and_only_the_previewer_confirms() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let page = school.look(&mut teacher, school.strict).await;
    let fields = [("digest", "x"), REASON];
    for (who, seen, confirmed) in [("ada", 403, 403), ("colleague", 404, 404), ("admin", 200, 403)] {
        let mut browser = school.app.signed_in(&format!("{who}@example.org")).await;
        assert_eq!(browser.get(&page).await.status, seen, "{who}");
        assert_eq!(school.send(&mut browser, &page, &fields).await.status, confirmed, "{who}");
        assert_eq!(school.send(&mut browser, &format!("{page}/forget"), &[]).await.status, confirmed, "{who}");
    }
    let begin = format!("{EXERCISE}/regrade");
    for revision in [RevisionId::random().to_string(), "x".to_owned()] {
        assert_eq!(school.send(&mut teacher, &begin, &[("revision", &revision)]).await.status, 404);
    }
    let other =
        exercises::find_current_revision(school.app.state.db.reader(), school.ada.person.school_id, "stop-in-the-fat")
            .await;
    let other = other.unwrap().unwrap().id.to_string();
    assert_eq!(school.send(&mut teacher, &begin, &[("revision", &other)]).await.status, 404, "of another exercise");
    let untried = "/exercises/stop-in-the-fat/regrade";
    assert_eq!(school.send(&mut teacher, untried, &[("revision", &other)]).await.status, 409, "nobody has tried it");

    assert_eq!(school.send(&mut teacher, &format!("{page}/forget"), &[]).await.status, 303);
    assert_eq!(teacher.get(&page).await.status, 404);
    let kept = school.look(&mut teacher, school.strict).await;
    let now = school.app.state.clock.now();
    let tomorrow = now.plus_s(exercise::PREVIEW_LIFETIME_S + 60);
    let before = tomorrow.plus_s(-exercise::PREVIEW_LIFETIME_S);
    school.app.write(async |tx| regradings::forget_before(tx, before).await.unwrap()).await;
    assert_eq!(teacher.get(&kept).await.status, 404, "nobody has confirmed it within a day");
}
