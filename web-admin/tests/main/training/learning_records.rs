//! Statements for a learning record store. Fails when one leaves without consent or ground, when the store gets a statement twice with different
//! content or misses one after failures, or when a withdrawn consent or an erasure lets what waits leave.

use acts::privacy::erasing;
use acts::privacy::erasing::Eraser;
use acts::privacy::erasures::ErasureScope;
use acts::training::learning_records::sending;
use model::ids::{SchoolId, SessionId};
use platform::outgoing::OutgoingRules;
use serde_json::Value;
use store::audit::Actor;
use store::people::directory;
use web_admin::worker;

use super::certificates::school_with;
use crate::support::client::{Answer, Client, csrf_in};
use crate::support::record_store::TestRecordStore;
use crate::support::recordings::{Attempt, FORGED, record};
use crate::support::{App, Member};

const ADMIN: &str = "/admin/learning-records";
const OWN: &str = "/account/learning-records";
const GROUND: (&str, &str) = ("ground", "Art. 6 (1) e GDPR");

/// A school with a learning record store, and a trainee.
struct World {
    app: App,
    ada: Member,
    records: TestRecordStore,
    head: Client,
}

impl World {
    /// With changes to the form of the store.
    async fn with(changes: &[(&str, &str)]) -> Self {
        let records = TestRecordStore::start().await;
        let plain_http = vec![records.address.clone()];
        let rules = OutgoingRules { plain_http, private_addresses: true };
        let (app, ada) = school_with(|config| config.outgoing = rules).await;
        let head = app.signed_in("head@example.org").await;
        let mut world = Self { app, ada, records, head };
        let set = world.set(changes).await;
        assert_eq!(set.status, 303, "{}", set.text());
        world
    }

    fn school(&self) -> SchoolId {
        self.ada.person.school_id
    }

    async fn set(&mut self, changes: &[(&str, &str)]) -> Answer {
        let csrf = csrf_in(&self.head.get(ADMIN).await.text());
        let endpoint = self.records.endpoint();
        let mut form = vec![
            ("csrf", csrf.as_str()),
            ("endpoint", &endpoint),
            ("user_name", "stylet"),
            ("password", "a secret"),
            ("version", "2.0.0"),
        ];
        form.retain(|(name, _)| changes.iter().all(|(changed, _)| changed != name));
        form.extend(changes);
        self.head.form(ADMIN, &form).await
    }

    /// The page of the store, in a new session of the administrator.
    async fn page(&mut self) -> String {
        self.head = self.app.signed_in("head@example.org").await;
        self.head.get(ADMIN).await.text()
    }

    async fn act(&mut self, act: &str) {
        let csrf = csrf_in(&self.head.get(ADMIN).await.text());
        let done = self.head.form(&format!("{ADMIN}/{act}"), &[("csrf", &csrf)]).await;
        assert_eq!(done.status, 303, "{}", done.text());
    }

    async fn consent(&self, answer: &str) -> Answer {
        let mut ada = self.app.signed_in("ada@example.org").await;
        let csrf = csrf_in(&ada.get(OWN).await.text());
        ada.form(OWN, &[("csrf", csrf.as_str()), ("consent", answer)]).await
    }

    async fn attempt(&self) -> SessionId {
        let attempt = Attempt { bundle: &FORGED, ..Attempt::default() };
        self.app.with_token(&self.ada.token).upload(&record(&attempt)).await;
        worker::work_off_jobs(&self.app.state).await.unwrap();
        attempt.session_id
    }

    async fn override_score(&self, attempt: SessionId, score: Option<&str>) {
        let mut teacher = self.app.signed_in("teacher@example.org").await;
        let csrf = csrf_in(&teacher.get(&format!("/sessions/{attempt}")).await.text());
        let done = match score {
            Some(score) => {
                let form = [("csrf", csrf.as_str()), ("score", score), ("result", "passed"), ("reason", "Led.")];
                teacher.form(&format!("/sessions/{attempt}/override"), &form).await
            }
            None => {
                let form = [("csrf", csrf.as_str()), ("reason", "Not led.")];
                teacher.form(&format!("/sessions/{attempt}/override/withdraw"), &form).await
            }
        };
        assert!(done.status.as_u16() < 400, "{}", done.text());
    }

