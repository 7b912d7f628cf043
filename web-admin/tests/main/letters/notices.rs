//! What is new reaches whom it is for, through the front door. Fails when a comment, an answer, an override, a rating round's result or an
//! assignment is not told of, when somebody is told of their own acts, when what was read stays new, or when mail comes twice a day.

use acts::letters::notices;
use model::ids::SessionId;
use model::{Moment, Role};
use platform::clock::Clock;
use platform::config::MailTo;
use web_admin::{outbox, worker};

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member};

/// 2026-03-01 00:00 UTC.
const NOW: Moment = Moment::from_micros(1_772_323_200_000_000);

struct World {
    app: App,
    ada: Member,
    attempt: SessionId,
}

impl World {
    async fn new() -> Self {
        let app = App::with(Clock::fixed(NOW), |_| {}).await;
        let north = app.school("North").await;
        app.publish(north).await;
        let ada = app.member(north, Role::Trainee, "ada@example.org").await;
        let teacher = app.member(north, Role::Instructor, "teacher@example.org").await;
        app.cohort(north, "Spring", &[&ada.person, &teacher.person]).await;
        let attempt = Attempt { session_id: SessionId::random(), ..Attempt::default() };
        assert_eq!(app.with_token(&ada.token).upload(&record(&attempt)).await.status, 201);
        worker::work_off_jobs(&app.state).await.unwrap();
        Self { app, ada, attempt: attempt.session_id }
    }

    async fn teacher(&self) -> Client {
        self.app.signed_in("teacher@example.org").await
    }

    async fn ada(&self) -> Client {
        self.app.signed_in("ada@example.org").await
    }

    fn path(&self, rest: &str) -> String {
        format!("/sessions/{}{rest}", self.attempt)
    }

    /// Sends a form of the replay.
    async fn say(&self, browser: &mut Client, kind: &str, body: &str) -> Answer {
        let csrf = csrf_in(&browser.get(&self.path("/grade")).await.text());
        let fields = [("csrf", csrf.as_str()), ("kind", kind), ("from_s", "0.5"), ("body", body)];
        browser.form(&self.path("/comments"), &fields).await
    }

    async fn letters(&self) -> Vec<String> {
        notices::queue_news_letters(&self.app.state).await.unwrap();
        outbox::work_off_letters(&self.app.state).await.unwrap();
        let MailTo::Folder(folder) = &self.app.state.config.mail else { panic!("mail goes to a folder") };
        let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
        entries.map(|entry| std::fs::read_to_string(entry.unwrap().path()).unwrap()).collect()
    }
}

#[tokio::test]
async fn comment_and_answer_notify_the_other_until_they_are_read() {
    let world = World::new().await;
    let mut teacher = world.teacher().await;
    assert_eq!(world.say(&mut teacher, "error", "Too fast").await.status, 303);
    assert!(!teacher.get("/").await.text().contains("News"), "nobody is told of their own acts");
    let mut ada = world.ada().await;
    let home = ada.get("/").await.text();
    assert!(home.contains("News") && home.contains("has commented on your attempt at"), "{home}");
    assert!(ada.get("/curricula").await.text().contains("<span class=\"count\">1<"), "the navigation counts");
    let (_, rest) = home.split_once(&world.path("/replay?t=0.50#comment-")).expect("a link to the moment");
    let comment = &rest[..36];
    let page = ada.get(&world.path("/replay")).await.text();
    assert!(!page.contains("class=\"count\"") && page.contains("Too fast"), "opening it is reading it");
    assert!(!ada.get("/").await.text().contains("News"));
    let answer = world.path(&format!("/comments/{comment}/answers"));
    assert_eq!(ada.form(&answer, &[("csrf", &csrf_in(&page)), ("body", "I see")]).await.status, 303);
    let home = teacher.get("/").await.text();
    assert!(home.contains("has answered a comment on"), "{home}");
    assert!(!ada.get("/").await.text().contains("News"));
    let csrf = csrf_in(&home);
    assert_eq!(teacher.form("/news/read", &[("csrf", &csrf)]).await.status, 303);
    assert!(!teacher.get("/").await.text().contains("News"), "all are marked as read");
}

