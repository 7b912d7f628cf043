//! People at risk through the front door. Fails when a rule of the school does not decide who is listed, when a teacher sees or writes to
//! somebody else's trainees, when a message does not reach those chosen, and when what was done is not kept and erased with the person.

use acts::privacy::erasing;
use acts::privacy::erasing::Eraser;
use acts::privacy::erasures::ErasureScope;
use model::ids::{PersonId, SchoolId, SessionId};
use model::{Moment, Role};
use platform::clock::Clock;
use platform::config::MailTo;
use store::audit::Actor;
use store::people::directory;
use time::Duration;
use web_admin::{outbox, worker};

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member};

/// 2026-03-01 00:00 UTC.
const NOW: Moment = Moment::from_micros(1_772_323_200_000_000);

struct World {
    app: App,
    school: SchoolId,
    ada: Member,
    ben: Member,
    cohort: String,
}

/// Ada and Ben in a cohort with a teacher; Ben has no email address. A colleague teaches another cohort.
async fn world() -> World {
    let app = App::with(Clock::fixed(NOW), |_| {}).await;
    let school = app.school("North").await;
    app.publish(school).await;
    let member = async |role, email: &str| app.member(school, role, email).await;
    let ada = member(Role::Trainee, "ada@example.org").await;
    let ben = member(Role::Trainee, "ben@no-address.invalid").await;
    let teacher = member(Role::Instructor, "teacher@example.org").await;
    let colleague = member(Role::Instructor, "colleague@example.org").await;
    member(Role::Administrator, "admin@example.org").await;
    app.cohort(school, "Spring", &[&ada.person, &ben.person, &teacher.person]).await;
    app.cohort(school, "Autumn", &[&colleague.person]).await;
    let cohorts = store::training::cohorts::list_cohorts(app.state.db.reader(), school).await.unwrap();
    let cohort = cohorts.iter().find(|cohort| cohort.name == "Spring").unwrap().id.to_string();
    World { app, school, ada, ben, cohort }
}

impl World {
    async fn browser(&self, name: &str) -> Client {
        self.app.signed_in(&format!("{name}@example.org")).await
    }

    /// Sets the rules by the administrator's form.
    async fn set(&self, changed: &[(&str, &str)]) -> Answer {
        let mut admin = self.browser("admin").await;
        let csrf = csrf_in(&admin.get("/admin/at-risk").await.text());
        let usual = [
            ("not_begun", "yes"),
            ("not_begun_number", "7"),
            ("not_begun_weight", "3"),
            ("failing", "yes"),
            ("failing_number", "3"),
            ("failing_weight", "2"),
            ("falling", "yes"),
            ("falling_number", "10"),
            ("falling_weight", "2"),
            ("inactive", "yes"),
            ("inactive_number", "2"),
            ("inactive_weight", "1"),
        ];
        let of =
            |(name, value)| (name, changed.iter().find(|(known, _)| *known == name).map_or(value, |(_, new)| *new));
        let fields: Vec<_> = usual.into_iter().map(of).chain([("csrf", csrf.as_str())]).collect();
        admin.form("/admin/at-risk", &fields).await
    }

    /// Attempts of Ada that an instructor calls failed.
    async fn fail(&self, times: i64) {
        let mut teacher = self.browser("teacher").await;
        for n in 0..times {
            let first = Attempt::default();
            let started_at = first.started_at + Duration::hours(n);
            let attempt = Attempt { session_id: SessionId::random(), started_at, ..first };
            assert_eq!(self.app.with_token(&self.ada.token).upload(&record(&attempt)).await.status, 201);
            worker::work_off_jobs(&self.app.state).await.unwrap();
            let path = format!("/sessions/{}/override", attempt.session_id);
            let csrf = csrf_in(&teacher.get("/cohorts").await.text());
            let fields = [("csrf", csrf.as_str()), ("score", "40"), ("result", "failed"), ("reason", "led")];
            assert_eq!(teacher.form(&path, &fields).await.status, 303);
        }
    }

    /// Assigns an exercise that is due in days.
    async fn assign(&self) {
        let mut teacher = self.browser("teacher").await;
        let csrf = csrf_in(&teacher.get("/assignments").await.text());
        let due = "2026-03-05T12:00";
        let fields =
            [("csrf", csrf.as_str()), ("task", "exercise:feel-the-layers"), ("cohort", &self.cohort), ("due", due)];
        assert_eq!(teacher.form("/assignments", &fields).await.status, 303);
    }

