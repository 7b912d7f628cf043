//! Assignments through the front door. Fails when a trainee does not see what is due, when the clocks move a deadline,
//! when another school's cohort can be told from none, or when somebody is reminded twice or for nothing.

use acts::training::deadlines;
use model::ids::{CohortId, PersonId, SchoolId, SessionId};
use model::{Moment, Role};
use platform::clock::Clock;
use platform::config::MailTo;
use store::training::cohorts;
use time::macros::datetime;
use uuid::Uuid;
use web_admin::{outbox, worker};

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member};

/// 2026-03-01 00:00 UTC; the attempts of these tests begin on 4 March.
const NOW: Moment = Moment::from_micros(1_772_323_200_000_000);

pub(super) struct World {
    pub app: App,
    pub school: SchoolId,
    cohort: CohortId,
    pub ada: Member,
    teacher: Client,
}

impl World {
    pub async fn new() -> Self {
        let app = App::with(Clock::fixed(NOW), |_| {}).await;
        let school = app.school("North").await;
        app.keep_time_zone(school, "Europe/Berlin").await;
        let ada = app.member(school, Role::Trainee, "ada@example.org").await;
        let teacher = app.member(school, Role::Instructor, "teacher@example.org").await;
        app.cohort(school, "A", &[&ada.person, &teacher.person]).await;
        app.publish(school).await;
        let teacher = app.signed_in("teacher@example.org").await;
        let cohort = cohorts::list_cohorts(app.state.db.reader(), school).await.unwrap()[0].id;
        Self { app, school, cohort, ada, teacher }
    }

    /// Lets days pass, after which whoever teaches signs in again.
    async fn pass_days(&mut self, days: i64) {
        self.app.state.clock.advance(days * 86_400);
        self.teacher = self.app.signed_in("teacher@example.org").await;
    }

    pub async fn post(&mut self, path: &str, fields: &[(&str, &str)]) -> Answer {
        let csrf = csrf_in(&self.teacher.get("/assignments").await.text());
        self.teacher.form(path, &[&[("csrf", csrf.as_str())], fields].concat()).await
    }

    /// Assigns the first exercise to the cohort; the page of the assignment.
    pub async fn assign(&mut self, due: &str, limit: &str) -> String {
        let cohort = self.cohort.to_string();
        let fields =
            [("task", "exercise:feel-the-layers"), ("cohort", cohort.as_str()), ("due", due), ("limit", limit)];
        let made = self.post("/assignments", &fields).await;
        assert_eq!(made.status, 303, "{}", made.text());
        made.header("location").to_owned()
    }

    async fn adas_page(&self) -> String {
        self.app.signed_in("ada@example.org").await.get("/assignments").await.text()
    }

    async fn mails(&self) -> Vec<String> {
        deadlines::remind(&self.app.state).await.unwrap();
        outbox::work_off_letters(&self.app.state).await.unwrap();
        let MailTo::Folder(folder) = &self.app.state.config.mail else { panic!("mail goes to a folder") };
        let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
        entries.map(|entry| std::fs::read_to_string(entry.unwrap().path()).unwrap()).collect()
    }
}

#[tokio::test]
async fn what_is_assigned_comes_first_on_the_schools_clock() {
    let mut world = World::new().await;
    let page = world.assign("2026-03-27T18:00", "3").await;
    let own = world.adas_page().await;
    assert!(
        own.contains("27 Mar 2026, 18:00") && own.contains("UTC+01:00") && own.contains("3 attempts left"),
        "{own}"
    );
    let mut api = world.app.with_token(&world.ada.token);
    let due = api.get("/api/v1/me/assignments").await.json();
    let first = &due["assignments"][0];
    assert_eq!(first["exercise_id"], "feel-the-layers");
    assert_eq!(first["assigned"]["due_at"], "2026-03-27T18:00:00+01:00");
    assert_eq!((&first["assigned"]["attempts_left"], &first["assigned"]["overdue"]), (&3.into(), &false.into()));
    let listed = api.get("/api/v1/exercises").await.json();
    assert_eq!((&listed["exercises"][0]["assigned"], &listed["exercises"][0]["due"]), (&true.into(), &true.into()));
    assert!(world.teacher.get(&page).await.text().contains("<strong>0</strong> of 1"));
}

