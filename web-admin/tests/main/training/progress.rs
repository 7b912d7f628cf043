//! What the progress pages say is what was scored: sums, curves, exports, and a course judged by a learning curve. Fails
//! when a sum and the scores part, when an export holds other rows than its page, or when a name becomes a formula.

use std::path::Path;

use acts::authoring::publishing;
use model::ids::{SchoolId, SessionId};
use model::{CurrentPerson, Role, SessionKey};
use store::scoring::scores;
use store::training::{practice, tallies};
use web_admin::worker;

use crate::support::client::without_csrf;
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member};

/// A school with a cohort of one trainee, who has made three scored attempts.
async fn practised() -> (App, SchoolId, Member, Vec<Attempt>) {
    let app = App::new().await;
    let school = app.school("North").await;
    app.publish(school).await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    let teacher = app.member(school, Role::Instructor, "teacher@example.org").await;
    app.member(school, Role::Administrator, "head@example.org").await;
    app.cohort(school, "=Spring", &[&ada.person, &teacher.person]).await;
    let attempts: Vec<_> = (0..3).map(|_| Attempt::default()).collect();
    for attempt in &attempts {
        assert_eq!(app.with_token(&ada.token).upload(&record(attempt)).await.status, 201);
    }
    worker::work_off_jobs(&app.state).await.unwrap();
    (app, school, ada, attempts)
}

#[tokio::test]
async fn sums_are_those_of_the_scores_and_stay_so_when_made_again() {
    let (app, school, ada, attempts) = practised().await;
    let reader = app.state.db.reader();
    let mut points = 0.0;
    for attempt in &attempts {
        let key = SessionKey { school_id: school, id: attempt.session_id };
        points += scores::find_newest_score(reader, key).await.unwrap().unwrap().score;
        app.write(async |tx| practice::refresh_practice(tx, key).await.unwrap()).await;
    }
    let administrator = CurrentPerson { role: Role::Administrator, ..ada.person.clone().into_current().unwrap() };
    let kept = practice::list_trainee_practice(reader, school, ada.person.id).await.unwrap();
    assert_eq!(kept.len(), 3);
    assert!((kept.iter().map(|attempt| attempt.score).sum::<f64>() - points).abs() < 1e-9);
    let months = tallies::list_tallies_by_month(reader, &administrator).await.unwrap();
    assert_eq!(months.iter().map(|(_, sums)| sums.attempts).sum::<i64>(), 3, "nothing is counted twice");
    let year = months[0].0.div_euclid(12);
    let cohorts = tallies::list_tallies_in_year(reader, &administrator, year, "", 10).await.unwrap();
    assert!(cohorts.len() == 1 && cohorts[0].sums.attempts == 3 && (cohorts[0].sums.points - points).abs() < 1e-9);
    let all = tallies::list_school_tallies_in_year(reader, school, year).await.unwrap();
    assert_eq!(all, cohorts, "the file has what the pages show");
    assert_eq!(tallies::list_tallies_in_year(reader, &administrator, year, &cohorts[0].cohort, 10).await.unwrap(), []);
    assert_eq!(tallies::list_tallies_in_year(reader, &administrator, year + 1, "", 10).await.unwrap(), []);
}

#[tokio::test]
async fn teacher_compares_own_cohorts_in_the_schools_time_zone() {
    let app = App::new().await;
    let school = app.school("North").await;
    app.publish(school).await;
    app.keep_time_zone(school, "Europe/Berlin").await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    let teacher = app.member(school, Role::Instructor, "teacher@example.org").await;
    app.cohort(school, "Mine", &[&ada.person, &teacher.person]).await;
    let bo = app.member(school, Role::Trainee, "bo@example.org").await;
    app.cohort(school, "Another's", &[&bo.person]).await;
    for member in [&ada, &bo] {
        let attempt = Attempt { session_id: SessionId::random(), ..Attempt::default() };
        assert_eq!(app.with_token(&member.token).upload(&record(&attempt)).await.status, 201);
    }
    worker::work_off_jobs(&app.state).await.unwrap();
    let page = app.signed_in("teacher@example.org").await.get("/progress").await.text();
    assert!(page.contains("Mine") && !page.contains("Another"), "{page}");
    assert!(page.contains("Compare cohorts") && page.contains("All times: local time in Europe/Berlin."), "{page}");
    let file = app.signed_in("teacher@example.org").await.get("/progress.csv").await.text();
    assert!(file.lines().count() == 2 && file.contains(",Mine,1,"), "{file}");
}

