//! Outcomes of a school and entrusted levels. Fails when somebody other than the trainee's instructor decides, when a decision changes or
//! is lost, when an import harms what is there, or when a page, the transcript and the data export show different levels.

use model::Role;
use model::ids::{CohortId, PersonId, SchoolId};
use store::training::{cohorts, outcomes};

use crate::support::App;
use crate::support::client::{Answer, Client, SentFile, csrf_in};

const PAGE: &str = "/admin/outcomes";

/// A school with a cohort, an administrator, its instructor and a trainee.
struct World {
    app: App,
    school: SchoolId,
    cohort: CohortId,
    ada: PersonId,
    head: Client,
    teacher: Client,
}

impl World {
    async fn new() -> Self {
        let app = App::new().await;
        let school = app.school("North").await;
        app.publish(school).await;
        app.member(school, Role::Administrator, "head@example.org").await;
        let teacher = app.member(school, Role::Instructor, "teacher@example.org").await.person;
        app.member(school, Role::Instructor, "colleague@example.org").await;
        let ada = app.member(school, Role::Trainee, "ada@example.org").await.person;
        app.cohort(school, "Year 4", &[&teacher, &ada]).await;
        let cohort = cohorts::list_cohorts(app.state.db.reader(), school).await.unwrap()[0].id;
        let (head, teacher) = (app.signed_in("head@example.org").await, app.signed_in("teacher@example.org").await);
        Self { app, school, cohort, ada: ada.id, head, teacher }
    }

    /// Adds an outcome to which the course leads, and returns the address of its form.
    async fn add(&mut self, code: &str) -> String {
        let csrf = csrf_in(&self.head.get(PAGE).await.text());
        let fields = [("csrf", csrf.as_str()), ("code", code), ("title", "Lumbar puncture")];
        let added = self.head.form(PAGE, &fields).await;
        assert_eq!(added.status, 303, "{}", added.text());
        let href = added.header("location").to_owned();
        let fields = [&fields[..], &[("courses", "lower-back-basics")]].concat();
        assert_eq!(self.head.form(&href, &fields).await.status, 303);
        href
    }

    /// Decides on a level of an outcome for Ada.
    async fn decide(&self, client: &mut Client, outcome: &str, level: &str) -> Answer {
        let page = format!("/trainees/{}/outcomes", self.ada);
        let csrf = csrf_in(&client.get("/account").await.text());
        let path = format!("{page}/{}", outcome.rsplit('/').next().unwrap());
        client.form(&path, &[("csrf", &csrf), ("level", level), ("note", "Ten <alone>")]).await
    }

    async fn import(&mut self, file: &str) -> Answer {
        let csrf = csrf_in(&self.head.get(PAGE).await.text());
        let file = SentFile { field: "file", name: "a.csv", bytes: file.as_bytes() };
        self.head.form_with_file(&format!("{PAGE}/file"), &[("csrf", &csrf)], file).await
    }

    async fn codes(&self) -> Vec<String> {
        let all = outcomes::list_outcomes(self.app.state.db.reader(), self.school).await.unwrap();
        all.into_iter().map(|outcome| outcome.code).collect()
    }
}

#[tokio::test]
async fn instructors_of_a_trainee_alone_decide_on_levels() {
    let mut world = World::new().await;
    let outcome = world.add("EPA 3").await;
    let mut colleague = world.app.signed_in("colleague@example.org").await;
    let mut ada = world.app.signed_in("ada@example.org").await;
    assert_eq!(world.decide(&mut colleague, &outcome, "4").await.status, 404);
    assert_eq!(world.decide(&mut ada, &outcome, "4").await.status, 403);
    let mut teacher = world.app.signed_in("teacher@example.org").await;
    for refused in ["6", "-1", "x", ""] {
        assert_eq!(world.decide(&mut teacher, &outcome, refused).await.status, 422, "{refused}");
    }
    assert_eq!(world.decide(&mut teacher, &outcome, "4").await.status, 303);
    let all: i64 =
        sqlx::query_scalar("SELECT count(*) FROM entrustments").fetch_one(world.app.state.db.reader()).await.unwrap();
    assert_eq!(all, 1);
}

