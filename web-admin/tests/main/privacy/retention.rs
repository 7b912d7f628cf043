//! Whoever does nothing for as long as their school has set is warned, and then erased. Fails when anybody is erased who was not told for as long
//! as was promised, whatever the clock is set to; when somebody goes who is to stay; when a dry run changes something or a step is
//! missing from the audit log; and when a school that has set nothing loses anybody.

use std::time::Duration;

use acts::people::accounts;
use acts::privacy::retention;
use model::ids::SchoolId;
use model::{Moment, Role};
use platform::clock::Clock;
use platform::config::MailTo;
use store::{audit, people};
use web_admin::outbox;

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::{App, web_admin};

const NOW: Moment = Moment::from_micros(1_579_000_000_000_000); // 2020-01-14
const DAY_S: i64 = 86_400;
const PEOPLE: [(&str, Role); 5] = [
    ("idle", Role::Trainee),
    ("active", Role::Trainee),
    ("kept", Role::Trainee),
    ("teacher", Role::Instructor),
    ("head", Role::Administrator),
];

async fn post(client: &mut Client, page: &str, path: &str, fields: &[(&str, &str)]) -> Answer {
    let csrf = csrf_in(&client.get(page).await.text());
    client.form(path, &[&[("csrf", csrf.as_str())], fields].concat()).await
}

struct School {
    app: App,
    id: SchoolId,
}

impl School {
    /// A school whose people were added and have done nothing since, but for one.
    async fn new() -> Self {
        Self::with_mail(|_| {}).await
    }

    async fn with_mail(change: impl FnOnce(&mut platform::config::Config)) -> Self {
        let app = App::with(Clock::fixed(NOW), change).await;
        let id = app.school("North").await;
        for (name, role) in PEOPLE {
            app.member(id, role, &format!("{name}@example.org")).await;
        }
        Self { app, id }
    }

    async fn head(&self) -> Client {
        self.app.signed_in("head@example.org").await
    }

    /// Twelve months, thirty days before.
    async fn set_rule(&self) {
        let rule = [("months", "12"), ("warn_days", "30")];
        let set = post(&mut self.head().await, "/admin/retention", "/admin/retention", &rule).await;
        assert_eq!(set.status, 303, "{}", set.text());
    }

    /// The service runs on for some days, and its clock goes forward by others.
    async fn run(&self, run_days: i64, clock_days: i64) {
        self.app.state.clock.advance(clock_days * DAY_S);
        let run_s = u64::try_from(run_days * DAY_S).unwrap();
        retention::tick(&self.app.state, Duration::from_secs(run_s)).await.unwrap();
        outbox::work_off_letters(&self.app.state).await.unwrap();
    }

    async fn known(&self) -> Vec<&'static str> {
        let mut found = Vec::new();
        for (name, _) in PEOPLE {
            let email = format!("{name}@example.org");
            if people::find_person_by_email(self.app.state.db.reader(), &email).await.unwrap().is_some() {
                found.push(name);
            }
        }
        found
    }

    fn letters(&self) -> Vec<String> {
        let MailTo::Folder(folder) = &self.app.state.config.mail else { panic!("mail goes to a folder") };
        let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
        entries.map(|entry| std::fs::read_to_string(entry.unwrap().path()).unwrap()).collect()
    }

    async fn log(&self, action: &str) -> i64 {
        sqlx::query_scalar("SELECT count(*) FROM audit_log WHERE action = $1")
            .bind(action)
            .fetch_one(self.app.state.db.reader())
            .await
            .unwrap()
    }

    async fn person(&self, name: &str) -> people::Person {
        people::find_person_by_email(self.app.state.db.reader(), &format!("{name}@example.org")).await.unwrap().unwrap()
    }
}

const EVERYBODY: [&str; 5] = ["idle", "active", "kept", "teacher", "head"];

#[tokio::test]
async fn a_school_that_has_set_nothing_keeps_everybody() {
    let school = School::new().await;
    for _ in 0..5 {
        school.run(400, 400).await;
    }
    assert_eq!(school.known().await, EVERYBODY);
    assert_eq!((school.letters().len(), school.log("retention.warned").await), (0, 0));
}

#[tokio::test]
async fn inactive_people_are_warned_then_erased_and_others_stay() {
    let school = School::new().await;
    school.set_rule().await;
    let kept = format!("/people/{}", school.person("kept").await.id);
    let held = post(&mut school.head().await, &kept, &format!("{kept}/hold"), &[("hold", "yes")]).await;
    assert_eq!(held.status, 303);
    school.run(330, 330).await;
    assert_eq!(school.letters().len(), 0);
    school.app.signed_in("active@example.org").await;
    // Any stranger may ask for a link.
    accounts::ask_for_link(&school.app.state, "idle@example.org").await.unwrap();
    school.run(10, 10).await;
    let letters: Vec<_> = school.letters().into_iter().filter(|letter| letter.contains("30 days")).collect();
    assert_eq!(letters.len(), 2, "{letters:#?}");
    assert!(
        letters.iter().any(|letter| letter.contains("idle@example.org") && letter.contains("30 days")),
        "{letters:#?}"
    );
    let mut head = school.head().await;
    let page = head.get("/admin/retention").await.text();
    assert!(page.contains("will be erased in 30 days") && page.contains("On legal hold"), "{page}");
    assert!(head.get("/admin").await.text().contains("2 people were warned"));
    school.run(29, 29).await;
    assert_eq!(school.known().await, EVERYBODY);
    school.run(2, 2).await;
    assert_eq!(school.known().await, ["active", "kept", "head"]);
    let log =
        (school.log("retention.warned").await, school.log("person.erased").await, school.log("retention.set").await);
    assert_eq!(log, (2, 2, 1));
    let by: Vec<String> = sqlx::query_scalar("SELECT DISTINCT actor FROM audit_log WHERE action = 'person.erased'")
        .fetch_all(school.app.state.db.reader())
        .await
        .unwrap();
    assert_eq!(by, ["worker"]);
    assert!(audit::check_audit_chain(school.app.state.db.reader()).await.unwrap().findings.is_empty());
    assert_eq!(school.letters().len(), 0, "letters go with whom they name");
    let list = std::fs::read_to_string(school.app.folder.path().join("erasures.jsonl")).unwrap();
    assert_eq!(list.lines().count(), 2, "by the same path as by hand: {list}");
}

