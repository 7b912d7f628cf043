//! How long the heavy pages take on a full database. Ignored by default, for it only means something in release:
//! `cargo test --release -p web-admin -- --ignored --nocapture pages_are_served`. Fails when a median passes 20 ms.

use std::time::{Duration, Instant};

use assessment::Assessment;
use uuid::Uuid;
use web_admin::domain::{Moment, Role};
use web_admin::storage::practice;
use web_admin::storage::scores::{self, SessionKey};
use web_admin::storage::sessions::{self, Session, Verified};
use web_admin::worker;

use super::support::client::Client;
use super::support::recordings::{Attempt, record};
use super::support::{App, Member};

const EXERCISES: [&str; 4] = ["feel-the-layers", "stop-in-the-fat", "reach-the-muscle", "thicker-needle"];
const TRAINEES: usize = 30;
const REPEATS: usize = 41;
const BAR: Duration = Duration::from_millis(20);

/// A cohort of thirty, and one attempt that was really made and scored.
struct School {
    app: App,
    trainees: Vec<Member>,
    first: Uuid,
}

impl School {
    async fn new() -> Self {
        let app = App::new().await;
        let school = app.school("North").await;
        app.publish(school).await;
        let teacher = app.member(school, Role::Instructor, "teacher@example.org").await;
        let mut trainees = Vec::new();
        for i in 0..TRAINEES {
            trainees.push(app.member(school, Role::Trainee, &format!("trainee{i}@example.org")).await);
        }
        let people: Vec<_> = trainees.iter().map(|t| &t.person).chain([&teacher.person]).collect();
        app.cohort(school, "Spring", &people).await;
        let attempt = Attempt::default();
        assert_eq!(app.with_token(&trainees[0].token).upload(&record(&attempt)).await.status, 201);
        worker::work_off(&app.state).await.unwrap();
        Self { app, trainees, first: attempt.session_id }
    }

    /// Copies the first attempt until the database holds `attempts`, with everything that hangs on it.
    async fn fill(&self, attempts: usize) {
        let reader = self.app.state.db.reader();
        let school_id = self.trainees[0].person.school_id;
        let session = sessions::find(reader, school_id, self.first).await.unwrap().unwrap();
        let key = SessionKey { school_id, id: self.first };
        let curve = scores::curve(reader, key).await.unwrap().unwrap();
        let mut browser = self.app.with_token(&self.trainees[0].token);
        let score = browser.get(&format!("/api/v1/sessions/{}/score", self.first)).await.json();
        let assessment: Assessment = serde_json::from_value(score).unwrap();
        let mut tx = self.app.state.db.write().await.unwrap();
        for i in 1..attempts {
            let copy = self.copy(&session, i);
            let key = SessionKey { school_id, id: copy.id };
            let passed = i % 3 != 0;
            let assessment = Assessment { passed, score: if passed { 82.0 } else { 44.0 }, ..assessment.clone() };
            sessions::insert(&mut tx, &copy).await.unwrap();
            scores::add(&mut tx, key, &assessment, copy.received_at).await.unwrap();
            scores::put_curve(&mut tx, key, &curve).await.unwrap();
            let verified = Verified { deviation_n: 0.0, event_differences: 0, exact: true };
            sessions::mark_scored(&mut tx, school_id, copy.id, verified).await.unwrap();
            practice::refresh(&mut tx, key).await.unwrap();
        }
        tx.commit().await.unwrap();
    }

    fn copy(&self, session: &Session, i: usize) -> Session {
        let (trainee, nth) = (i % TRAINEES, i / TRAINEES);
        let hours = i64::try_from(nth).unwrap() * 5;
        let at = Moment::from_micros(session.started_at.micros()).plus_s(hours * 3600);
        Session {
            id: Uuid::new_v4(),
            trainee_id: self.trainees[trainee].person.id,
            exercise_id: EXERCISES[(nth / 9) % EXERCISES.len()].to_owned(),
            started_at: at,
            received_at: at,
            ..session.clone()
        }
    }

    /// Median time in the router, and how large the page is.
    async fn median(&self, browser: &Client, path: &str) -> (Duration, usize) {
        let mut browser = browser.clone();
        let mut times = Vec::new();
        let mut bytes = 0;
        for _ in 0..REPEATS {
            #[expect(clippy::disallowed_methods, reason = "this test measures")]
            let start = Instant::now();
            let answer = browser.get(path).await;
            times.push(start.elapsed());
            assert_eq!(answer.status, 200, "{path}");
            bytes = answer.body.len();
        }
        times.sort();
        (times[REPEATS / 2], bytes)
    }
}

#[expect(clippy::print_stdout, reason = "this test tells what it measured")]
fn report(attempts: usize, name: &str, (median, bytes): (Duration, usize)) {
    println!("{attempts:6} attempts  {name:18} {:6.2} ms  {:4} kB", median.as_secs_f64() * 1e3, bytes / 1000);
}

async fn measure(attempts: usize) -> Vec<(&'static str, Duration)> {
    let school = School::new().await;
    school.fill(attempts).await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let trainee = school.app.signed_in("trainee0@example.org").await;
    let cohort = teacher.get("/cohorts").await.link("/cohorts/");
    let session = format!("/sessions/{}", school.first);
    let mut medians = Vec::new();
    for (name, browser, path) in [
        ("session", &trainee, session.as_str()),
        ("trainee's home", &trainee, "/"),
        ("exercise", &trainee, "/exercises/feel-the-layers"),
        ("cohort of 30", &teacher, cohort.as_str()),
        ("instructor's home", &teacher, "/"),
    ] {
        let (median, bytes) = school.median(browser, path).await;
        report(attempts, name, (median, bytes));
        medians.push((name, median));
    }
    medians
}

#[tokio::test]
#[ignore = "a measurement, in release: cargo test --release -p web-admin -- --ignored --nocapture pages_are_served"]
async fn pages_are_served_within_20_ms_with_1_000_attempts() {
    for (name, median) in measure(1_000).await {
        assert!(median <= BAR, "{name}: {median:?}");
    }
}

#[tokio::test]
#[ignore = "a measurement beyond the bar, printed and not judged"]
async fn pages_with_30_000_attempts() {
    measure(30_000).await;
}
