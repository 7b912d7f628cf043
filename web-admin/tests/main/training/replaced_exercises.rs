//! Exercises that a school has replaced. Fails when an attempt at an earlier revision counts or certifies after the grace, or one that was
//! made in time is lost.

use model::{Moment, Role};
use platform::clock::Clock;
use time::OffsetDateTime;
use web_admin::worker;

use crate::support::App;
use crate::support::recordings::{Attempt, record};

const NOON: Moment = Moment::from_micros(1_790_000_000_000_000);
const DAY_S: i64 = 24 * 3600;

/// An attempt that began a minute before a moment.
fn attempt_at(now: Moment) -> Vec<u8> {
    let started_at = OffsetDateTime::from_unix_timestamp(now.micros() / 1_000_000 - 60).unwrap();
    record(&Attempt { started_at, ..Attempt::default() })
}

#[tokio::test]
async fn attempt_at_a_replaced_exercise_counts_only_in_its_grace() {
    let app = App::with(Clock::fixed(NOON), |_| {}).await;
    let north = app.school("North").await;
    let token = app.member(north, Role::Trainee, "ada@example.org").await.token;
    app.publish(north).await;
    let before = app.with_token(&token).upload(&attempt_at(NOON)).await;
    assert_eq!((before.status.as_u16(), &before.json()["uncounted"]), (201, &serde_json::Value::Null));
    app.publish_with_pass_mark(north, 99).await;
    let mut folder = app.folder;
    for (days, counts) in [(6, true), (8, false)] {
        let now = NOON.plus_s(days * DAY_S);
        let later = App::in_folder(folder, Clock::fixed(now), |_| {}).await;
        let told = later.with_token(&token).upload(&attempt_at(now)).await.json();
        assert_eq!(told["uncounted"].is_null(), counts, "after {days} days: {told}");
        worker::work_off_jobs(&later.state).await.unwrap();
        let path = format!("/sessions/{}", told["session_id"].as_str().unwrap());
        let page = later.signed_in("ada@example.org").await.get(&path).await.text();
        assert_eq!(page.contains("had replaced this version"), !counts, "after {days} days");
        folder = later.folder;
    }
}

#[tokio::test]
async fn an_exercise_that_is_given_again_counts_again() {
    let app = App::with(Clock::fixed(NOON), |_| {}).await;
    let north = app.school("North").await;
    let token = app.member(north, Role::Trainee, "ada@example.org").await.token;
    app.publish(north).await;
    app.publish_with_pass_mark(north, 99).await;
    app.publish(north).await;
    let now = NOON.plus_s(30 * DAY_S);
    let later = App::in_folder(app.folder, Clock::fixed(now), |_| {}).await;
    assert!(later.with_token(&token).upload(&attempt_at(now)).await.json()["uncounted"].is_null());
}