#[tokio::test]
async fn pages_transcript_and_export_show_the_level_in_force() {
    let mut world = World::new().await;
    let outcome = world.add("EPA 3").await;
    let mut teacher = world.app.signed_in("teacher@example.org").await;
    let pages = [format!("/trainees/{}/outcomes", world.ada), format!("/trainees/{}/transcript", world.ada)];
    let mut ada = world.app.signed_in("ada@example.org").await;
    assert!(ada.get("/").await.text().contains(&pages[0]), "the home page leads to the outcomes");
    for (level, words) in [("2", "2 – Acts under direct supervision"), ("4", "4 – Acts without supervision")] {
        assert_eq!(world.decide(&mut teacher, &outcome, level).await.status, 303);
        for page in &pages {
            let text = ada.get(page).await.text();
            assert!(text.contains(words) && text.contains("EPA 3"), "{page}: {text}");
        }
        let cohort = world.teacher.get(&format!("/cohorts/{}/outcomes", world.cohort)).await.text();
        assert!(cohort.contains(words) && cohort.contains("0 of 7 exercises"), "{cohort}");
    }
    let text = ada.get(&pages[0]).await.text();
    assert!(text.contains("2 decisions") && text.contains("Ten &#60;alone&#62;"), "{text}");
    let export = ada.get("/account/export").await.json();
    let levels: Vec<_> = export["entrustments"].as_array().unwrap().iter().map(|one| one["level"].as_i64()).collect();
    assert_eq!(levels, [Some(2), Some(4)]);
    assert_eq!(world.decide(&mut teacher, &outcome, "0").await.status, 303);
    assert!(ada.get(&pages[0]).await.text().contains("not decided"));
    assert!(!ada.get(&pages[1]).await.text().contains("EPA 3"), "an ended entrustment is not in the transcript");
}

#[tokio::test]
async fn trainees_at_a_level_are_counted_over_time() {
    let mut world = World::new().await;
    let outcome = world.add("EPA 3").await;
    let mut teacher = world.app.signed_in("teacher@example.org").await;
    assert_eq!(world.decide(&mut teacher, &outcome, "3").await.status, 303);
    let page = format!("/cohorts/{}/outcomes", world.cohort);
    for (query, counted) in [("", 0), ("?level=3", 1), ("?level=99", 0), ("?level=0", 1)] {
        let text = teacher.get(&format!("{page}{query}")).await.text();
        assert_eq!(text.matches("1 of 1").count(), counted, "{query}: {text}");
    }
}

#[tokio::test]
async fn imports_add_and_change_and_take_nothing_away() {
    let mut world = World::new().await;
    world.add("EPA 3").await;
    let added = world.import("code,title\nEPA 1,Consent\nEPA 3,Lumbar puncture in adults\n").await;
    assert!(added.text().contains("Outcomes added: 1; changed: 1; unchanged: 0."), "{}", added.text());
    let case = r#"{"CFItems":[{"identifier":"0a1b2c3d","humanCodingScheme":"EPA 9","fullStatement":"Draws blood"}]}"#;
    assert!(world.import(case).await.text().contains("added: 1"));
    assert!(world.import(case).await.text().contains("unchanged: 1"));
    let renamed = case.replace("EPA 9", "EPA 8");
    assert!(world.import(&renamed).await.text().contains("changed: 1"), "known by its identifier");
    assert_eq!(world.codes().await, ["EPA 1", "EPA 3", "EPA 8"]);
    let taken = world.import(&case.replace("EPA 9", "EPA 1")).await;
    assert!(taken.status == 422 && taken.text().contains("another outcome has"), "{}", taken.text());
    for refused in ["", "code,title\n1,a\n1,b\n", "PK\u{3}\u{4}", "{\"CFItems\":7}"] {
        assert_eq!(world.import(refused).await.status, 422, "{refused:?}");
    }
    assert_eq!(world.codes().await, ["EPA 1", "EPA 3", "EPA 8"], "nothing of a refused file is kept");
}

#[tokio::test]
async fn levels_keep_those_that_are_entrusted() {
    let mut world = World::new().await;
    let outcome = world.add("EPA 3").await;
    let mut teacher = world.app.signed_in("teacher@example.org").await;
    assert_eq!(world.decide(&mut teacher, &outcome, "4").await.status, 303);
    let csrf = csrf_in(&world.head.get(PAGE).await.text());
    let mut set =
        async |levels| world.head.form("/admin/outcomes/levels", &[("csrf", &csrf), ("levels", levels)]).await;
    assert_eq!(set("a\nb\nc").await.status, 422, "level 4 is entrusted");
    assert_eq!(set("a\nb\nc\nAlone").await.status, 303);
    let page = teacher.get(&format!("/trainees/{}/outcomes", world.ada)).await.text();
    assert!(page.contains("4 – Alone"), "{page}");
}

#[tokio::test]
async fn decisions_never_change_and_notes_go_with_an_erased_person() {
    let mut world = World::new().await;
    let outcome = world.add("EPA 3").await;
    let mut teacher = world.app.signed_in("teacher@example.org").await;
    assert_eq!(world.decide(&mut teacher, &outcome, "4").await.status, 303);
    for refused in ["UPDATE entrustments SET level = 5", "DELETE FROM entrustments"] {
        let changed = world.app.write(async |tx| sqlx::query(refused).execute(tx).await.is_ok()).await;
        assert!(!changed, "{refused}");
    }
    let page = format!("/people/{}/erase", world.ada);
    let csrf = csrf_in(&world.head.get(&page).await.text());
    let erased = world.head.form(&page, &[("csrf", &csrf), ("confirm", "ada@example.org")]).await;
    assert_eq!(erased.status, 303, "{}", erased.text());
    let row: (i64, String) =
        sqlx::query_as("SELECT level, note FROM entrustments").fetch_one(world.app.state.db.reader()).await.unwrap();
    assert_eq!(row, (4, String::new()));
}
