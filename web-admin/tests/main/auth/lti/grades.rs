//! Grades for learning platforms. Fails when a grade is lost, sent twice, out of order or late, when a refusal is not shown, and when a grade is
//! sent that nobody may have.

use std::time::Duration;

use acts::operations::upkeep;
use acts::scoring::regrading::{self, Regrader, Rubric};
use acts::training::{assignments, grade_delivery};
use model::auth::federation::{IdentityKind, IdentityOrigin};
use model::ids::{AssignmentId, IdentityId};
use model::training::assignment::AssignmentTask;
use model::{Role, SessionKey};
use serde_json::{Value, json};
use store::audit::Actor;
use store::auth::federation::identities::{self, IssuedSubject, NewIdentity};
use store::recordings::sessions;
use store::scoring::grades::{self, NewOverride};
use store::scoring::supervisions;
use store::training::assignments::NewAssignment;
use web_admin::worker;

use super::{ADA, ADMIN, CLIENT, HEAD, World};
use crate::auth::federation::texts;
use crate::support::Member;
use crate::support::client::csrf_in;
use crate::support::grade_book::{GradeBook, ScoreAnswer, TakenScore};
use crate::support::learning_platform::{ISSUER, LaunchMessage};
use crate::support::recordings::{Attempt, record};

const CLAIM: &str = "https://purl.imsglobal.org/spec/lti-ags/claim/endpoint";
const EXERCISE: &str = "feel-the-layers";
const TEACHER: &str = "teacher@example.org";
const ANSWERS: &str =
    "SELECT state || ' ' || coalesce(last_status, 0) || ' ' || coalesce(last_answer, '') FROM deliveries";

/// A world in which a trainee and a teacher use a link to an exercise.
struct Graded {
    world: World,
    ada: Member,
    teacher: Member,
    attempt: SessionKey,
}

impl Graded {
    /// With a scored attempt and an assignment. The platform knows the key of the service.
    async fn new(line_item: Option<&str>, supervised: bool) -> Self {
        let world = World::new().await;
        let app = &world.app;
        app.publish(world.school).await;
        let ada = app.member(world.school, Role::Trainee, ADA).await;
        let teacher = app.member(world.school, Role::Instructor, TEACHER).await;
        app.cohort(world.school, "Spring", &[&ada.person, &teacher.person]).await;
        let attempt = Attempt { started_at: app.state.clock.now().plus_s(3600).to_utc(), ..Attempt::default() };
        let key = SessionKey { school_id: world.school, id: attempt.session_id };
        let graded = Self { world, ada, teacher, attempt: key };
        graded.assign(supervised).await;
        graded.world.clock().advance(2 * 3600);
        let app = &graded.world.app;
        assert_eq!(app.with_token(&graded.ada.token).upload(&record(&attempt)).await.status, 201);
        worker::work_off_jobs(&app.state).await.unwrap();
        graded.know("ada", &graded.ada).await;
        graded.launch("ada", line_item).await;
        // The first request creates the key, which the platform does not know yet.
        graded.send().await;
        assert_eq!(
            texts(&graded.world.app, ANSWERS).await,
            ["waiting 0 no access token: HTTP status 401 invalid_client"]
        );
        graded.publish_keys().await;
        graded.world.clock().advance(60);
        graded
    }

    /// The platform reads the key set of the service; returns the number of keys.
    async fn publish_keys(&self) -> usize {
        let set = self.world.app.stranger().get("/.well-known/jwks.json").await.text();
        let set: Value = serde_json::from_str(&set).unwrap();
        let keys = set["keys"].as_array().unwrap().len();
        self.book().set_client_keys(set);
        keys
    }

    fn book(&self) -> &GradeBook {
        &self.world.platform.grades
    }

    /// Gives a person an identity of the platform.
    async fn know(&self, subject: &str, member: &Member) {
        let now = self.world.clock().now();
        let issuer = format!("{ISSUER} {CLIENT}");
        let of = IssuedSubject { school_id: self.world.school, kind: IdentityKind::Lti, issuer: &issuer, subject };
        let how = IdentityOrigin::ByAdministrator;
        let new =
            NewIdentity { id: IdentityId::made_at(now), person_id: member.person.id, of, how, made_by: None, at: now };
        assert!(self.world.app.write(async |tx| identities::add_identity(tx, new).await.unwrap()).await);
    }

    async fn launch(&self, subject: &str, line_item: Option<&str>) {
        self.launch_to(&format!("/exercises/{EXERCISE}"), subject, line_item).await;
    }

    async fn launch_to(&self, page: &str, subject: &str, line_item: Option<&str>) {
        let message = LaunchMessage::by(subject)
            .with(CLAIM, self.book().claim(line_item))
            .with_lti("custom", json!({ "stylet": page }));
        let (_, answer) = self.world.launch_anew(&message).await;
        assert_eq!(answer.status, 303, "{}", answer.text());
    }