#[tokio::test]
async fn an_extension_is_calendar_days_and_for_one_trainee() {
    let mut world = World::new().await;
    let page = world.assign("2026-03-27T18:00", "").await;
    let ada = world.ada.person.id.to_string();
    let extended = world.post(&format!("{page}/extend"), &[("person", &ada), ("days", "7")]).await;
    assert_eq!(extended.status, 303, "{}", extended.text());
    let own = world.adas_page().await;
    assert!(own.contains("3 Apr 2026, 18:00") && own.contains("UTC+02:00") && own.contains("7 more days"), "{own}");
    for (person, days, status) in [(ada.as_str(), "999", 422), (&PersonId::random().to_string(), "7", 404)] {
        let refused = world.post(&format!("{page}/extend"), &[("person", person), ("days", days)]).await;
        assert_eq!(refused.status, status);
    }
    world.post(&format!("{page}/extend"), &[("person", &ada), ("days", "0")]).await;
    assert!(world.adas_page().await.contains("27 Mar 2026, 18:00"), "as long as everybody");
}

#[tokio::test]
async fn what_cannot_be_assigned_is_refused_and_what_was_typed_stays() {
    let mut world = World::new().await;
    let cohort = world.cohort.to_string();
    let south = world.app.school("South").await;
    world.app.cohort(south, "S", &[]).await;
    let abroad = cohorts::list_cohorts(world.app.state.db.reader(), south).await.unwrap()[0].id.to_string();
    let nobody = Uuid::new_v4().to_string();
    let task = "exercise:feel-the-layers";
    for (task, cohort, due, status, words) in [
        (task, cohort.as_str(), "2026-03-29T02:30", 422, "01:59 and 03:00"),
        (task, &cohort, "2026-02-01T12:00", 422, "in the past"),
        (task, &cohort, "soon", 422, "“soon”"),
        (task, "", "", 422, "Choose a cohort"),
        (task, &abroad, "", 404, "Not found"),
        (task, &nobody, "", 404, "Not found"),
        ("exercise:none", &cohort, "", 404, "Not found"),
    ] {
        let refused = world.post("/assignments", &[("task", task), ("cohort", cohort), ("due", due)]).await;
        assert_eq!(refused.status, status, "{due} {}", refused.text());
        assert!(refused.text().contains(words), "{words}: {}", refused.text());
        assert!(status == 404 || refused.text().contains(&format!("name=\"due\" value=\"{due}\"")));
    }
    assert!(world.adas_page().await.contains("You have no assignments"));
}

#[tokio::test]
async fn a_pass_does_it_and_a_limit_ends_it() {
    let mut world = World::new().await;
    let page = world.assign("2026-03-03T12:00", "1").await;
    world.pass_days(4).await;
    let backdated = Attempt { started_at: datetime!(2026-03-02 9:00 UTC), ..Attempt::default() };
    // Backdated into the time before the due date: what was late stays late.
    assert_eq!(world.app.with_token(&world.ada.token).upload(&record(&backdated)).await.status, 201);
    worker::work_off_jobs(&world.app.state).await.unwrap();
    let own = world.adas_page().await;
    assert!(!own.contains(">Done<"), "{own}");
    assert!(own.contains("Done late") || own.contains("No attempts left"), "the one attempt counts: {own}");
    world.post(&format!("{page}/withdraw"), &[]).await;
    assert!(world.adas_page().await.contains("You have no assignments"));
    assert_eq!(world.teacher.get(&page).await.status, 404);
}

#[tokio::test]
async fn a_locked_exercise_is_assigned_and_waits_for_its_prerequisite() {
    let mut world = World::new().await;
    let fields = [("task", "exercise:stop-in-the-fat"), ("email", "ada@example.org")];
    let warned = world.post("/assignments", &fields).await;
    assert_eq!(warned.status, 422);
    let words = "locked for 1 trainee of 1, who must first master Feel the layers";
    assert!(warned.text().contains(words) && warned.text().contains("Assign anyway"), "{}", warned.text());
    assert!(world.adas_page().await.contains("You have no assignments"));
    let knowingly = [fields[0], fields[1], ("despite_locks", "yes")];
    assert_eq!(world.post("/assignments", &knowingly).await.status, 303);
    assert!(world.adas_page().await.contains("Locked"));
    let due = world.app.with_token(&world.ada.token).get("/api/v1/me/assignments").await.json();
    assert!(due["assignments"].as_array().unwrap().iter().all(|a| a["exercise_id"] != "stop-in-the-fat"), "{due}");
}

