//! Judgement, through the front door. Fails when a grade changes without a reason or a trace, when the computed score is
//! lost from sight, or when a page goes on counting what was overridden.

use model::Role;
use model::ids::SessionId;
use web_admin::worker;

use super::support::client::{Answer, Client, csrf_in};
use super::support::recordings::{Attempt, record, tampered};
use super::support::{App, Member};

struct School {
    app: App,
    ada: Member,
    attempt: SessionId,
}

async fn upload(app: &App, ada: &Member, recorded: fn(&Attempt) -> Vec<u8>) -> SessionId {
    let attempt = Attempt { session_id: SessionId::random(), ..Attempt::default() };
    assert_eq!(app.with_token(&ada.token).upload(&recorded(&attempt)).await.status, 201);
    worker::work_off_jobs(&app.state).await.unwrap();
    attempt.session_id
}

impl School {
    async fn new() -> Self {
        let app = App::new().await;
        let north = app.school("North").await;
        app.publish(north).await;
        let ada = app.member(north, Role::Trainee, "ada@example.org").await;
        let teacher = app.member(north, Role::Instructor, "teacher@example.org").await;
        app.member(north, Role::Instructor, "other@example.org").await;
        app.cohort(north, "Spring", &[&ada.person, &teacher.person]).await;
        let attempt = upload(&app, &ada, record).await;
        Self { app, ada, attempt }
    }

    fn path(&self, rest: &str) -> String {
        format!("/sessions/{}{rest}", self.attempt)
    }

    async fn send(&self, browser: &mut Client, rest: &str, fields: &[(&str, &str)]) -> Answer {
        let csrf = csrf_in(&browser.get(&self.path("/grade")).await.text());
        let fields: Vec<_> = fields.iter().copied().chain([("csrf", csrf.as_str())]).collect();
        browser.form(&self.path(rest), &fields).await
    }

    async fn computed(&self) -> f64 {
        let path = format!("/api/v1{}", self.path("/score"));
        self.app.with_token(&self.ada.token).get(&path).await.json()["score"].as_f64().unwrap()
    }

    async fn acts(&self) -> Vec<String> {
        let rows = sqlx::query_scalar("SELECT action FROM audit_log WHERE object = $1 ORDER BY seq");
        rows.bind(self.attempt.to_string()).fetch_all(self.app.state.db.reader()).await.unwrap()
    }
}

const GENEROUS: [(&str, &str); 3] = [("score", "97"), ("result", "passed"), ("reason", "The device slipped")];

#[tokio::test]
async fn an_override_counts_everywhere_and_the_computed_score_stays_beside_it() {
    let school = School::new().await;
    let computed = school.computed().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let done = school.send(&mut teacher, "/override", &GENEROUS).await;
    assert_eq!(done.status, 303, "{}", done.text());
    let mut ada = school.app.signed_in("ada@example.org").await;
    for path in [school.path("/grade"), school.path(""), "/".to_owned()] {
        let page = ada.get(&path).await.text();
        assert!(page.contains("97") && page.contains(&format!("{}", computed.round())), "{path}: {page}");
    }
    assert!(ada.get(&school.path("")).await.text().contains("The device slipped"));
    assert!((school.computed().await - computed).abs() < 1e-9, "the computed score is as it was");
    let path = format!("/api/v1{}", school.path("/score"));
    let told = school.app.with_token(&school.ada.token).get(&path).await.json();
    assert_eq!((&told["override"]["score"], &told["override"]["passed"]), (&97.0.into(), &true.into()), "{told}");
    assert_eq!(school.send(&mut teacher, "/override/withdraw", &[("reason", "It did not")]).await.status, 303);
    let history = ada.get(&school.path("/grade")).await.text();
    assert!(history.contains("The device slipped") && history.contains("It did not"), "{history}");
    assert!(!ada.get("/").await.text().contains(">97<"), "the computed score counts again");
    assert_eq!(school.acts().await[2..], ["grade.overridden", "grade.override_withdrawn"]);
}

#[tokio::test]
async fn an_override_without_a_reason_is_refused_and_what_was_typed_stays() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    for (field, value) in [("reason", ""), ("reason", "  "), ("score", "101"), ("score", "ten"), ("result", "")] {
        let fields: Vec<_> =
            GENEROUS.iter().copied().filter(|(name, _)| *name != field).chain([(field, value)]).collect();
        let refused = school.send(&mut teacher, "/override", &fields).await;
        assert_eq!(refused.status, 422, "{field}={value}");
        assert!(refused.text().contains("role=\"alert\"") && refused.text().contains(field), "{}", refused.text());
    }
    assert!(!school.acts().await.iter().any(|act| act.starts_with("grade.")), "nothing was kept");
}

