//! The pages through the front door, role by role. Fails when a page shows somebody what they may not see, hides what
//! they came for, or tells the missing from the forbidden.

use model::Role;
use model::ids::SessionId;
use web_admin::worker;

use crate::support::recordings::{Attempt, record, tampered, without_samples};
use crate::support::{App, Member};

/// A school with a course, a trainee with one scored attempt, and everybody around them.
struct School {
    app: App,
    trainee: Member,
    attempt: SessionId,
}

impl School {
    async fn new() -> Self {
        let app = App::new().await;
        let north = app.school("North").await;
        app.publish(north).await;
        let trainee = app.member(north, Role::Trainee, "ada@example.org").await;
        let teacher = app.member(north, Role::Instructor, "teacher@example.org").await;
        app.member(north, Role::Trainee, "bob@example.org").await;
        app.member(north, Role::Instructor, "other@example.org").await;
        app.member(north, Role::Administrator, "head@example.org").await;
        let south = app.school("South").await;
        app.member(south, Role::Administrator, "head@south.example").await;
        app.cohort(north, "Spring", &[&trainee.person, &teacher.person]).await;
        let attempt = upload(&app, &trainee, record).await;
        worker::work_off_jobs(&app.state).await.unwrap();
        Self { app, trainee, attempt }
    }

    async fn page(&self, email: &str, path: &str) -> String {
        let answer = self.app.signed_in(email).await.get(path).await;
        assert_eq!(answer.status, 200, "{email} {path}: {}", answer.text());
        assert!(!answer.text().contains("NaN"), "{path}");
        answer.text()
    }

    /// The only cohort's page, by the list's own link.
    async fn cohort_path(&self) -> String {
        self.app.signed_in("teacher@example.org").await.get("/cohorts").await.link("/cohorts/")
    }
}

async fn upload(app: &App, trainee: &Member, recorded: impl Fn(&Attempt) -> Vec<u8>) -> SessionId {
    let attempt = Attempt { session_id: SessionId::random(), ..Attempt::default() };
    let answer = app.with_token(&trainee.token).upload(&recorded(&attempt)).await;
    assert_eq!(answer.status, 201, "{}", answer.text());
    attempt.session_id
}

#[tokio::test]
async fn trainee_finds_the_next_exercise_and_the_scored_attempt() {
    let school = School::new().await;
    let home = school.page("ada@example.org", "/").await;
    for wanted in ["Do next", "Feel the layers", "1 attempt in all", &format!("/sessions/{}", school.attempt)] {
        assert!(home.contains(wanted), "{wanted} is missing in {home}");
    }
    let session = school.page("ada@example.org", &format!("/sessions/{}", school.attempt)).await;
    for wanted in ["out of 100", "full marks", "Tip into skin", "Rim into skin", "identical", "<svg", "Energy by layer"]
    {
        assert!(session.contains(wanted), "{wanted} is missing in {session}");
    }
    let exercise = school.page("ada@example.org", "/exercises/feel-the-layers").await;
    assert!(exercise.contains("Your attempts") && exercise.contains("Cross-section"), "{exercise}");
    let curricula = school.page("ada@example.org", "/curricula").await;
    assert!(curricula.contains("/exercises/avoid-the-vessel") && curricula.contains("Locked"), "{curricula}");
}

#[tokio::test]
async fn an_instructor_sees_the_cohort_they_teach() {
    let school = School::new().await;
    let cohort = school.page("teacher@example.org", &school.cohort_path().await).await;
    assert!(
        cohort.contains("Everybody in this course")
            && cohort.contains(&format!("/trainees/{}", school.trainee.person.id))
    );
    let home = school.page("teacher@example.org", "/").await;
    assert!(home.contains("Spring") && home.contains(&format!("/sessions/{}", school.attempt)), "{home}");
    let trainee = school.page("teacher@example.org", &format!("/trainees/{}", school.trainee.person.id)).await;
    assert!(trainee.contains("Feel the layers"), "{trainee}");
    let exercise = school.page("teacher@example.org", "/exercises/feel-the-layers").await;
    assert!(exercise.contains("Latest attempts") && exercise.contains(&school.attempt.to_string()), "{exercise}");
    let other = school.page("other@example.org", "/").await;
    assert!(other.contains("You do not teach a cohort yet") && !other.contains(&school.attempt.to_string()), "{other}");
}

#[tokio::test]
async fn an_administrator_sees_the_school_and_its_queue() {
    let school = School::new().await;
    school.app.station(school.trainee.person.school_id).await;
    upload(&school.app, &school.trainee, record).await;
    let home = school.page("head@example.org", "/").await;
    assert!(home.contains("North") && home.contains("1 recording is waiting") && home.contains("Spring"), "{home}");
    let admin = school.page("head@example.org", "/admin").await;
    assert!(admin.contains("href=\"/people\"") && admin.contains("room 2"), "{admin}");
    assert!(!admin.contains("ada@example.org"), "people have a page of their own");
    let people = school.page("head@example.org", "/people").await;
    assert!(people.contains("ada<wbr>@example.org") && !people.contains("@south.example"), "{people}");
    school.page("head@example.org", &school.cohort_path().await).await;
}