#[tokio::test]
async fn the_same_is_not_assigned_twice_until_it_is_over() {
    let mut world = World::new().await;
    let first = world.assign("2026-03-03T12:00", "").await;
    let cohort = world.cohort.to_string();
    let fields = [("task", "exercise:feel-the-layers"), ("cohort", cohort.as_str())];
    let again = world.post("/assignments", &fields).await;
    assert!(again.status == 422 && again.text().contains("already assigned to them"), "{}", again.text());
    world.pass_days(4).await;
    assert_ne!(world.post("/assignments", &fields).await.header("location"), first, "the next term's");
}

#[tokio::test]
async fn earlier_pass_counts_unless_the_assignment_requires_another() {
    let mut world = World::new().await;
    let began = datetime!(2026-03-01 9:00 UTC);
    let passed = Attempt { session_id: SessionId::random(), started_at: began, ..Attempt::default() };
    world.pass_days(1).await;
    assert_eq!(world.app.with_token(&world.ada.token).upload(&record(&passed)).await.status, 201);
    worker::work_off_jobs(&world.app.state).await.unwrap();
    let id = passed.session_id.to_string();
    let grade = [("score", "90"), ("result", "passed"), ("reason", "seen")];
    assert_eq!(world.post(&format!("/sessions/{id}/override"), &grade).await.status, 303);
    let page = world.assign("2026-03-05T12:00", "").await;
    world.pass_days(9).await;
    assert!(world.adas_page().await.contains("Done earlier"), "{}", world.adas_page().await);
    let home = world.teacher.get("/").await.text();
    assert!(!home.contains("Due soon or overdue"), "nobody is late who has passed: {home}");
    world.post(&format!("{page}/withdraw"), &[]).await;
    let cohort = world.cohort.to_string();
    let again = [
        ("task", "exercise:feel-the-layers"),
        ("cohort", cohort.as_str()),
        ("due", "2026-03-14T12:00"),
        ("since_only", "yes"),
    ];
    let page = world.post("/assignments", &again).await.header("location").to_owned();
    let own = world.adas_page().await;
    assert!(own.contains("To do") && own.contains("only attempts after the assignment count"), "{own}");
    let home = world.teacher.get("/").await.text();
    assert!(home.contains("Due soon or overdue") && home.contains("0 of 1") && home.contains(&page), "{home}");
    world.pass_days(9).await;
    let overview = world.teacher.get(&format!("/cohorts/{cohort}")).await.text();
    assert!(overview.contains(&page) && overview.contains("/gradebook"), "{overview}");
    let trainee = world.teacher.get(&format!("/trainees/{}", world.ada.person.id)).await.text();
    assert!(trainee.contains("Open assignments") && trainee.contains("Late"), "{trainee}");
}

#[tokio::test]
async fn the_gradebook_and_its_file_say_the_same() {
    let mut world = World::new().await;
    world.assign("2026-03-05T12:00", "").await;
    world.pass_days(4).await;
    let attempt = Attempt { session_id: SessionId::random(), ..Attempt::default() };
    assert_eq!(world.app.with_token(&world.ada.token).upload(&record(&attempt)).await.status, 201);
    worker::work_off_jobs(&world.app.state).await.unwrap();
    let id = attempt.session_id.to_string();
    let grade = [("score", "71.2"), ("result", "passed"), ("reason", "seen")];
    assert_eq!(world.post(&format!("/sessions/{id}/override"), &grade).await.status, 303);
    let path = format!("/cohorts/{}/gradebook", world.cohort);
    let page = world.teacher.get(&path).await.text();
    assert!(
        page.contains("<strong>71</strong>") && page.contains("1 attempt") && page.contains("1 of 1 done"),
        "{page}"
    );
    let csv = world.teacher.get(&format!("{path}.csv")).await.text();
    let mut lines = csv.lines();
    assert_eq!(
        lines.next(),
        Some(
            "Registrar’s number,Name,Feel the layers: state,Feel the layers: best score,Feel the layers: attempts,\
             Feel the layers: done on"
        )
    );
    let row = lines.next().expect("a trainee");
    assert!(row.contains(",Done,71,1,4 Mar 2026") && lines.next().is_none(), "{row}");
    let marked = world.teacher.get(&format!("{path}.csv?bom=1")).await.text();
    assert_eq!(marked.strip_prefix('\u{feff}'), Some(csv.as_str()));
    let comma = world.teacher.get(&format!("{path}.csv?bom=1&comma=1")).await.text();
    assert!(comma.contains(";Done;71;1;4 Mar 2026"), "{comma}");
}