#[tokio::test]
async fn only_those_who_teach_the_trainee_judge() {
    let school = School::new().await;
    let mut ada = school.app.signed_in("ada@example.org").await;
    assert_eq!(school.send(&mut ada, "/override", &GENEROUS).await.status, 403);
    assert_eq!(school.send(&mut ada, "/review", &[("mark", "reviewed")]).await.status, 403);
    assert_eq!(ada.get("/review").await.status, 403);
    assert_eq!(ada.get(&school.path("/regrade")).await.status, 403);
    let mut other = school.app.signed_in("other@example.org").await;
    let csrf = csrf_in(&other.get("/").await.text());
    for rest in ["/override", "/override/withdraw", "/review", "/regrade"] {
        let answer = other.form(&school.path(rest), &[("csrf", &csrf), ("reason", "x")]).await;
        assert_eq!(answer.status, 404, "{rest}");
    }
    assert_eq!(other.form(&school.path("/override"), &GENEROUS).await.status, 403, "without a token");
}

#[tokio::test]
async fn what_waits_is_listed_flagged_first_until_somebody_has_looked() {
    let school = School::new().await;
    let forged = upload(&school.app, &school.ada, tampered).await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let queue = teacher.get("/review").await.text();
    let place = |id: SessionId| queue.find(&format!("/sessions/{id}/replay")).unwrap();
    assert!(place(forged) < place(school.attempt), "{queue}");
    assert_eq!(school.send(&mut teacher, "/review", &[("mark", "reviewed")]).await.status, 303);
    assert!(!teacher.get("/review").await.text().contains(&school.attempt.to_string()));
    assert_eq!(school.send(&mut teacher, "/review", &[("mark", "reviewed")]).await.status, 303, "once is enough");
    assert_eq!(school.send(&mut teacher, "/review", &[("mark", "waiting")]).await.status, 303);
    assert!(teacher.get("/review").await.text().contains(&school.attempt.to_string()));
    assert_eq!(school.acts().await[2..], ["session.reviewed", "session.review_withdrawn"]);
    assert_eq!(school.send(&mut teacher, "/review", &[("mark", "maybe")]).await.status, 400);
    let mut other = school.app.signed_in("other@example.org").await;
    assert!(other.get("/review").await.text().contains("Nothing waits"));
}

#[tokio::test]
async fn another_rubric_is_shown_first_and_then_adds_a_score() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    assert!(teacher.get(&school.path("/regrade")).await.text().contains("has not changed"));
    school.app.publish_with_pass_mark(school.ada.person.school_id, 100).await;
    let preview = teacher.get(&school.path("/regrade")).await.text();
    assert!(preview.contains("By the rubric of today, not passed"), "{preview}");
    let count = || async {
        let scores = sqlx::query_scalar("SELECT count(*) FROM scores").fetch_one(school.app.state.db.reader());
        let scores: i64 = scores.await.unwrap();
        scores
    };
    assert_eq!(count().await, 1, "a preview changes nothing");
    let blank = school.send(&mut teacher, "/regrade", &[("reason", " \n")]).await;
    assert!(blank.status == 422 && blank.text().contains("reason: empty"), "{}", blank.text());
    let long = format!("again & again {}", "x".repeat(1000));
    let refused = school.send(&mut teacher, "/regrade", &[("reason", &long)]).await.text();
    assert!(
        refused.contains("1014 characters") && refused.contains("again &#38; again"),
        "what was typed stays: {refused}"
    );
    assert_eq!(count().await, 1, "a refusal changes nothing");
    let reason = ("reason", "The mark was raised for <everybody>.");
    assert_eq!(school.send(&mut teacher, "/regrade", &[reason]).await.status, 303);
    assert_eq!(count().await, 2);
    let told = teacher.get(&school.path("/grade")).await.text();
    for part in ["Computed", "Graded again", "for &#60;everybody&#62;"] {
        assert!(told.contains(part), "{part}: {told}");
    }
    let mut ada = school.app.signed_in("ada@example.org").await;
    assert!(ada.get(&school.path("/grade")).await.text().contains("The mark was raised"), "the trainee reads it");
    assert_eq!(school.acts().await.last().unwrap(), "session.regraded");
}