    async fn write(&self, by: &str, people: &[PersonId], fields: &[(&str, &str)]) -> Answer {
        let mut browser = self.browser(by).await;
        let csrf = csrf_in(&browser.get("/at-risk").await.text());
        let ids: Vec<String> = people.iter().map(PersonId::to_string).collect();
        let chosen = ids.iter().map(|id| ("person", id.as_str()));
        let fields: Vec<_> = chosen.chain(fields.iter().copied()).chain([("csrf", csrf.as_str())]).collect();
        browser.form("/at-risk", &fields).await
    }

    async fn count(&self, table: &str) -> i64 {
        let count = sqlx::AssertSqlSafe(format!("SELECT count(*) FROM {table}"));
        sqlx::query_scalar(count).fetch_one(self.app.state.db.reader()).await.unwrap()
    }

    async fn letters(&self) -> Vec<String> {
        outbox::work_off_letters(&self.app.state).await.unwrap();
        let MailTo::Folder(folder) = &self.app.state.config.mail else { panic!("mail goes to a folder") };
        let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
        entries.map(|entry| std::fs::read_to_string(entry.unwrap().path()).unwrap()).collect()
    }
}

#[tokio::test]
async fn the_rules_of_the_school_decide_who_is_at_risk() {
    let world = world().await;
    world.fail(2).await;
    let list = async |name: &str| world.browser(name).await.get("/at-risk").await.text();
    // The attempts were made long before now, and the course is not passed.
    let long_ago = "no attempt for ";
    assert!(list("teacher").await.contains("Nobody right now"), "two failures are fewer than three");
    assert_eq!(world.set(&[("failing_number", "2")]).await.status, 303);
    let listed = list("teacher").await;
    assert!(listed.contains("2 failed attempts in a row at “") && listed.contains("40 points"), "{listed}");
    assert!(!listed.contains(long_ago), "{listed}");
    assert!(list("admin").await.contains("2 failed attempts in a row"), "an administrator sees the school");
    assert!(list("colleague").await.contains("Nobody right now"), "others' trainees are not listed");
    for page in [format!("/cohorts/{}", world.cohort), format!("/trainees/{}", world.ada.person.id), "/".to_owned()] {
        let page = world.browser("teacher").await.get(&page).await.text();
        assert!(page.contains("2 failed attempts in a row"), "one notion on every page: {page}");
    }
    let own = world.browser("ada").await.get("/").await.text();
    assert!(!own.contains("failed attempts in a row"), "{own}");
    assert_eq!(world.set(&[("failing_number", "2"), ("failing", "no")]).await.status, 303);
    assert!(list("admin").await.contains("Nobody right now"), "the rule is off");
}

#[tokio::test]
async fn a_pass_and_an_extension_take_a_person_off_the_list() {
    let world = world().await;
    world.assign().await;
    let mut teacher = world.browser("teacher").await;
    let listed = teacher.get("/at-risk").await.text();
    assert_eq!(listed.matches("no attempt at “Feel the layers”, due 5 Mar 2026").count(), 2, "{listed}");
    let assignment = listed_assignment(&mut teacher).await;
    let (csrf, ada) = (csrf_in(&listed), world.ada.person.id.to_string());
    let fields = [("csrf", csrf.as_str()), ("person", &ada), ("days", "30")];
    assert_eq!(teacher.form(&format!("{assignment}/extend"), &fields).await.status, 303);
    let listed = teacher.get("/at-risk").await.text();
    assert_eq!(listed.matches("no attempt at").count(), 1, "{listed}");
    world.app.state.clock.advance(200 * 86_400);
    let mut teacher = world.browser("teacher").await;
    assert!(teacher.get("/at-risk").await.text().contains("Nobody right now"), "months later it is history");
}

/// The address of the only assignment.
async fn listed_assignment(teacher: &mut Client) -> String {
    let page = teacher.get("/assignments").await.text();
    let (_, rest) = page.split_once("href=\"/assignments/").expect("a link to the assignment");
    format!("/assignments/{}", &rest[..36])
}