    async fn assign(&self, supervised: bool) -> AssignmentId {
        let new = NewAssignment {
            since_only: false,
            task: AssignmentTask::Exercise(EXERCISE.to_owned()),
            cohort_id: None,
            person_id: Some(self.ada.person.id),
            supervised,
            attempt_limit: None,
            due: None,
            time_zone: "UTC".to_owned(),
        };
        let by = self.teacher.person.clone().into_current().unwrap();
        assignments::make(&self.world.app.state, &by, &new).await.unwrap()
    }

    /// Overrides the score, or restores the computed one.
    async fn set_score(&self, score: Option<f64>) {
        let (now, made_by) = (self.world.clock().now(), self.teacher.person.id);
        let new = NewOverride { grade: score.map(|score| (score, true)), reason: "seen", made_by };
        self.world.app.write(async |tx| grades::put_override(tx, self.attempt, &new, now).await.unwrap()).await;
    }

    /// Adds a score by the rubric of today, as a re-grading does.
    async fn regrade(&self, score: f64) {
        let state = &self.world.app.state;
        let session = sessions::find_session(state.db.reader(), self.world.school, self.attempt.id).await.unwrap();
        let (session, rubric) = (session.unwrap(), Rubric::of_today(state, self.world.school, EXERCISE).await);
        let mut again = rubric.unwrap().unwrap().judge(state, &session).await.unwrap();
        again.score = score;
        let by = Regrader { actor: Actor::Worker, reason: Some("another rubric") };
        regrading::apply(state, by, &session, &again).await.unwrap();
    }

    async fn send(&self) {
        grade_delivery::send_due_grades(&self.world.app.state).await.unwrap();
    }

    async fn states(&self) -> Vec<String> {
        texts(&self.world.app, "SELECT state FROM deliveries ORDER BY subject").await
    }
}

fn scores(taken: &[TakenScore]) -> Vec<Option<f64>> {
    taken.iter().map(|taken| taken.message["scoreGiven"].as_f64()).collect()
}

/// Asserts that timestamps rise strictly.
fn assert_rising(taken: &[TakenScore]) {
    let stamps: Vec<&str> = taken.iter().map(|taken| taken.message["timestamp"].as_str().unwrap()).collect();
    assert!(stamps.iter().all(|stamp| stamp.len() == "2026-11-30T18:00:00.000Z".len()), "{stamps:?}");
    assert!(stamps.windows(2).all(|pair| pair[0] < pair[1]), "{stamps:?}");
}

#[tokio::test]
async fn a_grade_is_sent_once_whatever_success_is_called() {
    let graded = Graded::new(Some("items/7?type=lti"), false).await;
    graded.send().await;
    graded.send().await;
    let [first] = &graded.book().taken()[..] else { panic!("one score: {:?}", graded.book().taken()) };
    assert_eq!(first.query, "type=lti");
    let message = &first.message;
    assert_eq!((&message["userId"], &message["scoreMaximum"]), (&json!("ada"), &json!(100)));
    assert_eq!(
        (&message["activityProgress"], &message["gradingProgress"]),
        (&json!("Completed"), &json!("FullyGraded"))
    );
    assert_eq!(message["comment"], format!("https://training.example.org/sessions/{}", graded.attempt.id));
    assert!(message["submission"]["submittedAt"].as_str() > message["submission"]["startedAt"].as_str(), "{message}");
    for (score, status) in [(51.0, 200), (52.1234567, 201), (53.0, 202), (54.0, 204)] {
        graded.book().answer_with(&[ScoreAnswer::Status(status)]);
        graded.set_score(Some(score)).await;
        graded.send().await;
        assert_eq!(texts(&graded.world.app, ANSWERS).await, [format!("sent {status} ")]);
    }
    let taken = graded.book().taken();
    assert_eq!(scores(&taken)[1..], [51.0, 52.123457, 53.0, 54.0].map(Some));
    assert_rising(&taken);
    graded.set_score(Some(54.0)).await;
    graded.launch("ada", Some("items/7?type=lti")).await;
    graded.send().await;
    assert_eq!((graded.book().asked(), graded.book().tokens_made()), (5, 1), "an equal grade is not sent");
}

