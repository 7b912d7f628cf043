//! Marking pops, through the front door. Fails when a trainee can learn the pops before sending marks, from the page or
//! from any route; when they are given an attempt of their own; when sent marks change; and when results are wrong.

use acts::training::deadlines;
use model::ids::{CohortId, PersonId, SchoolId, SessionId};
use model::scoring::segments::pops;
use model::{Moment, Role, SessionKey};
use platform::clock::Clock;
use platform::config::MailTo;
use store::scoring::scores;
use web_admin::{outbox, worker};

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member};

const NAME: &str = "Ben Quillfeather";
/// 2026-03-05 00:00 UTC; the attempts of these tests begin on 4 March.
const NOW: Moment = Moment::from_micros(1_772_668_800_000_000);
const DAY_S: i64 = 86_400;

struct School {
    app: App,
    id: SchoolId,
    /// An attempt of Ben's and one of Ada's.
    attempts: [SessionId; 2],
    ada: PersonId,
}

async fn upload(app: &App, member: &Member) -> SessionId {
    let attempt = Attempt { session_id: SessionId::random(), ..Attempt::default() };
    assert_eq!(app.with_token(&member.token).upload(&record(&attempt)).await.status, 201);
    attempt.session_id
}

impl School {
    async fn new() -> Self {
        let app = App::with(Clock::fixed(NOW), |_| {}).await;
        let north = app.school("North").await;
        app.keep_time_zone(north, "Europe/Berlin").await;
        app.publish(north).await;
        let ada = app.member(north, Role::Trainee, "ada@example.org").await;
        let ben = app.member(north, Role::Trainee, "ben@example.org").await;
        let teacher = app.member(north, Role::Instructor, "teacher@example.org").await;
        app.member(north, Role::Instructor, "other@example.org").await;
        app.cohort(north, "Spring", &[&ada.person, &ben.person, &teacher.person]).await;
        let named = sqlx::query("UPDATE people SET display_name = $1 WHERE id = $2").bind(NAME).bind(ben.person.id);
        app.write(async |tx| named.execute(tx).await.unwrap()).await;
        let attempts = [upload(&app, &ben).await, upload(&app, &ada).await];
        worker::work_off_jobs(&app.state).await.unwrap();
        Self { app, id: north, attempts, ada: ada.person.id }
    }

    async fn ask(&self, teacher: &mut Client, changed: &[(&str, &str)]) -> Answer {
        let page = teacher.get("/segments/new").await.text();
        let cohort = page.split("<option value=\"").nth(1).unwrap().split('"').next().unwrap().to_owned();
        let (csrf, attempts) = (csrf_in(&page), self.attempts.map(|id| id.to_string()));
        let fields = [
            ("csrf", csrf.as_str()),
            ("title", "Where are the pops?"),
            ("cohort", &cohort),
            ("attempt", &attempts[0]),
            ("attempt", &attempts[1]),
            ("due", ""),
        ];
        let kept = fields.into_iter().filter(|(name, _)| !changed.iter().any(|(other, _)| name == other));
        teacher.form("/segments", &kept.chain(changed.iter().copied()).collect::<Vec<_>>()).await
    }

    /// A task of both attempts, and its page.
    async fn task(&self) -> String {
        let mut teacher = self.app.signed_in("teacher@example.org").await;
        let made = self.ask(&mut teacher, &[]).await;
        assert_eq!(made.status, 303, "{}", made.text());
        made.header("location").to_owned()
    }

    /// A task that is due on 27 March, two days before the clocks go forward.
    async fn dated_task(&self, teacher: &mut Client) -> String {
        self.ask(teacher, &[("due", "2026-03-27T18:00")]).await.header("location").to_owned()
    }

    async fn extend(&self, teacher: &mut Client, task: &str, (person, days): (PersonId, &str)) -> Answer {
        let (csrf, person) = (csrf_in(&teacher.get("/").await.text()), person.to_string());
        teacher.form(&format!("{task}/extend"), &[("csrf", &csrf), ("person", &person), ("days", days)]).await
    }

    /// Whom letters were written to.
    async fn reminded(&self) -> Vec<String> {
        deadlines::remind(&self.app.state).await.unwrap();
        outbox::work_off_letters(&self.app.state).await.unwrap();
        let MailTo::Folder(folder) = &self.app.state.config.mail else { panic!("mail goes to a folder") };
        let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
        let letters = entries.map(|entry| std::fs::read_to_string(entry.unwrap().path()).unwrap());
        let to = |letter: String| {
            assert!(
                letter.replace("\r\n ", " ").contains("27 Mar 2026, 18:00: Where are the pops?")
                    || letter.contains("3 Apr"),
                "{letter}"
            );
            letter.lines().find(|line| line.starts_with("To:")).unwrap().to_owned()
        };
        letters.map(to).collect()
    }

    async fn pops(&self, attempt: SessionId) -> Vec<f64> {
        let key = SessionKey { school_id: self.id, id: attempt };
        pops(&scores::find_curve(self.app.state.db.reader(), key).await.unwrap().unwrap())
    }
}