#[tokio::test]
async fn a_message_reaches_the_people_chosen_and_is_kept() {
    let world = world().await;
    world.assign().await;
    let people = [world.ada.person.id, world.ben.person.id];
    let text = [("kind", "message"), ("subject", "Practice"), ("body", "Station 2 is free.\r\nCome by.")];
    let answer = world.write("teacher", &people, &text).await;
    assert_eq!(answer.status, 303, "{}", answer.text());
    let mut teacher = world.browser("teacher").await;
    let page = teacher.get(answer.header("location")).await.text();
    assert!(page.contains("mailed to 1 person") && page.contains("1 person has no email address"), "{page}");
    assert!(page.contains("not mailed: no email address: Practice"), "{page}");
    let letters = world.letters().await;
    assert_eq!(letters.len(), 1, "{letters:?}");
    assert!(
        letters[0].contains("Subject: Practice") && letters[0].contains("Station 2 is free.\r\nCome by."),
        "{letters:?}"
    );
    let mailed = world.count("notices WHERE kind = 'message' AND mailed_at IS NOT NULL").await;
    assert_eq!(mailed, 1, "no mail of news follows a mailed message");
    let mut ada = world.browser("ada").await;
    let home = ada.get("/").await.text();
    assert!(home.contains("has written to you: “Practice”") && home.contains("Station 2 is free."), "{home}");
    assert_eq!(
        world.write("teacher", &people[..1], &[("kind", "note"), ("body", "Prefers mornings")]).await.status,
        303
    );
    let page = teacher.get(&format!("/trainees/{}", world.ada.person.id)).await.text();
    assert!(page.contains("Prefers mornings") && page.contains("Station 2 is free."), "{page}");
    assert!(!ada.get("/").await.text().contains("Prefers mornings"), "a note is for teachers");
    let held = ada.get("/account/export").await.json();
    assert_eq!(held["support_notes"].as_array().map(Vec::len), Some(2), "{held}");
    let log: i64 = world.count("audit_log WHERE action = 'support.recorded'").await;
    assert_eq!(log, 3);
    let reader = world.app.state.db.reader();
    let entry = directory::find_anybody(reader, world.school, world.ada.person.id).await.unwrap().unwrap();
    let by = Eraser { actor: Actor::CommandLine, why: None };
    erasing::erase(&world.app.state, by, &entry, world.school, ErasureScope::default()).await.unwrap();
    assert_eq!(world.count("support_notes").await, 1, "Ben's is left");
}

#[tokio::test]
async fn nonsense_and_other_peoples_trainees_are_refused() {
    let world = world().await;
    world.assign().await;
    let ada = [world.ada.person.id];
    for fields in [
        [("kind", "message"), ("subject", ""), ("body", "x")],
        [("kind", "message"), ("subject", "a\r\nBcc: b"), ("body", "x")],
        [("kind", "note"), ("subject", ""), ("body", "")],
        [("kind", "shout"), ("subject", ""), ("body", "x")],
    ] {
        let answer = world.write("teacher", &ada, &fields).await;
        assert_eq!(answer.status, 422, "{fields:?}");
        assert!(answer.text().contains("checked"), "the choice stays");
    }
    assert_eq!(world.write("teacher", &[], &[("kind", "spoken")]).await.status, 422, "nobody is chosen");
    assert_eq!(world.write("colleague", &ada, &[("kind", "spoken")]).await.status, 404);
    let both = [world.ada.person.id, PersonId::from_u128(7)];
    assert_eq!(world.write("teacher", &both, &[("kind", "spoken")]).await.status, 404, "all or none");
    assert_eq!(world.count("support_notes").await, 0);
    let mut colleague = world.browser("colleague").await;
    for part in [format!("cohort={}", world.cohort), format!("trainee={}", ada[0]), "cohort=x".to_owned()] {
        assert_eq!(colleague.get(&format!("/at-risk?{part}")).await.status, 404, "{part}");
    }
    for (name, value) in
        [("failing_number", "1"), ("inactive_number", "12"), ("falling_weight", "0"), ("not_begun_number", "x")]
    {
        let answer = world.set(&[(name, value)]).await;
        assert_eq!(answer.status, 422, "{name}={value}");
        assert!(answer.text().contains(&format!("“{value}” is not allowed")), "{}", answer.text());
    }
    assert_eq!(world.count("risk_rules").await, 0);
}
