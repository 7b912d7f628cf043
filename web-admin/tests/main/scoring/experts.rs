//! Experts' consent, through the front door. Fails when it is recorded by somebody else than an administrator, without its
//! words, or for the future; when what was recorded is lost; and when an attempt is in the corridor without a consent.

use model::Role;
use model::ids::SessionId;
use web_admin::worker;

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member};

const GOOD: [(&str, &str); 3] =
    [("wording", "My attempts may be shown."), ("how", "on paper"), ("given", "2026-01-05")];

async fn send(browser: &mut Client, path: &str, fields: &[(&str, &str)]) -> Answer {
    let csrf = csrf_in(&browser.get("/").await.text());
    let fields: Vec<_> = fields.iter().copied().chain([("csrf", csrf.as_str())]).collect();
    browser.form(path, &fields).await
}

/// An attempt that counts as passed, whatever it scored.
async fn passed(app: &App, member: &Member) -> SessionId {
    let attempt = Attempt { session_id: SessionId::random(), ..Attempt::default() };
    assert_eq!(app.with_token(&member.token).upload(&record(&attempt)).await.status, 201);
    worker::work_off_jobs(&app.state).await.unwrap();
    let grade = sqlx::query("UPDATE grades SET passed = TRUE WHERE session_id = $1").bind(attempt.session_id);
    app.write(async |tx| grade.execute(tx).await.unwrap()).await;
    attempt.session_id
}

#[tokio::test]
async fn the_corridor_shows_while_five_consents_stand() {
    let app = App::new().await;
    let north = app.school("North").await;
    app.publish(north).await;
    let ada = app.member(north, Role::Trainee, "ada@example.org").await;
    app.member(north, Role::Administrator, "head@example.org").await;
    let mut head = app.signed_in("head@example.org").await;
    let shown = passed(&app, &ada).await;
    let replay = format!("/sessions/{shown}/replay");
    let mut last = String::new();
    for n in 0..5 {
        assert!(!head.get(&replay).await.text().contains("Compared with the experts"), "with {n}");
        let expert = app.member(north, Role::Instructor, &format!("expert{n}@example.org")).await;
        passed(&app, &expert).await;
        last = format!("/people/{}/consent", expert.person.id);
        assert_eq!(send(&mut head, &last, &GOOD).await.status, 303);
    }
    assert!(head.get(&replay).await.text().contains("Compared with the experts"));
    assert_eq!(send(&mut head, &format!("{last}/withdraw"), &[]).await.status, 303);
    assert!(!head.get(&replay).await.text().contains("Compared with the experts"), "four are left");
}

#[tokio::test]
async fn a_consent_keeps_its_words_and_its_history() {
    let app = App::new().await;
    let north = app.school("North").await;
    let expert = app.member(north, Role::Instructor, "expert@example.org").await;
    let ada = app.member(north, Role::Trainee, "ada@example.org").await;
    app.member(north, Role::Administrator, "head@example.org").await;
    let mut head = app.signed_in("head@example.org").await;
    let path = format!("/people/{}/consent", expert.person.id);
    for (field, value) in [("wording", " "), ("how", ""), ("given", "2126-01-05"), ("given", "yesterday")] {
        let fields: Vec<_> = GOOD.iter().copied().filter(|(name, _)| *name != field).chain([(field, value)]).collect();
        let refused = send(&mut head, &path, &fields).await;
        assert_eq!(refused.status, 422, "{field}={value}");
        let page = refused.text();
        assert!(page.contains("role=\"alert\"") && (field == "how" || page.contains("on paper")), "{page}");
    }
    assert_eq!(send(&mut head, &path, &GOOD).await.status, 303);
    assert_eq!(send(&mut head, &path, &GOOD).await.status, 409, "one stands already");
    let page = head.get(&path).await.text();
    assert!(page.contains("My attempts may be shown.") && page.contains("Record the withdrawal"), "{page}");
    assert_eq!(send(&mut head, &format!("{path}/withdraw"), &[]).await.status, 303);
    assert_eq!(send(&mut head, &path, &GOOD).await.status, 303, "and given once more");
    let page = head.get(&path).await.text();
    assert_eq!(page.matches("data-label=\"Text\"").count(), 2, "{page}");
    assert_eq!(head.get(&format!("/people/{}/consent", ada.person.id)).await.status, 409, "a trainee is no expert");
    let acts = "SELECT action FROM audit_log WHERE object = $1 AND action LIKE 'expert.%' ORDER BY seq";
    let acts: Vec<String> =
        sqlx::query_scalar(acts).bind(expert.person.id.to_string()).fetch_all(app.state.db.reader()).await.unwrap();
    assert_eq!(acts, ["expert.consented", "expert.consent_withdrawn", "expert.consented"]);
}
