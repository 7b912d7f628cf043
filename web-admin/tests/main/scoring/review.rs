//! Judgement, through the front door. Fails when a grade changes without a reason or a trace, when the computed score is
//! lost from sight, or when a page goes on counting what was overridden.

use model::Role;
use model::ids::SessionId;
use web_admin::worker;

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record, tampered};
use crate::support::{App, Member};

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
async fn override_counts_everywhere_and_keeps_the_computed_score() {
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
async fn override_with_invalid_fields_is_rejected_and_not_stored() {
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
    assert!(other.get("/review").await.text().contains("Nothing to review"));
}

#[tokio::test]
async fn review_queue_puts_questions_first_and_leads_to_the_next() {
    let school = School::new().await;
    let mut attempts = vec![school.attempt];
    for _ in 0..3 {
        attempts.push(upload(&school.app, &school.ada, record).await);
    }
    let [oldest, failed, asked, passed] = attempts[..] else { panic!("four attempts") };
    for (session, is_pass) in [(oldest, true), (failed, false), (asked, true), (passed, true)] {
        let grade = sqlx::query("UPDATE grades SET passed = $2 WHERE session_id = $1").bind(session).bind(is_pass);
        school.app.write(async |tx| grade.execute(tx).await.unwrap()).await;
    }
    let mut ada = school.app.signed_in("ada@example.org").await;
    let csrf = csrf_in(&ada.get("/").await.text());
    let fields = [("csrf", csrf.as_str()), ("kind", "question"), ("from_s", "0.1"), ("body", "Was that right?")];
    assert_eq!(ada.form(&format!("/sessions/{asked}/comments"), &fields).await.status, 303);
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let order = |page: &str| -> Vec<usize> {
        let mut places: Vec<(usize, usize)> = attempts
            .iter()
            .enumerate()
            .filter_map(|(n, id)| Some((page.find(&format!("/sessions/{id}/replay"))?, n)))
            .collect();
        places.sort_unstable();
        places.into_iter().map(|(_, n)| n).collect()
    };
    let queue = teacher.get("/review").await.text();
    let shown = order(&queue);
    assert_eq!(shown[..2], [2, 1], "a question, then a fail, then the passes: {queue}");
    assert_eq!(shown.len(), 4);
    assert_eq!(order(&teacher.get("/review?what=failed").await.text()), [1]);
    assert_eq!(order(&teacher.get("/review?what=question").await.text()), [2]);
    assert!(teacher.get("/review?what=flagged").await.text().contains("No waiting attempt matches this filter"));
    let at = |id: &str| format!("/review?exercise={id}");
    let exercise = teacher.get("/review").await.text().split("name=\"exercise\"").nth(1).unwrap().to_owned();
    let exercise = exercise.split("value=\"").nth(2).unwrap().split('"').next().unwrap().to_owned();
    assert_eq!(order(&teacher.get(&at(&exercise)).await.text()).len(), 4, "all are at {exercise}");
    assert!(teacher.get(&at("another")).await.text().contains("No waiting attempt matches this filter"));
    let nowhere = "/review?cohort=00000000-0000-0000-0000-000000000001";
    assert!(order(&teacher.get(nowhere).await.text()).is_empty(), "a cohort that they do not teach");
    let replay = teacher.get(&format!("/sessions/{asked}/replay")).await.text();
    assert!(replay.contains("Mark as reviewed, go to next"), "{replay}");
    let csrf = csrf_in(&replay);
    let look = [("csrf", csrf.as_str()), ("mark", "reviewed"), ("then", "next")];
    let next = teacher.form(&format!("/sessions/{asked}/review"), &look).await;
    assert_eq!(next.header("location"), format!("/sessions/{failed}/replay"), "on to what waits first");
    let look = [&look[..], &[("what", "failed")]].concat();
    let next = teacher.form(&format!("/sessions/{failed}/review"), &look).await;
    assert_eq!(next.header("location"), "/review?what=failed", "that part of the queue is empty");
    assert!(!ada.get(&format!("/sessions/{asked}/replay")).await.text().contains("Mark as reviewed, go to next"));
}

#[tokio::test]
async fn a_long_queue_has_pages_and_a_rank_follows_answers_and_grades() {
    let school = School::new().await;
    let rank = async |session: SessionId| -> i64 {
        let rank = sqlx::query_scalar("SELECT review_rank FROM sessions WHERE id = $1").bind(session);
        rank.fetch_one(school.app.state.db.reader()).await.unwrap()
    };
    let copy = "WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 60)
        INSERT INTO sessions (school_id, id, trainee_id, exercise_id, exercise_sha256, scene_sha256, revision_id, started_at,
          received_at, duration_s, complete, device, simulator_version, seed, state, recording_path, recording_sha256,
          recording_size)
        SELECT school_id, randomblob(16), trainee_id, exercise_id, exercise_sha256, scene_sha256, revision_id, started_at,
          received_at, duration_s, complete, device, simulator_version, seed, state, recording_path || i, recording_sha256,
          recording_size FROM sessions CROSS JOIN n";
    let grade = "INSERT INTO grades (school_id, session_id, score_id, score, passed)
        SELECT s.school_id, s.id, g.score_id, 50 + s.rowid % 40, s.rowid % 3 > 0 FROM sessions s CROSS JOIN grades g
        WHERE s.id <> g.session_id";
    school
        .app
        .write(async |tx| {
            for statement in [copy, grade] {
                sqlx::query(statement).execute(&mut *tx).await.unwrap();
            }
        })
        .await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let first = teacher.get("/review").await.text();
    assert_eq!(first.matches("data-label=\"Review it\"").count(), 50);
    let next = first.split("href=\"").find(|rest| rest.starts_with("/review?after=")).expect("a next page");
    let rest = teacher.get(&next.split('"').next().unwrap().replace("&amp;", "&")).await.text();
    assert_eq!(rest.matches("data-label=\"Review it\"").count(), 11, "{rest}");
    assert!(rest.contains("From the beginning"));
    let passed = sqlx::query_scalar("SELECT passed FROM grades WHERE session_id = $1").bind(school.attempt);
    let passed: bool = passed.fetch_one(school.app.state.db.reader()).await.unwrap();
    assert_eq!(rank(school.attempt).await, 1 - i64::from(passed));
    let mut ada = school.app.signed_in("ada@example.org").await;
    let csrf = csrf_in(&ada.get("/").await.text());
    let fields = [("csrf", csrf.as_str()), ("kind", "question"), ("from_s", "0.1"), ("body", "Was that right?")];
    assert_eq!(ada.form(&school.path("/comments"), &fields).await.status, 303);
    assert_eq!(rank(school.attempt).await & 4, 4);
    let page = teacher.get(&school.path("/replay")).await.text();
    let answers = page.split("action=\"").find(|rest| rest.contains("/answers\"")).unwrap().split('"').next().unwrap();
    assert_eq!(teacher.form(answers, &[("csrf", &csrf_in(&page)), ("body", "It was")]).await.status, 303);
    assert_eq!(rank(school.attempt).await & 4, 0, "the question is answered");
    assert_eq!(school.send(&mut teacher, "/override", &GENEROUS).await.status, 303);
    assert_eq!(rank(school.attempt).await, 0, "it counts as a pass");
}

#[tokio::test]
async fn another_rubric_is_shown_first_and_then_adds_a_score() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    assert!(teacher.get(&school.path("/regrade")).await.text().contains("has not changed"));
    school.app.publish_with_pass_mark(school.ada.person.school_id, 100).await;
    let preview = teacher.get(&school.path("/regrade")).await.text();
    assert!(preview.contains("With the current rubric, not passed"), "{preview}");
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
    for part in ["Computed", "Re-graded", "for &#60;everybody&#62;"] {
        assert!(told.contains(part), "{part}: {told}");
    }
    let mut ada = school.app.signed_in("ada@example.org").await;
    assert!(ada.get(&school.path("/grade")).await.text().contains("The mark was raised"), "the trainee reads it");
    assert_eq!(school.acts().await.last().unwrap(), "session.regraded");
}