#[tokio::test]
async fn no_clock_that_is_set_erases_anybody() {
    for ahead in [1, 365, 3650] {
        let school = School::new().await;
        school.set_rule().await;
        school.run(340, 340).await;
        assert_eq!(school.letters().len(), 4);
        // The clock jumps; the service has run for a day, and for another.
        for _ in 0..3 {
            school.run(1, ahead).await;
        }
        assert_eq!(school.known().await, EVERYBODY, "{ahead} days ahead");
        school.run(26, 1).await;
        assert_eq!(school.known().await, EVERYBODY, "{ahead} days ahead, a day too soon");
        school.run(2, 40).await;
        assert_eq!(school.known().await, ["head"], "{ahead} days ahead");
    }
}

#[tokio::test]
async fn whoever_comes_back_stays() {
    let school = School::new().await;
    school.set_rule().await;
    school.run(340, 340).await;
    school.app.signed_in("idle@example.org").await;
    school.run(40, 40).await;
    assert_eq!(school.known().await, ["idle", "head"]);
    assert_eq!(school.log("retention.called_off").await, 1);
}

#[tokio::test]
async fn erasure_waits_until_the_undeliverable_letter_is_given_up() {
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let nobody = format!("smtp://{}", listener.local_addr().unwrap());
    drop(listener);
    let school = School::with_mail(|config| config.mail = MailTo::Smtp(nobody)).await;
    school.set_rule().await;
    school.run(340, 340).await;
    for _ in 0..2 {
        school.run(40, 40).await;
    }
    assert_eq!(school.known().await, EVERYBODY, "a letter that is tried again is not out");
    let page = school.head().await.get("/admin/retention").await.text();
    assert!(page.contains("The email could not be sent") && page.contains("not been sent yet"), "{page}");
    for _ in 0..6 {
        school.run(2, 2).await;
    }
    assert_eq!(school.known().await, EVERYBODY, "given up now, and the days begin");
    school.run(31, 31).await;
    assert_eq!(school.known().await, ["head"]);
}

#[tokio::test]
async fn a_dry_run_says_who_and_why_and_changes_nothing() {
    let school = School::new().await;
    school.set_rule().await;
    let before = audit::check_audit_chain(school.app.state.db.reader()).await.unwrap();
    let retain = |more: &[&str]| {
        let output = web_admin(school.app.folder.path(), &[&["retain"], more].concat());
        let words = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        (output.status.code(), words)
    };
    let (code, words) = retain(&["--dry-run"]);
    assert_eq!(code, Some(0), "{words}");
    let warned =
        words.lines().filter(|line| line.starts_with("  warn: ") && line.contains("last active on 2020-01-14"));
    assert_eq!(warned.count(), 4, "{words}");
    assert!(words.contains("North: keeps people for 12 months") && !words.contains("head@"), "{words}");
    assert_eq!(audit::check_audit_chain(school.app.state.db.reader()).await.unwrap(), before);
    assert_eq!(retain(&["--dry-run", "--school", "South"]).0, Some(2));
    let (_, words) = retain(&[]);
    assert!(words.contains("warned 4, withdrawn 0, erased 0"), "{words}");
    assert_eq!(school.log("retention.warned").await, 4);
    assert_eq!(school.known().await, EVERYBODY);
}

#[tokio::test]
async fn invalid_retention_rule_is_rejected_and_a_hold_stops_erasure() {
    let school = School::new().await;
    let mut head = school.head().await;
    for (months, days, word) in
        [("2", "30", "“2”"), ("x", "30", "“x”"), ("241", "30", "240"), ("12", "6", "“6”"), ("12", "", "365")]
    {
        let rule = [("months", months), ("warn_days", days)];
        let refused = post(&mut head, "/admin/retention", "/admin/retention", &rule).await;
        assert!(refused.status == 422 && refused.text().contains(word), "{months} {days}: {}", refused.text());
    }
    let page = format!("/people/{}", school.person("idle").await.id);
    post(&mut head, &page, &format!("{page}/hold"), &[("hold", "yes")]).await;
    let erased = post(&mut head, &page, &format!("{page}/erase"), &[("confirm", "idle@example.org")]).await;
    assert_eq!(erased.status, 409, "{}", erased.text());
    assert_eq!(school.known().await, EVERYBODY);
    post(&mut head, &page, &format!("{page}/hold"), &[("hold", "no")]).await;
    let erased = post(&mut head, &page, &format!("{page}/erase"), &[("confirm", "idle@example.org")]).await;
    assert_eq!(erased.status, 303, "{}", erased.text());
    assert_eq!((school.log("person.held").await, school.log("person.released").await), (1, 1));
    assert_eq!(school.id, school.person("head").await.school_id);
}