    /// Sends what is due, after a time in s.
    async fn send(&self, after_s: i64) {
        self.app.state.clock.advance(after_s);
        sending::send_due(&self.app.state).await.unwrap();
    }

    async fn erase(&self) {
        let reader = self.app.state.db.reader();
        let entry = directory::find_anybody(reader, self.school(), self.ada.person.id).await.unwrap().unwrap();
        let by = Eraser { actor: Actor::CommandLine, why: None };
        erasing::erase(&self.app.state, by, &entry, self.school(), ErasureScope::default()).await.unwrap();
    }

    fn statement(&self, verb: &str) -> Value {
        let all = self.records.statements();
        all.into_iter().find(|one| one["verb"]["display"]["en"] == verb).unwrap_or_else(|| panic!("no {verb}"))
    }
}

const FIRST: [&str; 4] = ["completed", "initialized", "mastered", "passed"];

#[tokio::test]
async fn statements_tell_of_an_attempt_and_its_grades() {
    let world = World::with(&[GROUND]).await;
    let attempt = world.attempt().await;
    world.send(0).await;
    assert_eq!(world.records.verbs(), FIRST);
    assert_eq!(world.records.count_requests(), 1, "one request");
    let passed = world.statement("passed");
    let account = &passed["actor"]["account"];
    assert_eq!(account["name"], world.ada.person.pseudonym, "{passed}");
    assert!(!passed.to_string().contains(&world.ada.person.display_name), "{passed}");
    assert!(passed["result"]["extensions"].to_string().contains("/metrics/peak_force_n/"), "{passed}");

    world.override_score(attempt, Some("55")).await;
    world.override_score(attempt, None).await;
    world.send(0).await;
    assert_eq!(world.records.verbs(), ["completed", "initialized", "mastered", "passed", "scored", "voided"]);
    let scored = world.statement("scored");
    assert_eq!(scored["result"]["score"]["raw"], 55.0);
    assert_eq!(scored["context"]["statement"]["id"], passed["id"]);
    assert_eq!(world.statement("voided")["object"]["id"], scored["id"]);
}

#[tokio::test]
async fn nothing_leaves_without_consent() {
    let world = World::with(&[]).await;
    let attempt = world.attempt().await;
    world.send(0).await;
    assert_eq!(world.records.count_requests(), 0);
    assert_eq!(world.consent("given").await.status, 303);
    world.override_score(attempt, Some("55")).await;
    world.send(0).await;
    assert_eq!(world.records.count_requests(), 0, "an attempt from before the consent");

    world.attempt().await;
    assert_eq!(world.consent("withdrawn").await.status, 303);
    world.send(0).await;
    assert_eq!(world.records.count_requests(), 0, "what waits does not leave");
    world.attempt().await;
    world.send(0).await;
    assert_eq!(world.records.count_requests(), 0);
    assert_eq!(world.consent("given").await.status, 303);
    world.attempt().await;
    world.send(0).await;
    assert_eq!(world.records.verbs(), FIRST);
}

#[tokio::test]
async fn consent_ends_with_the_store_that_it_names() {
    let mut world = World::with(&[]).await;
    assert_eq!(world.consent("given").await.status, 303);
    assert_eq!(world.set(&[("password", ""), ("version", "1.0.3")]).await.status, 303);
    let mut ada = world.app.signed_in("ada@example.org").await;
    assert!(ada.get(OWN).await.text().contains("value=\"withdrawn\""), "the same store");
    assert_eq!(world.set(&[("names", "yes"), ("password", "")]).await.status, 422, "another store has no password yet");
    assert_eq!(world.set(&[("names", "yes")]).await.status, 303);
    assert!(ada.get(OWN).await.text().contains("value=\"given\""), "names were not agreed to");
    assert_eq!(world.consent("given").await.status, 303);
    world.attempt().await;
    world.send(0).await;
    assert_eq!(world.statement("passed")["actor"]["name"], world.ada.person.display_name);
    world.act("disable").await;
    assert!(ada.get(OWN).await.text().contains("sends no learning records"));
    world.attempt().await;
    world.send(0).await;
    assert_eq!(world.records.verbs(), FIRST, "nothing more");
}