#[tokio::test]
async fn many_cohorts_come_page_by_page_each_once() {
    let school = School::new().await;
    let id = school.trainee.person.school_id;
    for n in 0..60 {
        school.app.cohort(id, &format!("Year {n:02} & more"), &[]).await;
    }
    let mut head = school.app.signed_in("head@example.org").await;
    let first = head.get("/cohorts").await;
    let second = head.get(&first.link("/cohorts?after=")).await;
    let listed = [first.text(), second.text()].concat();
    for name in (0..60).map(|n| format!(">Year {n:02} &#38; more<")).chain([">Spring<".to_owned()]) {
        assert_eq!(listed.matches(&name).count(), 1, "{name}");
    }
    assert!(!second.text().contains("rel=\"next\"") && second.text().contains("From the beginning"));
    assert!(head.get("/").await.text().contains("All cohorts"));
    let taught = school.page("teacher@example.org", "/cohorts").await;
    assert!(taught.contains(">Spring<") && !taught.contains("Year 01"), "{taught}");
}

#[tokio::test]
async fn what_is_not_yours_is_not_there() {
    let school = School::new().await;
    let paths = [
        format!("/sessions/{}", school.attempt),
        format!("/trainees/{}", school.trainee.person.id),
        school.cohort_path().await,
    ];
    for email in ["bob@example.org", "other@example.org", "head@south.example"] {
        let mut browser = school.app.signed_in(email).await;
        for path in &paths {
            let answer = browser.get(path).await;
            assert_eq!(answer.status, 404, "{email} {path}");
            let never = browser.get(&path.replace(|c: char| c.is_ascii_digit(), "0")).await;
            assert_eq!(answer.text(), never.text(), "the forbidden reads as the missing");
        }
    }
    let mut abroad = school.app.signed_in("head@south.example").await;
    assert_eq!(abroad.get("/exercises/feel-the-layers").await.status, 404);
    assert!(abroad.get("/curricula").await.text().contains("No courses yet"));
}

#[tokio::test]
async fn pages_of_other_roles_are_403_and_unknown_ids_are_404() {
    let school = School::new().await;
    let mut ada = school.app.signed_in("ada@example.org").await;
    for path in ["/cohorts", "/admin"] {
        let answer = ada.get(path).await;
        assert_eq!(answer.status, 403, "{path}");
        assert!(answer.text().contains("No permission"));
    }
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    assert_eq!(teacher.get("/admin").await.status, 403);
    for path in ["/sessions/x", "/trainees/1", "/cohorts/%ff", "/exercises/none", "/nothing"] {
        assert_eq!(teacher.get(path).await.status, 404, "{path}");
    }
    assert_eq!(ada.get("/?page=0").await.status, 200);
    assert_eq!(ada.get("/?page=4000000000").await.status, 200);
    assert_eq!(ada.get("/?page=x").await.status, 400);
}

#[tokio::test]
async fn an_attempt_says_what_became_of_it() {
    let school = School::new().await;
    let waiting = upload(&school.app, &school.trainee, record).await;
    let page = school.page("ada@example.org", &format!("/sessions/{waiting}")).await;
    assert!(page.contains("is being scored"), "{page}");
    let forged = upload(&school.app, &school.trainee, tampered).await;
    let empty = upload(&school.app, &school.trainee, without_samples).await;
    worker::work_off_jobs(&school.app.state).await.unwrap();
    let page = school.page("ada@example.org", &format!("/sessions/{forged}")).await;
    assert!(page.contains("differs from the recording"), "{page}");
    let page = school.page("ada@example.org", &format!("/sessions/{empty}")).await;
    assert!(page.contains("could not be scored"), "{page}");
    let home = school.page("ada@example.org", "/").await;
    assert!(home.contains("Re-simulation differs") && home.contains("Not scored"), "{home}");
}

#[tokio::test]
async fn the_style_sheet_is_kept_by_the_browser_until_it_changes() {
    let app = App::new().await;
    let mut stranger = app.stranger();
    let login = stranger.get("/login").await.text();
    let path = login.split("rel=\"stylesheet\" href=\"").nth(1).unwrap().split('"').next().unwrap();
    let sheet = stranger.get(path).await;
    assert_eq!((sheet.status.as_u16(), sheet.header("content-type")), (200, "text/css"));
    assert!(sheet.header("cache-control").contains("immutable"), "{}", sheet.header("cache-control"));
    let unnamed = stranger.get("/assets/style.css").await;
    assert!(unnamed.header("cache-control").contains("no-cache"));
    let again = axum::http::Request::get(path).header("if-none-match", sheet.header("etag"));
    let again = stranger.send(again.body(axum::body::Body::empty()).unwrap()).await;
    assert_eq!((again.status.as_u16(), again.body.len()), (304, 0));
    assert_eq!(stranger.get("/assets/nothing.css").await.status, 404);
}