#[tokio::test]
async fn everybody_is_reminded_once_of_what_is_still_to_be_done() {
    let mut world = World::new().await;
    world.assign("2026-03-10T18:00", "").await;
    assert_eq!(world.mails().await.len(), 0, "not nine days before");
    world.app.state.clock.advance(8 * 86_400);
    let mails = world.mails().await;
    assert!(mails.len() == 1 && mails[0].contains("Due 10 Mar 2026, 18:00"), "{mails:?}");
    world.app.state.clock.advance(3600);
    assert_eq!(world.mails().await.len(), 1, "once");
    let bo = world.app.member(world.school, Role::Trainee, "bo@example.org").await;
    world.app.cohort(world.school, "A", &[&bo.person]).await;
    assert_eq!(world.mails().await.len(), 2, "and whoever came later");
}

#[tokio::test]
async fn reminders_of_a_day_are_in_one_letter() {
    let mut world = World::new().await;
    world.assign("2026-03-10T18:00", "").await;
    let cohort = world.cohort.to_string();
    for (exercise, due) in [("stop-in-the-fat", "2026-03-10T20:00"), ("reach-the-muscle", "2026-03-11T12:00")] {
        let task = format!("exercise:{exercise}");
        let fields = [("task", task.as_str()), ("cohort", &cohort), ("due", due), ("despite_locks", "yes")];
        let made = world.post("/assignments", &fields).await;
        assert_eq!(made.status, 303, "{}", made.text());
    }
    world.app.state.clock.advance(7 * 86_400 + 20 * 3600);
    let both = world.mails().await;
    assert!(both.len() == 1 && both[0].contains("2 things to do"), "{both:?}");
    world.app.state.clock.advance(20 * 3600);
    assert_eq!(world.mails().await.len(), 1, "the third waits for a day to pass");
    world.app.state.clock.advance(4 * 3600);
    let all = world.mails().await;
    assert!(all.len() == 2 && all.iter().any(|mail| mail.contains("Due 11 Mar 2026, 12:00")), "{all:?}");
}

#[tokio::test]
async fn a_supervised_attempt_counts_once_somebody_was_there() {
    let mut world = World::new().await;
    let cohort = world.cohort.to_string();
    let fields =
        [("task", "exercise:feel-the-layers"), ("cohort", cohort.as_str()), ("limit", "1"), ("supervised", "yes")];
    let page = world.post("/assignments", &fields).await.header("location").to_owned();
    world.pass_days(4).await;
    let attempt = Attempt { session_id: SessionId::random(), ..Attempt::default() };
    assert_eq!(world.app.with_token(&world.ada.token).upload(&record(&attempt)).await.status, 201);
    worker::work_off_jobs(&world.app.state).await.unwrap();
    let before = world.adas_page().await;
    assert!(
        before.contains("1 attempt is waiting for your instructor") && before.contains("1 attempt left"),
        "{before}"
    );
    let path = format!("/sessions/{}/supervision", attempt.session_id);
    assert!(world.teacher.get(&page).await.text().contains(&path));
    let assignment = page.rsplit('/').next().unwrap().to_owned();
    let mut ada = world.app.signed_in("ada@example.org").await;
    let csrf = csrf_in(&ada.get("/").await.text());
    assert_eq!(ada.form(&path, &[("csrf", &csrf), ("confirm", "yes")]).await.status, 403, "not by herself");
    assert_eq!(world.post(&path, &[("confirm", "maybe")]).await.status, 400);
    let confirmed = world.post(&path, &[("confirm", "yes"), ("assignment", &assignment)]).await;
    assert_eq!(confirmed.header("location"), page);
    assert!(!world.adas_page().await.contains("waiting for your instructor"));
    assert!(!world.adas_page().await.contains("1 attempt left"), "it is used");
    let grade = format!("/sessions/{}/grade", attempt.session_id);
    assert!(ada.get(&grade).await.text().contains(", confirmed "));
    assert_eq!(world.post(&path, &[("confirm", "no")]).await.status, 303);
    assert!(world.adas_page().await.contains("waiting for your instructor"));
}