async fn mark(trainee: &mut Client, trace: &str, marks: &[String], step: &str) -> Answer {
    let csrf = csrf_in(&trainee.get("/").await.text());
    let mut fields = vec![("csrf", csrf.as_str()), ("do", step), ("mark", "")];
    fields.extend(marks.iter().map(|mark| ("mark", mark.as_str())));
    trainee.form(trace, &fields).await
}

#[tokio::test]
async fn trace_hides_the_pops_until_marks_are_sent() {
    let school = School::new().await;
    let task = school.task().await;
    let truth = school.pops(school.attempts[0]).await;
    assert!(truth.len() >= 2, "an attempt with pops: {truth:?}");
    let mut ada = school.app.signed_in("ada@example.org").await;
    assert!(ada.get("/segments").await.text().contains("0 of 1"), "without her own attempt");
    let own = ada.get(&task).await;
    assert_eq!(own.text().matches("/segments/traces/").count(), 1, "{}", own.text());
    let trace = own.link("/segments/traces/");

    // One hit 40 ms late, one mark where nothing is, the rest missed.
    let marks = [format!("{:.3}", truth[0] + 0.04), "0.01".to_owned()];
    assert_eq!(mark(&mut ada, &trace, &marks, "save").await.status, 303);
    let page = ada.get(&trace).await.text();
    assert!(page.contains(&format!("value=\"{}\"", truth[0] + 0.04)) || page.contains("own-mark"), "{page}");
    for hidden in [NAME, "class=\"pop", "class=\"band", "rupture", "out of 100", &school.attempts[0].to_string()] {
        assert!(!page.contains(hidden), "the page tells {hidden}: {page}");
    }
    for moment in &truth {
        assert!(!page.contains(&format!("{moment}")), "the page tells a pop: {page}");
    }
    for rest in ["", "/replay", "/series", "/score", "/recording", "/comments"] {
        let path = format!("/api/v1/sessions/{}{rest}", school.attempts[0]);
        assert_eq!(ada.get(&path).await.status, 404, "{path}");
    }

    assert_eq!(mark(&mut ada, &trace, &marks, "send").await.status, 303);
    let page = ada.get(&trace).await.text();
    assert_eq!(page.matches("class=\"pop\" x1").count(), 2 * truth.len() + 1, "both widths and the legend: {page}");
    assert!(page.contains(&format!("1 of {}", truth.len())) && page.contains("40 ms"), "{page}");
    assert!(!page.contains(NAME) && !page.contains("name=\"mark\""), "{page}");
    assert_eq!(mark(&mut ada, &trace, &[], "send").await.status, 409, "sent marks stay");
    assert_eq!(mark(&mut ada, &trace, &["x".to_owned()], "save").await.status, 409);

    let held = ada.get("/account/export").await.json();
    assert_eq!((&held["marked_pops"][0]["found"], &held["marked_pops"][0]["pops"]), (&1.into(), &truth.len().into()));

    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let table = teacher.get(&task).await.text();
    assert!(table.contains(&format!("1 of {}", truth.len())) && table.contains("0 of 1"), "{table}");
    let csv = teacher.get(&format!("{task}/results.csv")).await.text();
    let missed = truth.len() - 1;
    let line = csv.lines().find(|line| line.starts_with("Somebody")).unwrap();
    assert!(line.starts_with(&format!("Somebody,1,1,no,{},1,{missed},1,", truth.len())), "{csv}");
}

#[tokio::test]
async fn nobody_is_given_their_own_attempt_or_somebody_elses_task() {
    let school = School::new().await;
    let task = school.task().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let page = teacher.get(&task).await.text();
    let traces: Vec<String> = page
        .split("href=\"/segments/traces/")
        .skip(1)
        .map(|rest| format!("/segments/traces/{}", rest.split('"').next().unwrap()))
        .collect();
    assert_eq!(traces.len(), 2, "{page}");
    let mut ada = school.app.signed_in("ada@example.org").await;
    let answers = [ada.get(&traces[0]).await.status, ada.get(&traces[1]).await.status];
    assert_eq!(answers.map(|status| status.as_u16()), [200, 404], "Ben’s, and her own");
    assert_eq!(mark(&mut ada, &traces[1], &[], "send").await.status, 404);
    let seen = teacher.get(&traces[0]).await.text();
    assert!(seen.contains("class=\"pop\"") && !seen.contains("name=\"mark\""), "whoever teaches looks: {seen}");
    assert_eq!(mark(&mut teacher, &traces[0], &[], "send").await.status, 403);
    let mut other = school.app.signed_in("other@example.org").await;
    for path in [&task, &traces[0], &format!("{task}/results.csv")] {
        assert_eq!(other.get(path).await.status, 404, "{path}");
    }
    assert_eq!(ada.get(&format!("{task}/results.csv")).await.status, 403);
    let csrf = csrf_in(&page);
    assert_eq!(teacher.form(&format!("{task}/withdraw"), &[("csrf", &csrf)]).await.status, 303);
    assert_eq!(ada.get(&traces[0]).await.status, 404);
    assert!(ada.get("/segments").await.text().contains("nothing to mark"));
}

