//! The generated crowd that pages are measured on, and lists of the latest attempts in it. Fails when what is generated is not
//! what the service itself would have written, so that a measurement would be of something else, and when somebody is shown
//! other attempts than the latest of those whom they teach.

use std::time::Duration;

use axum::http::HeaderValue;
use model::{CurrentPerson, Moment, Role};
use store::operations::fixtures;
use store::operations::fixtures::GeneratedCrowd;
use store::training::{practice, reports, tallies};
use web_admin::worker;

use crate::support::App;
use crate::support::recordings::{Attempt, record};

const TRAINEES: u32 = 70;
const EACH: u32 = 4;

/// A school with an administrator and a crowd: cohorts of ten, four for each of two instructors.
pub async fn crowded() -> App {
    let app = App::new().await;
    let school_id = app.school("North").await;
    app.publish(school_id).await;
    app.member(school_id, Role::Administrator, "admin@north.example").await;
    let trainee = app.member(school_id, Role::Trainee, "trainee@north.example").await;
    let model = Attempt::default();
    assert_eq!(app.with_token(&trainee.token).upload(&record(&model)).await.status, 201);
    worker::work_off_jobs(&app.state).await.unwrap();
    let password_hash =
        platform::secret::hash_password(crate::support::PASSWORD, app.state.config.password_cost).unwrap();
    let crowd = GeneratedCrowd {
        school_id,
        trainees: TRAINEES,
        cohort_size: 10,
        attempts_each: EACH,
        password_hash: &password_hash,
        from_us: Moment::from_micros(1_700_000_000_000_000).micros(),
        every_us: 30 * 86_400_000_000,
        model: model.session_id,
    };
    app.write(async |tx| fixtures::found(tx, &crowd).await.unwrap()).await;
    for places in [0..40, 40..TRAINEES] {
        app.write(async |tx| fixtures::practise(tx, &crowd, places).await.unwrap()).await;
    }
    app.write(async |tx| fixtures::conclude(tx, &crowd).await.unwrap()).await;
    app
}

#[tokio::test]
async fn a_crowd_is_what_the_service_would_have_written() {
    let app = crowded().await;
    let reader = app.state.db.reader();
    assert_eq!(app.state.db.integrity().await.unwrap(), Vec::<String>::new());
    let instructor = store::people::find_person_by_email(reader, &fixtures::instructor_email(1)).await.unwrap();
    let instructor = instructor.unwrap().into_current().unwrap();
    let taught = reports::cohorts(reader, &instructor).await.unwrap();
    assert_eq!(taught.len(), 3, "the second instructor has what the first leaves of seven cohorts");
    for cohort in &taught {
        let attempts = practice::list_cohort_practice(reader, instructor.school_id, cohort.id).await.unwrap();
        assert_eq!(attempts.values().map(Vec::len).sum::<usize>(), 10 * EACH as usize, "{}", cohort.name);
    }
    let administrator = CurrentPerson { role: Role::Administrator, ..instructor };
    let months = tallies::list_tallies_by_month(reader, &administrator).await.unwrap();
    let all: i64 = months.iter().map(|(_, sums)| sums.attempts).sum();
    assert_eq!(all, i64::from(TRAINEES * EACH) + 1, "the crowd's and the one that was really made");
}

#[tokio::test]
async fn teacher_sees_the_latest_attempts_of_their_own_trainees() {
    let app = crowded().await;
    let reader = app.state.db.reader();
    let instructor = store::people::find_person_by_email(reader, &fixtures::instructor_email(0)).await.unwrap();
    let instructor = instructor.unwrap().into_current().unwrap();
    let mut own = Vec::new();
    for cohort in reports::cohorts(reader, &instructor).await.unwrap() {
        own.extend(
            practice::list_cohort_practice(reader, instructor.school_id, cohort.id)
                .await
                .unwrap()
                .into_values()
                .flatten(),
        );
    }
    own.sort_by_key(|attempt| std::cmp::Reverse(attempt.at));
    let latest = reports::latest_taught(reader, &instructor).await.unwrap();
    let times =
        |attempts: &[reports::ListedAttempt]| -> Vec<_> { attempts.iter().map(|a| a.started_at.to_utc()).collect() };
    assert_eq!(times(&latest), own[..10].iter().map(|attempt| attempt.at).collect::<Vec<_>>());
    let exercise = own[0].exercise.clone();
    let at_it = own.iter().filter(|attempt| attempt.exercise == exercise).take(25);
    let listed = reports::latest_at(reader, &instructor, &exercise).await.unwrap();
    assert_eq!(times(&listed), at_it.map(|attempt| attempt.at).collect::<Vec<_>>());
}