#[tokio::test]
async fn question_notifies_teachers_until_it_is_withdrawn() {
    let world = World::new().await;
    let mut ada = world.ada().await;
    assert_eq!(world.say(&mut ada, "question", "Was that the fascia?").await.status, 303);
    assert_eq!(world.say(&mut ada, "praise", "I like it").await.status, 303);
    let mut teacher = world.teacher().await;
    let home = teacher.get("/").await.text();
    assert_eq!(home.matches("has a question about an attempt at").count(), 1, "{home}");
    let (_, rest) = home.split_once("#comment-").expect("a link");
    let withdraw = world.path(&format!("/comments/{}/withdraw", &rest[..36]));
    let csrf = csrf_in(&ada.get("/").await.text());
    assert_eq!(ada.form(&withdraw, &[("csrf", &csrf)]).await.status, 303);
    assert!(!teacher.get("/").await.text().contains("News"));
}

#[tokio::test]
async fn an_override_and_an_assignment_reach_the_trainee() {
    let world = World::new().await;
    let mut teacher = world.teacher().await;
    let csrf = csrf_in(&teacher.get("/").await.text());
    let fields = [("csrf", csrf.as_str()), ("score", "97"), ("result", "passed"), ("reason", "The device slipped")];
    assert_eq!(teacher.form(&world.path("/override"), &fields).await.status, 303);
    let assign = |task: &'static str, mailed: &'static str| {
        let email = "ada@example.org";
        [("task", task), ("email", email), ("mailed", mailed), ("since_only", "yes"), ("csrf", csrf.as_str())]
    };
    assert_eq!(teacher.form("/assignments", &assign("exercise:feel-the-layers", "no")).await.status, 303);
    let mut ada = world.ada().await;
    let home = ada.get("/").await.text();
    assert!(home.contains("has overridden the score of your attempt at") && home.contains("to you</a>"), "{home}");
    assert!(world.letters().await.is_empty(), "nobody ticked that it is mailed, and an hour is not over");
    ada.get(&world.path("")).await;
    ada.get("/assignments").await;
    assert!(!ada.get("/").await.text().contains("News"));
    assert_eq!(teacher.form("/assignments", &assign("course:lower-back-basics", "yes")).await.status, 303);
    let letters = world.letters().await;
    assert!(letters.len() == 1 && letters[0].contains("To: ") && letters[0].contains("/assignments"), "{letters:?}");
}

#[tokio::test]
async fn mail_comes_at_most_once_a_day_and_only_where_it_is_wanted() {
    let world = World::new().await;
    let pass = |hours: i64| world.app.state.clock.advance(hours * 3600);
    world.say(&mut world.teacher().await, "praise", "Well held").await;
    assert!(world.letters().await.is_empty(), "it waits for company");
    pass(2);
    let first = world.letters().await;
    assert!(first.len() == 1 && first[0].contains("News for you at North"), "{first:?}");
    world.say(&mut world.teacher().await, "praise", "Well held again").await;
    pass(2);
    assert_eq!(world.letters().await.len(), 1, "once a day");
    pass(24);
    assert_eq!(world.letters().await.len(), 2);
    let mut ada = world.ada().await;
    let account = ada.get("/account").await.text();
    assert!(account.contains("name=\"mailed\" value=\"yes\" checked"), "{account}");
    assert_eq!(ada.form("/account/news", &[("csrf", &csrf_in(&account))]).await.status, 303);
    assert!(!ada.get("/account").await.text().contains("name=\"mailed\" value=\"yes\" checked"));
    world.say(&mut world.teacher().await, "praise", "Once more").await;
    pass(48);
    assert_eq!(world.letters().await.len(), 2, "she does not want them");
    let told: i64 = sqlx::query_scalar("SELECT count(*) FROM notices WHERE person_id = $1")
        .bind(world.ada.person.id)
        .fetch_one(world.app.state.db.reader())
        .await
        .unwrap();
    assert_eq!(told, 3);
}