#[tokio::test]
async fn the_last_of_several_grades_arrives_once() {
    use ScoreAnswer::{Stall, Status};
    let graded = Graded::new(Some("items/7"), false).await;
    graded.book().answer_with(&[Status(500), Status(401), Status(401), Stall, Status(429)]);
    for score in [61.0, 62.0, 63.0, 64.0] {
        graded.set_score(Some(score)).await;
        graded.send().await;
        assert_eq!((graded.states().await, graded.book().taken().len()), (vec!["waiting".to_owned()], 0));
    }
    graded.send().await;
    // The second 401 has ended the second token, too.
    assert_eq!(graded.book().asked(), 6, "a minute passes before the next try");
    graded.set_score(Some(65.0)).await;
    graded.send().await;
    graded.send().await;
    assert_eq!((scores(&graded.book().taken()), graded.states().await), (vec![Some(65.0)], vec!["sent".to_owned()]));
    assert_eq!((graded.book().asked(), graded.book().tokens_made()), (7, 3));
}

#[tokio::test]
async fn changed_grades_arrive_with_the_time_of_the_attempt() {
    let graded = Graded::new(Some("items/7"), false).await;
    graded.send().await;
    graded.set_score(Some(70.0)).await;
    graded.send().await;
    graded.world.clock().advance(30 * 86_400);
    graded.set_score(None).await;
    graded.send().await;
    let taken = graded.book().taken();
    assert_eq!((scores(&taken)[1], scores(&taken)[0]), (Some(70.0), scores(&taken)[2]));
    graded.regrade(12.5).await;
    graded.send().await;
    let taken = graded.book().taken();
    assert_eq!(scores(&taken)[3..], [Some(12.5)]);
    let submitted: Vec<&Value> = taken.iter().map(|taken| &taken.message["submission"]["submittedAt"]).collect();
    assert!(submitted.iter().all(|at| *at == submitted[0] && at.is_string()), "{submitted:?}");
    let by = graded.teacher.person.clone().into_current().unwrap();
    let id: AssignmentId =
        texts(&graded.world.app, "SELECT lower(hex(id)) FROM assignments").await.remove(0).parse().unwrap();
    graded.launch_to(&format!("/assignments/{id}"), "ada", Some("items/7")).await;
    graded.send().await;
    assert_eq!(graded.book().taken().len(), 4, "the same grade");
    assignments::withdraw(&graded.world.app.state, &by, id).await.unwrap();
    graded.send().await;
    graded.send().await;
    let taken = graded.book().taken();
    let [.., last] = &taken[..] else { panic!("none taken") };
    assert_eq!((taken.len(), &last.message["gradingProgress"]), (5, &json!("NotReady")));
    assert!(last.message.get("scoreGiven").is_none(), "{last:?}");
    assert_rising(&taken);
}

#[tokio::test]
async fn a_grade_waits_for_the_supervision_of_its_attempt() {
    let graded = Graded::new(Some("items/7"), true).await;
    graded.send().await;
    let [pending] = &graded.book().taken()[..] else { panic!("one message") };
    assert_eq!(pending.message["gradingProgress"], "PendingManual");
    assert!(pending.message.get("scoreGiven").is_none() && pending.message["submission"]["submittedAt"].is_string());
    let app = &graded.world.app;
    let session = sessions::find_session(app.state.db.reader(), graded.world.school, graded.attempt.id).await;
    let (session, now) = (session.unwrap().unwrap(), app.state.clock.now());
    let by = graded.teacher.person.id;
    app.write(async |tx| supervisions::confirm_supervision(tx, &session, by, now).await.unwrap()).await;
    graded.send().await;
    let [_, confirmed] = &graded.book().taken()[..] else { panic!("two messages") };
    assert_eq!(confirmed.message["gradingProgress"], "FullyGraded");
    assert!(confirmed.message["scoreGiven"].is_number());
}

#[tokio::test]
async fn a_missing_line_item_is_created_once() {
    let graded = Graded::new(None, false).await;
    graded.send().await;
    graded.set_score(Some(55.0)).await;
    graded.launch("ada", None).await;
    graded.send().await;
    let [item] = &graded.book().items()[..] else { panic!("one line item: {:?}", graded.book().items()) };
    assert_eq!((&item["resourceId"], &item["scoreMaximum"]), (&json!(format!("exercise:{EXERCISE}")), &json!(100)));
    assert_eq!(item["resourceLinkId"], "link-1");
    let taken = graded.book().taken();
    assert_eq!((taken.len(), taken[1].query.as_str(), scores(&taken)[1]), (2, "type=lti", Some(55.0)));
}

