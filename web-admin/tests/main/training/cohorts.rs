//! A cohort through the front door, as large as a year of students. Fails when a roster by itself calls for help, when somebody of a
//! long list cannot be reached, or when a page grows with the cohort.

use model::ids::{CohortId, SchoolId};
use model::{Moment, Role};
use platform::clock::Clock;
use store::people::{self, NewPerson};
use store::training::cohorts;
use store::training::cohorts::{Attribution, Membership};

use crate::support::App;
use crate::support::client::{Client, csrf_in};

/// 2026-03-01 00:00 UTC.
const NOW: Moment = Moment::from_micros(1_772_323_200_000_000);
/// Trainees of the cohort.
const MANY: usize = 120;
/// What a page of fifty people may come to, in bytes.
const LARGEST_PAGE: usize = 100_000;

struct World {
    app: App,
    cohort: CohortId,
    teacher: Client,
}

/// A school whose cohort has just been filled from a roster.
async fn large_cohort() -> World {
    let app = App::with(Clock::fixed(NOW), |_| {}).await;
    let school = app.school("North").await;
    app.publish(school).await;
    let teacher = app.member(school, Role::Instructor, "teacher@example.org").await;
    app.cohort(school, "Year 4", &[&teacher.person]).await;
    let cohort = cohorts::list_cohorts(app.state.db.reader(), school).await.unwrap()[0].id;
    fill(&app, school, cohort).await;
    let teacher = app.signed_in("teacher@example.org").await;
    World { app, cohort, teacher }
}

async fn fill(app: &App, school: SchoolId, cohort: CohortId) {
    let now = app.state.clock.now();
    app.write(async |tx| {
        for n in 0..MANY {
            let (email, name) = (format!("t{n}@example.org"), format!("Trainee {n:03}"));
            let new = NewPerson {
                school_id: school,
                role: Role::Trainee,
                email: &email,
                display_name: &name,
                password_hash: "!",
            };
            let person = people::add_person(tx, &new, now).await.unwrap();
            let membership =
                Membership { school_id: school, cohort_id: cohort, person_id: person.id, role: Role::Trainee };
            cohorts::join_cohort(tx, membership, Attribution { by: None, at: now }).await.unwrap();
        }
    })
    .await;
}

#[tokio::test]
async fn a_roster_alone_calls_for_no_help_and_what_is_due_does() {
    let World { app, cohort, mut teacher } = large_cohort().await;
    let page = teacher.get(&format!("/cohorts/{cohort}")).await.text();
    assert!(page.contains("Nobody right now"), "{page}");
    assert!(teacher.get("/").await.text().contains("Nobody needs help"));
    let csrf = csrf_in(&teacher.get("/assignments").await.text());
    let cohort_id = cohort.to_string();
    let fields = [
        ("csrf", csrf.as_str()),
        ("task", "exercise:feel-the-layers"),
        ("cohort", &cohort_id),
        ("due", "2026-03-20T12:00"),
    ];
    assert_eq!(teacher.form("/assignments", &fields).await.status, 303);
    assert!(teacher.get(&format!("/cohorts/{cohort}")).await.text().contains("Nobody right now"), "due in weeks");
    app.state.clock.advance(14 * 86_400);
    let mut teacher = app.signed_in("teacher@example.org").await;
    let page = teacher.get(&format!("/cohorts/{cohort}")).await.text();
    for said in ["108 more people need help", "no attempt at “Feel the layers”, due 20 Mar 2026", "Trainee 000"] {
        assert!(page.contains(said), "{said} is not in {page}");
    }
    let home = teacher.get("/").await.text();
    assert!(home.contains("120 need help") && home.contains("108 more people need help"), "{home}");
    let help = teacher.get(&format!("/at-risk?cohort={cohort}&page=3")).await.text();
    assert!(help.contains("Trainee 119") && help.contains("Page 3 of 3"), "{help}");
}

#[tokio::test]
async fn long_lists_have_pages_and_are_searched() {
    let World { app: _app, cohort, mut teacher } = large_cohort().await;
    let csrf = csrf_in(&teacher.get("/assignments").await.text());
    let cohort_id = cohort.to_string();
    let fields = [("csrf", csrf.as_str()), ("task", "exercise:feel-the-layers"), ("cohort", &cohort_id)];
    let assignment = teacher.form("/assignments", &fields).await.header("location").to_owned();
    let cohort = format!("/cohorts/{cohort}");
    for path in [cohort.clone(), format!("{cohort}/people"), format!("{cohort}/gradebook"), assignment] {
        let first = teacher.get(&path).await.text();
        assert!(first.len() < LARGEST_PAGE, "{path}: {} bytes", first.len());
        assert!(first.contains("Trainee 003") && !first.contains("Trainee 110"), "{path}: {first}");
        assert!(first.contains("Page 1 of 3"), "{path}: {first}");
        let last = teacher.get(&format!("{path}?page=3")).await.text();
        assert!(last.contains("Trainee 119") && !last.contains("Trainee 003"), "{path}: {last}");
        let found = teacher.get(&format!("{path}?q=trainee+110")).await.text();
        assert!(found.contains("Trainee 110") && !found.contains("Trainee 003"), "{path}: {found}");
    }
    let file = teacher.get(&format!("{cohort}/gradebook.csv")).await.text();
    assert_eq!(file.lines().count(), MANY + 1, "the file has everybody");
}
