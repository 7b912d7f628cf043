//! Who belongs to a cohort. Fails when somebody who teaches reaches the attempts of a trainee who has agreed to nothing,
//! when somebody says yes who must not, or when the trainee does not see who asked, who agreed and who let them go.

use model::Role;
use model::ids::{CohortId, SchoolId, SessionId};
use store::training::cohorts;
use web_admin::worker;

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member};

struct World {
    app: App,
    school: SchoolId,
    ada: Member,
    attempt: SessionId,
    /// Teaches a cohort of their own making, and not Ada.
    eve: Client,
    cohort: CohortId,
}

async fn press(browser: &mut Client, path: &str, fields: &[(&str, &str)]) -> Answer {
    let csrf = csrf_in(&browser.get("/account").await.text());
    browser.form(path, &[&[("csrf", csrf.as_str())], fields].concat()).await
}

impl World {
    async fn new() -> Self {
        let app = App::new().await;
        let school = app.school("North").await;
        app.publish(school).await;
        let ada = app.member(school, Role::Trainee, "ada@example.org").await;
        app.member(school, Role::Instructor, "eve@example.org").await;
        app.member(school, Role::Administrator, "head@example.org").await;
        let attempt = Attempt::default();
        assert_eq!(app.with_token(&ada.token).upload(&record(&attempt)).await.status, 201);
        worker::work_off_jobs(&app.state).await.unwrap();
        let mut eve = app.signed_in("eve@example.org").await;
        let made = press(&mut eve, "/cohorts", &[("name", "Mine")]).await;
        let cohort = made.header("location").split('/').nth(2).unwrap().parse().unwrap();
        Self { app, school, ada, attempt: attempt.session_id, eve, cohort }
    }

    async fn ask(&mut self, email: &str) {
        let asked = press(&mut self.eve, &format!("/cohorts/{}/people", self.cohort), &[("email", email)]).await;
        assert_eq!(asked.status, 303, "{}", asked.text());
    }

    /// What Eve is answered when she wants to see Ada, her attempt, its recording, and to grade it.
    async fn reach(&mut self) -> [u16; 4] {
        let (ada, attempt) = (self.ada.person.id, self.attempt);
        let mut answers = Vec::new();
        for path in [
            format!("/trainees/{ada}"),
            format!("/sessions/{attempt}"),
            format!("/api/v1/sessions/{attempt}/recording"),
            format!("/sessions/{attempt}/grade"),
        ] {
            answers.push(self.eve.get(&path).await.status.as_u16());
        }
        answers.try_into().unwrap()
    }

    fn answer_of_ada(&self) -> String {
        format!("/account/cohorts/{}", self.cohort)
    }

    async fn log(&self) -> Vec<String> {
        let log = sqlx::query_scalar(
            "SELECT action FROM audit_log WHERE action LIKE 'cohort.%' AND object = $1 ORDER BY seq",
        )
        .bind(self.ada.person.id.to_string());
        log.fetch_all(self.app.state.db.reader()).await.unwrap()
    }
}

#[tokio::test]
async fn nobody_reaches_a_trainee_by_typing_an_address() {
    let mut world = World::new().await;
    world.ask("ada@example.org").await;
    assert_eq!(world.reach().await, [404; 4], "asked for is not agreed");
    let page = world.eve.get(&format!("/cohorts/{}/people", world.cohort)).await.text();
    assert!(page.contains("Requests") && !page.contains(&format!("/trainees/{}", world.ada.person.id)), "{page}");
    let yes = format!("/cohorts/{}/people/{}/answer", world.cohort, world.ada.person.id);
    assert_eq!(press(&mut world.eve, &yes, &[("answer", "yes")]).await.status, 403, "not by whoever asks");
    let mut ada = world.app.signed_in("ada@example.org").await;
    assert!(ada.get("/").await.text().contains("asks for a place in the cohort Mine for you"));
    assert_eq!(press(&mut ada, &world.answer_of_ada(), &[("answer", "perhaps")]).await.status, 400);
    assert_eq!(press(&mut ada, &world.answer_of_ada(), &[("answer", "no")]).await.status, 303);
    assert_eq!(world.reach().await, [404; 4]);
    assert_eq!(press(&mut ada, &world.answer_of_ada(), &[("answer", "yes")]).await.status, 404, "it is answered");
    assert_eq!(world.log().await, ["cohort.asked", "cohort.declined"]);
}

#[tokio::test]
async fn who_has_agreed_is_seen_and_sees_what_was_done() {
    let mut world = World::new().await;
    world.ask("ada@example.org").await;
    world.ask("ada@example.org").await;
    let mut ada = world.app.signed_in("ada@example.org").await;
    assert_eq!(press(&mut ada, &world.answer_of_ada(), &[("answer", "yes")]).await.status, 303);
    assert_eq!(world.reach().await, [200; 4]);
    let remove = format!("/cohorts/{}/people/{}/remove", world.cohort, world.ada.person.id);
    assert_eq!(press(&mut world.eve, &remove, &[]).await.status, 303);
    assert_eq!(world.reach().await, [404; 4]);
    let page = ada.get("/account").await.text();
    for told in
        ["has asked for a place in Mine for you", "has agreed to your place in Mine", "has removed you from Mine"]
    {
        assert!(page.contains(told), "{told}: {page}");
    }
    assert_eq!(world.log().await, ["cohort.asked", "cohort.joined", "cohort.left"], "asked for once");
    let reader = world.app.state.db.reader();
    assert_eq!(cohorts::list_membership_acts(reader, world.school, world.ada.person.id).await.unwrap().len(), 3);
}

#[tokio::test]
async fn an_administrator_decides_and_alone_decides_who_teaches() {
    let mut world = World::new().await;
    let ben = world.app.member(world.school, Role::Instructor, "ben@example.org").await;
    let mut head = world.app.signed_in("head@example.org").await;
    world.ask("ada@example.org").await;
    world.ask("ben@example.org").await;
    assert!(head.get("/admin").await.text().contains("Requests to join cohorts"));
    let mut as_ben = world.app.signed_in("ben@example.org").await;
    assert_eq!(press(&mut as_ben, &world.answer_of_ada(), &[("answer", "yes")]).await.status, 403, "not by himself");
    for asked in [world.ada.person.id, ben.person.id] {
        let answer = format!("/cohorts/{}/people/{asked}/answer", world.cohort);
        assert_eq!(press(&mut head, &answer, &[("answer", "yes")]).await.status, 303);
    }
    assert_eq!(world.reach().await, [200; 4]);
    assert_eq!(as_ben.get(&format!("/sessions/{}", world.attempt)).await.status, 200);
    let direct = format!("/cohorts/{}/people", world.cohort);
    let cleo = world.app.member(world.school, Role::Trainee, "cleo@example.org").await;
    assert_eq!(press(&mut head, &direct, &[("email", "cleo@example.org")]).await.status, 303);
    assert_eq!(world.eve.get(&format!("/trainees/{}", cleo.person.id)).await.status, 200, "an administrator adds");
}