#[tokio::test]
async fn invalid_marks_or_task_are_rejected_and_keep_the_input() {
    let school = School::new().await;
    let task = school.task().await;
    let mut ada = school.app.signed_in("ada@example.org").await;
    let trace = ada.get(&task).await.link("/segments/traces/");
    for typed in ["soon", "-1", "99"] {
        let refused = mark(&mut ada, &trace, &["0.5".to_owned(), typed.to_owned()], "send").await;
        assert_eq!(refused.status, 422, "{typed}");
        let page = refused.text();
        assert!(page.contains("role=\"alert\"") && page.contains("Pop 3") && page.contains("value=\"0.5\""), "{page}");
        assert!(page.contains(&format!("value=\"{typed}\"")) && !page.contains("class=\"pop"), "{page}");
    }
    assert_eq!(mark(&mut ada, &trace, &[], "look").await.status, 400);
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    for (field, value, word) in
        [("title", "", "0 characters"), ("due", "2020-01-01T10:00", "in the past"), ("attempt", "", "404")]
    {
        let refused = school.ask(&mut teacher, &[(field, value)]).await;
        let expected = if word == "404" { 404 } else { 422 };
        assert_eq!(refused.status, expected, "{field}: {}", refused.text());
        assert!(expected == 404 || refused.text().contains(word), "{}", refused.text());
    }
    let none = school.ask(&mut teacher, &[("cohort", &CohortId::random().to_string())]).await;
    assert_eq!(none.status, 404, "another school’s cohort");
}

#[tokio::test]
async fn one_trainee_has_longer_by_calendar_days_and_is_not_late() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let task = school.dated_task(&mut teacher).await;
    assert_eq!(school.extend(&mut teacher, &task, (school.ada, "7")).await.status, 303);
    let mut ada = school.app.signed_in("ada@example.org").await;
    for path in ["/segments", &task] {
        let own = ada.get(path).await.text();
        assert!(own.contains("3 Apr 2026, 18:00") && own.contains("UTC+02:00"), "{own}");
        assert!(own.contains("7 more days for you"), "{own}");
    }
    let bens = school.app.signed_in("ben@example.org").await.get(&task).await.text();
    assert!(bens.contains("27 Mar 2026, 18:00") && bens.contains("UTC+01:00") && !bens.contains("longer"), "{bens}");
    for (person, days, status) in [(school.ada, "367", 422), (school.ada, "-1", 422), (PersonId::random(), "7", 404)] {
        assert_eq!(school.extend(&mut teacher, &task, (person, days)).await.status, status, "{days}");
    }
    let mut other = school.app.signed_in("other@example.org").await;
    assert_eq!(school.extend(&mut other, &task, (school.ada, "7")).await.status, 404);
    let without_date = school.task().await;
    assert_eq!(school.extend(&mut teacher, &without_date, (school.ada, "7")).await.status, 409);

    school.app.state.clock.advance(25 * DAY_S);
    let mut ada = school.app.signed_in("ada@example.org").await;
    let trace = ada.get(&task).await.link("/segments/traces/");
    assert_eq!(mark(&mut ada, &trace, &["1".to_owned()], "send").await.status, 303);
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    assert!(!teacher.get(&task).await.text().contains("Late"), "on 30 March, within her extension");
    assert_eq!(school.extend(&mut teacher, &task, (school.ada, "0")).await.status, 303);
    assert!(teacher.get(&task).await.text().contains("Late"), "as long as everybody");
}

#[tokio::test]
async fn trainee_without_marks_is_reminded_once_before_their_due_date() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let task = school.dated_task(&mut teacher).await;
    assert_eq!(school.extend(&mut teacher, &task, (school.ada, "7")).await.status, 303);
    assert_eq!(school.reminded().await.len(), 0, "not three weeks before");
    school.app.state.clock.advance(21 * DAY_S);
    let first = school.reminded().await;
    assert!(first.len() == 1 && first[0].contains("ben@example.org"), "{first:?}");
    assert_eq!(school.reminded().await.len(), 1, "once");
    school.app.state.clock.advance(7 * DAY_S);
    let both = school.reminded().await;
    assert!(both.len() == 2 && both.iter().any(|to| to.contains("ada@example.org")), "{both:?}");

    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let task = school.dated_task(&mut teacher).await;
    for name in ["ada", "ben"] {
        let mut trainee = school.app.signed_in(&format!("{name}@example.org")).await;
        let trace = trainee.get(&task).await.link("/segments/traces/");
        assert_eq!(mark(&mut trainee, &trace, &["1".to_owned()], "send").await.status, 303);
    }
    school.app.state.clock.advance(21 * DAY_S);
    assert_eq!(school.reminded().await, Vec::<String>::new(), "nothing is left to do");
}