#[tokio::test]
async fn a_refused_grade_stops_and_the_teacher_hears() {
    let mut graded = Graded::new(Some("items/7"), false).await;
    for (status, score) in [(404, 61.0), (403, 62.0), (410, 63.0), (422, 64.0)] {
        graded.book().answer_with(&[ScoreAnswer::Status(status)]);
        graded.set_score(Some(score)).await;
        graded.send().await;
        assert_eq!(texts(&graded.world.app, ANSWERS).await, [format!("stopped {status} <p>Not this one</p>")]);
        graded.set_score(Some(score + 0.5)).await;
        graded.world.clock().advance(40 * 86_400);
        graded.send().await;
        graded.world.head = graded.world.app.signed_in(HEAD).await;
        let page = format!("{ADMIN}/{}/deliveries", graded.world.id);
        let shown = graded.world.head.get(&page).await.text();
        assert!(shown.contains("&#60;p&#62;Not this one") && shown.contains(&status.to_string()), "{shown}");
        assert!(!graded.world.head.get(&format!("{page}?state=waiting")).await.text().contains("/retry"));
        let retry =
            shown.split("action=\"").map(|part| part.split('"').next().unwrap()).find(|to| to.ends_with("/retry"));
        let again = graded.world.head.form(retry.unwrap(), &[("csrf", &csrf_in(&shown))]).await;
        assert_eq!((again.status.as_u16(), again.header("location")), (303, page.as_str()));
        graded.send().await;
        assert_eq!(scores(&graded.book().taken()).last(), Some(&Some(score + 0.5)));
    }
    let refused = "SELECT details FROM audit_log WHERE action = 'platform.grade_refused'";
    assert_eq!(texts(&graded.world.app, refused).await.len(), 4);
    let notices = texts(&graded.world.app, "SELECT kind FROM notices WHERE kind = 'delivery'").await;
    assert_eq!(notices.len(), 1, "one until it is read");
    let home = graded.world.app.signed_in(TEACHER).await.get("/").await.text();
    assert!(home.contains("has refused the grade of"), "{home}");
}

#[tokio::test]
async fn an_interrupted_grade_is_sent_again() {
    let graded = Graded::new(Some("items/7"), false).await;
    graded.book().answer_with(&[ScoreAnswer::TakeAndStall]);
    let cut = tokio::time::timeout(Duration::from_secs(3), graded.send()).await;
    assert!(cut.is_err() && graded.book().taken().len() == 1, "the service ends after the platform has the grade");
    graded.send().await;
    assert_eq!(graded.book().asked(), 1, "another service may still be sending it");
    graded.world.clock().advance(180);
    graded.send().await;
    let mut taken = graded.book().taken();
    assert_rising(&taken);
    for taken in &mut taken {
        taken.message["timestamp"] = Value::Null;
    }
    assert!(taken.len() == 2 && taken[0] == taken[1], "{taken:?}");
    assert_eq!(graded.states().await, ["sent"]);
}

#[tokio::test]
async fn a_waiting_grade_is_sent_with_a_renewed_key() {
    let graded = Graded::new(Some("items/7"), false).await;
    graded.book().answer_with(&[ScoreAnswer::Status(500)]);
    graded.send().await;
    graded.world.clock().advance(360 * 86_400);
    upkeep::forget_expired(&graded.world.app.state).await.unwrap();
    assert_eq!(graded.publish_keys().await, 2, "the next key is published before it signs");
    graded.world.clock().advance(40 * 86_400);
    upkeep::forget_expired(&graded.world.app.state).await.unwrap();
    assert_eq!(graded.publish_keys().await, 1, "the earlier key is retired");
    graded.send().await;
    assert_eq!((graded.states().await, graded.book().tokens_made()), (vec!["sent".to_owned()], 2));
}

#[tokio::test]
async fn nothing_is_sent_for_whom_nothing_may_be_sent() {
    let mut graded = Graded::new(Some("items/7"), false).await;
    let south = graded.world.app.school("South").await;
    graded.world.app.member(south, Role::Administrator, "south@example.org").await;
    let page = format!("{ADMIN}/{}/deliveries", graded.world.id);
    assert_eq!(graded.world.app.signed_in("south@example.org").await.get(&page).await.status, 404);
    // A trainee without an assignment practises freely.
    let bo = graded.world.app.member(graded.world.school, Role::Trainee, "bo@example.org").await;
    graded.know("bo", &bo).await;
    graded.launch("bo", Some("items/7")).await;
    assert_eq!(graded.world.act("disable").await.status, 303);
    graded.send().await;
    assert_eq!((graded.book().asked(), graded.states().await), (0, vec!["waiting".to_owned(); 2]));
    let waiting = graded.world.head.get(&format!("{page}?state=waiting")).await.text();
    assert!(waiting.contains("/retry") && !waiting.contains("1970"), "{waiting}");
    assert_eq!(graded.world.act("enable").await.status, 303);
    let person = format!("/people/{}", graded.ada.person.id);
    let csrf = csrf_in(&graded.world.head.get(&person).await.text());
    let erased = graded.world.head.form(&format!("{person}/erase"), &[("csrf", &csrf), ("confirm", ADA)]).await;
    assert_eq!(erased.status, 303, "{}", erased.text());
    graded.send().await;
    assert_eq!((graded.book().asked(), graded.states().await), (0, vec!["idle".to_owned()]));
}