#[tokio::test]
async fn the_pages_of_a_crowd_are_shown() {
    let app = crowded().await;
    for (email, paths) in [
        ("admin@north.example".to_owned(), &["/", "/cohorts", "/review", "/progress", "/people", "/assignments"][..]),
        (fixtures::instructor_email(0), &["/", "/review", "/assignments", "/exercises/feel-the-layers"]),
        (fixtures::trainee_email(5), &["/", "/assignments", "/exercises/feel-the-layers"]),
    ] {
        let mut browser = app.signed_in(&email).await;
        for path in paths {
            let page = browser.get(path).await;
            assert_eq!(page.status, 200, "{email} {path}: {}", page.text());
        }
    }
    let mut metrics = app.stranger();
    let metrics = metrics.get("/metrics").await.text();
    assert!(metrics.contains(&format!("stylet_sessions{{state=\"scored\"}} {}\n", TRAINEES * EACH + 1)), "{metrics}");
}

#[tokio::test]
async fn a_school_has_one_file_of_all_attempts_written_at_a_time() {
    let app = App::new().await;
    let (north, south) = (app.school("North").await, app.school("South").await);
    let admins =
        [north, south].map(|school| (school, if school == north { "a@north.example" } else { "a@south.example" }));
    let mut browsers = Vec::new();
    for (school, email) in admins {
        app.member(school, Role::Administrator, email).await;
        browsers.push(app.signed_in(email).await);
    }
    let held = app.state.exports.enter(north, Duration::ZERO).await;
    assert!(held.is_ok());
    assert_eq!(browsers[1].get("/progress/attempts.csv").await.status, 200, "another school has its own line");
    let refused = browsers[0].get("/progress/attempts.csv").await;
    assert_eq!((refused.status.as_u16(), &refused.headers["retry-after"]), (503, &HeaderValue::from(5)));
    drop(held);
    assert_eq!(browsers[0].get("/progress/attempts.csv").await.status, 200);
}

#[tokio::test]
async fn every_attempt_is_in_the_export_and_on_one_page_of_the_list() {
    let app = crowded().await;
    let all = (TRAINEES * EACH + 1) as usize;
    let mut admin = app.signed_in("admin@north.example").await;
    let file = admin.get("/progress/attempts.csv").await;
    assert_eq!(file.status, 200);
    let mut reader = csv::Reader::from_reader(file.body.as_slice());
    let exported: Vec<String> = reader.records().map(|row| row.unwrap()[0].to_owned()).collect();
    let mut listed = Vec::new();
    let mut address = "/api/v1/sessions".to_owned();
    loop {
        let page = admin.get(&address).await.json();
        let sessions = page["sessions"].as_array().unwrap().iter();
        listed.extend(sessions.map(|session| session["session_id"].as_str().unwrap().to_owned()));
        let Some(next) = page["next"].as_str() else { break };
        address = format!("/api/v1/sessions?after={next}");
    }
    assert_eq!(exported.len(), all);
    assert_eq!(listed, exported, "newest first, each once");
    let mut instructor = app.signed_in(&fixtures::instructor_email(0)).await;
    assert_eq!(instructor.get("/progress/attempts.csv").await.status, 403);
    let first = instructor.get("/api/v1/sessions?limit=70").await.json();
    let second = instructor.get(&format!("/api/v1/sessions?after={}", first["next"].as_str().unwrap())).await.json();
    let ids = |page: &serde_json::Value| {
        let sessions = page["sessions"].as_array().unwrap().iter();
        sessions.map(|session| session["session_id"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let taught = [ids(&first), ids(&second)].concat();
    assert_eq!(taught.len(), 4 * 10 * EACH as usize, "four cohorts of ten");
    let visible: Vec<&String> = listed.iter().filter(|id| taught.contains(id)).collect();
    assert!(taught.iter().eq(visible), "in the order of the whole list");
}
