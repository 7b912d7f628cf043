//! Fails when a study is changed after somebody has agreed to it, when its data are kept longer than was promised or go unannounced or by
//! a clock that was set, when what belongs to people of the school goes with it, and when a restored backup brings a guest back.

use std::time::Duration;

use acts::privacy::{erasing, retention};
use serde_json::Value;

use crate::studies::StudyDay;
use crate::support::client::Answer;

const DAY_S: i64 = 86_400;

impl StudyDay {
    /// The clock goes forward by some days, and the service looks after each of those that it has run.
    async fn live(&mut self, clock_days: i64, run_days: u32) {
        self.school.app.state.clock.advance(clock_days * DAY_S);
        for _ in 0..run_days {
            retention::tick(&self.school.app.state, Duration::from_secs(86_400)).await.unwrap();
        }
        // Nobody stays signed in for that long.
        self.teacher = self.school.app.signed_in("teacher@example.org").await;
    }

    async fn change(&mut self, fields: &[(&str, &str)]) -> Answer {
        self.post(&format!("{}/change", self.study), fields).await
    }

    async fn page(&mut self) -> String {
        self.teacher.get(&self.study.clone()).await.text()
    }

    async fn end(&mut self) {
        assert_eq!(self.post(&format!("{}/close", self.study), &[("closed", "true")]).await.status, 303);
    }
}

const LINES: [(&str, &str); 3] = [("title", "Another title"), ("contact", "ask@example.org"), ("kept", "6")];

#[tokio::test]
async fn a_study_is_changed_but_for_what_somebody_has_agreed_to() {
    let mut day = StudyDay::new().await;
    let terms =
        [("attempts", "3"), ("groups", "Students\nSurgeons"), ("consent", "I take part."), ("controller", "North")];
    let changed = day.change(&[&LINES[..], &terms[..]].concat()).await;
    assert_eq!(changed.status, 303, "{}", changed.text());
    let page = day.page().await;
    assert!(page.contains("Another title") && page.contains("Surgeons") && page.contains("ask@example.org"), "{page}");
    assert_eq!(day.change(&[("title", "")]).await.status, 422);
    let fields = [("group", "1"), ("consent", "yes")];
    assert_eq!(day.add(&fields).await.status, 200, "a code");
    let changed =
        day.change(&[("title", "A third"), ("contact", "ask@example.org"), ("kept", "6"), ("consent", "x")]).await;
    assert_eq!(changed.status, 303, "{}", changed.text());
    let page = day.page().await;
    assert!(page.contains("A third") && page.contains("I take part."), "what was agreed to stays: {page}");
    let longer = day.change(&[("title", "A third"), ("contact", "ask@example.org"), ("kept", "7")]).await;
    assert!(longer.status == 422 && longer.text().contains("at most 6"), "{}", longer.text());
}

/// A study with a guest and somebody of the school, an attempt and an answer of each.
async fn practised() -> (StudyDay, Value) {
    let mut day = StudyDay::new().await;
    let code = day.guest().await;
    let guest = day.sign_in(&code).await.json();
    let session = day.attempt(&guest["trainee"]).await;
    assert_eq!(day.answer(session, &guest["surveys"][0], "mental").await.status, 200);
    let fields = [("email", "other@example.org"), ("group", "0"), ("consent", "yes")];
    assert_eq!(day.add(&fields).await.status, 303);
    let own = "SELECT pseudonym FROM people WHERE email = 'other@example.org'";
    let own: String = sqlx::query_scalar(own).fetch_one(day.school.app.state.db.reader()).await.unwrap();
    day.attempt(&own.into()).await;
    (day, guest["trainee"].clone())
}

const ANSWERS: &str = "SELECT count(*) FROM survey_responses WHERE answers <> '[]'";

#[tokio::test]
async fn study_data_are_erased_on_time_and_school_data_stay() {
    let (mut day, guest) = practised().await;
    let files = day.school.app.files().len();
    day.live(400, 1).await;
    assert!(!day.page().await.contains("will be erased in"), "it has not ended");
    day.end().await;
    day.live(330, 1).await;
    assert!(!day.page().await.contains("will be erased in"), "not soon");
    day.live(20, 1).await;
    assert!(day.page().await.contains("will be erased in 30 days"), "{}", day.page().await);
    day.live(29, 29).await;
    assert!(day.page().await.contains("will be erased in 1 day") && day.count(ANSWERS).await == 1);
    day.live(2, 2).await;
    let page = day.page().await;
    assert!(page.contains("were erased on") && !page.contains("surgeon") && !page.contains("/change\""), "{page}");
    assert_eq!(day.count(ANSWERS).await, 0);
    assert_eq!(day.school.app.files().len(), files - 1, "the guest's recording is gone, the other stays");
    let erased = "SELECT count(*) FROM people WHERE role = 'guest' AND erased_at IS NOT NULL";
    assert_eq!((day.count(erased).await, day.count("SELECT count(*) FROM sessions").await), (1, 2));
    assert_eq!(day.count("SELECT count(*) FROM people WHERE email = 'other@example.org'").await, 1);
    assert_eq!(day.post(&format!("{}/close", day.study), &[("closed", "false")]).await.status, 409);
    let log = "SELECT count(*) FROM audit_log WHERE action IN ('study.erasure_announced', 'study.erased')";
    assert_eq!(day.count(log).await, 2);

    // As a restored backup would: the guest is here again, and the list that outlives it knows better.
    let mut tx = day.school.app.state.db.write().await.unwrap();
    sqlx::raw_sql("UPDATE people SET erased_at = NULL WHERE role = 'guest'").execute(&mut *tx).await.unwrap();
    tx.commit().await.unwrap();
    assert_eq!(erasing::catch_up(&day.school.app.state).await.unwrap(), 1, "{guest}");
    assert_eq!(day.count(erased).await, 1);
}

#[tokio::test]
async fn no_clock_and_no_study_that_is_opened_again_loses_anything() {
    let (mut day, _) = practised().await;
    day.end().await;
    day.live(4000, 1).await;
    assert!(day.page().await.contains("will be erased in 30 days"), "announced, however late");
    day.live(4000, 3).await;
    assert!(day.page().await.contains("will be erased in 27 days"), "the service has run for three days");
    let opened = day.post(&format!("{}/close", day.study), &[("closed", "false")]).await;
    assert_eq!(opened.status, 303);
    day.live(60, 60).await;
    assert_eq!(day.count(ANSWERS).await, 1);
    assert!(!day.page().await.contains("will be erased in"));
}