#[tokio::test]
async fn each_statement_arrives_once_whatever_fails() {
    let world = World::with(&[GROUND]).await;
    world.attempt().await;
    world.records.answer(&[500, 429, 503]);
    for wait_s in [0, 59, 61, 300, 1800] {
        world.send(wait_s).await;
    }
    assert_eq!(world.records.verbs(), FIRST);
    assert_eq!(world.records.count_requests(), 4, "a try at its time");
    world.send(86_400).await;
    assert_eq!(world.records.count_requests(), 0, "sent is sent");
}

#[tokio::test]
async fn store_that_refuses_the_service_is_not_asked_again() {
    let mut world = World::with(&[GROUND, ("password", "another")]).await;
    world.attempt().await;
    world.send(0).await;
    world.send(86_400).await;
    assert_eq!(world.records.count_requests(), 1);
    let page = world.page().await;
    assert!(page.contains("The store refuses this service") && page.contains("401"), "{page}");
    assert_eq!(world.set(&[GROUND]).await.status, 303);
    world.send(0).await;
    assert_eq!(world.records.verbs(), FIRST);
}

#[tokio::test]
async fn refused_statement_does_not_stop_the_others() {
    let mut world = World::with(&[GROUND]).await;
    world.records.refuse(Some("completed"));
    world.attempt().await;
    world.send(0).await;
    assert_eq!(world.records.verbs(), ["initialized", "mastered", "passed"]);
    world.send(86_400).await;
    let page = world.page().await;
    assert!(page.contains("400") && page.contains(&format!("{ADMIN}/retry")), "{page}");
    world.records.refuse(None);
    world.act("retry").await;
    world.send(0).await;
    assert_eq!(world.records.verbs(), FIRST);
}

#[tokio::test]
async fn erasing_stops_what_waits_and_lists_what_has_left() {
    let mut world = World::with(&[GROUND]).await;
    world.attempt().await;
    world.send(0).await;
    world.attempt().await;
    let mut ada = world.app.signed_in("ada@example.org").await;
    let own: Value = ada.get("/account/export").await.json();
    assert_eq!(own["statements"].as_array().map(Vec::len), Some(7), "a course is mastered once: {}", own["statements"]);
    world.erase().await;
    world.send(0).await;
    assert_eq!(world.records.count_requests(), 1, "what waits does not leave");
    let listed = world.head.get(&format!("{ADMIN}/erased.txt")).await.text();
    let mut listed: Vec<&str> = listed.lines().collect();
    listed.sort_unstable();
    let sent = world.records.statements();
    let mut sent: Vec<&str> = sent.iter().map(|one| one["id"].as_str().unwrap()).collect();
    sent.sort_unstable();
    assert_eq!(listed, sent);
}

#[tokio::test]
async fn settings_outside_their_range_are_refused() {
    let mut world = World::with(&[GROUND]).await;
    let long = "x".repeat(2001);
    for change in [
        ("endpoint", "http://lrs.example.org"),
        ("endpoint", "https://user@lrs.example.org"),
        ("endpoint", "nowhere"),
        ("user_name", ""),
        ("user_name", "a:b"),
        ("version", "0.95"),
        ("ground", long.as_str()),
    ] {
        let refused = world.set(&[change]).await;
        assert_eq!(refused.status, 422, "{change:?}");
        assert!(refused.text().contains("role=\"alert\""), "{change:?}");
    }
    assert_eq!(world.consent("given").await.status, 409, "the school does not ask");
    assert_eq!(world.consent("perhaps").await.status, 400);
}