#[tokio::test]
async fn a_page_and_its_file_tell_the_same() {
    let (app, _, ada, attempts) = practised().await;
    let mut teacher = app.signed_in("teacher@example.org").await;
    let home = teacher.get(&format!("/trainees/{}", ada.person.id)).await;
    let curve = home.link(&format!("/trainees/{}/exercises/", ada.person.id));
    let page = teacher.get(&curve).await;
    let file = teacher.get(&format!("{curve}/attempts.csv")).await;
    assert_eq!((page.status.as_u16(), file.status.as_u16()), (200, 200));
    assert_eq!(file.header("content-type"), "text/csv; charset=utf-8");
    assert_eq!(file.text().lines().count(), 1 + attempts.len());
    for attempt in &attempts {
        let id = attempt.session_id.to_string();
        assert!(page.text().contains(&id) && file.text().contains(&id));
    }
    assert!(page.text().contains("A stricter statistical test"), "folded, for those who teach: {}", page.text());
    let own = app.signed_in("ada@example.org").await.get(&curve).await.text();
    assert!(own.contains("passes within") && !own.contains("statistical test"), "what decides nothing: {own}");
}

#[tokio::test]
async fn a_cohort_sees_its_map_and_a_name_stays_a_name() {
    let (app, _, ada, attempts) = practised().await;
    let mut teacher = app.signed_in("teacher@example.org").await;
    let cohort = teacher.get("/cohorts").await.link("/cohorts/");
    let map = teacher.get(&format!("{cohort}/progress")).await;
    let day =
        practice::list_trainee_practice(app.state.db.reader(), ada.person.school_id, ada.person.id).await.unwrap()[0]
            .at
            .date();
    let opened = teacher.get(&format!("{cohort}/progress?day={day}")).await.text();
    for attempt in &attempts {
        let href = format!("/sessions/{}", attempt.session_id);
        assert!(opened.contains(&href) && !map.text().contains(&href), "a day opens its attempts: {opened}");
    }
    let empty = teacher.get(&format!("{cohort}/progress?day=1999-12-31")).await.text();
    assert!(empty.contains("No trainee of this cohort has a scored attempt on this day"), "{empty}");
    let none = teacher.get(&format!("{cohort}/progress?day=tomorrow")).await.text();
    assert_eq!(without_csrf(&none), without_csrf(&map.text()), "no day at all");
    assert!(map.text().contains(&format!("/trainees/{}/exercises/", ada.person.id)), "{}", map.text());
    let metrics = teacher.get(&map.link(&format!("{cohort}/exercises/"))).await;
    assert_eq!(metrics.status, 200);
    let mut head = app.signed_in("head@example.org").await;
    assert!(head.get("/progress").await.text().contains("=Spring"));
    assert!(head.get("/progress.csv").await.text().contains("'=Spring"), "no formula");
    let other = head.get("/progress?year=1999").await;
    assert!(other.status == 200 && !other.text().contains("=Spring"), "{}", other.text());
}

#[tokio::test]
async fn a_course_may_be_judged_by_a_learning_curve() {
    let app = App::new().await;
    let school = app.school("North").await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    let course = Path::new(env!("CARGO_MANIFEST_DIR")).join("../curricula/lumbar-epidural/course.toml");
    let now = app.state.clock.now();
    app.write(async |tx| publishing::course(tx, school, &course, now).await.unwrap()).await;
    let due = app.with_token(&ada.token).get("/api/v1/me/assignments").await.json();
    let first = &due["assignments"][0];
    assert_eq!((&first["standing"], &first["passes"]), (&"not_yet".into(), &0.into()), "{due}");
    assert!(first["passes_needed"].as_u64().unwrap() > 5, "{due}");
    let page = app.signed_in("ada@example.org").await.get("/").await;
    assert!(page.text().contains("the learning curve shows at most"), "{}", page.text());
}
