//! Open Badges through HTTP. Fails when a badge is issued for less than a certificate, is not verifiable by the published documents, or stays
//! valid although the mastery was withdrawn or the person erased.

use std::io::Read;

use acts::privacy::erasing;
use acts::privacy::erasing::Eraser;
use acts::privacy::erasures::ErasureScope;
use acts::training::{badges, certificates};
use data_encoding::BASE64URL_NOPAD;
use flate2::read::GzDecoder;
use model::ids::SessionId;
use model::training::badge::check_badge;
use serde_json::Value;
use store::audit::Actor;
use store::people::directory;
use web_admin::worker;

use super::certificates::school;
use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, FORGED, record};
use crate::support::{App, Member};

/// A school in which any pass counts, and a trainee who has mastered its course by one attempt.
struct Mastered {
    app: App,
    ada: Member,
    attempt: SessionId,
}

impl Mastered {
    async fn new() -> Self {
        let (app, ada) = school().await;
        let attempt = Attempt { bundle: &FORGED, ..Attempt::default() };
        app.with_token(&ada.token).upload(&record(&attempt)).await;
        worker::work_off_jobs(&app.state).await.unwrap();
        let mastered = Self { app, ada, attempt: attempt.session_id };
        let mut browser = mastered.app.signed_in("ada@example.org").await;
        assert_eq!(mastered.badge(&mut browser, "json").await.status, 409, "neither signed nor supervised");
        let mut head = mastered.app.signed_in("head@example.org").await;
        let csrf = csrf_in(&head.get("/admin").await.text());
        let form = [("csrf", csrf.as_str()), ("needed", "nothing")];
        assert_eq!(head.form("/admin/certificate-needs", &form).await.status, 303);
        mastered
    }

    async fn badge(&self, browser: &mut Client, kind: &str) -> Answer {
        browser.get(&format!("/trainees/{}/certificates/one-step/badge.{kind}", self.ada.person.id)).await
    }

    /// Returns the places of the first list that are revoked, by the published list.
    async fn revoked(&self) -> Vec<usize> {
        let published = self.app.stranger().get("/badges/status/0").await;
        assert_eq!((published.status.as_u16(), published.header("content-type")), (200, "application/vc"));
        assert_eq!(published.header("access-control-allow-origin"), "*");
        let list: Value = published.json();
        assert_eq!(list["issuer"], issuer(&self.app), "{list}");
        let encoded =
            list["credentialSubject"]["encodedList"].as_str().and_then(|text| text.strip_prefix('u')).unwrap();
        let mut bits = Vec::new();
        GzDecoder::new(&BASE64URL_NOPAD.decode(encoded.as_bytes()).unwrap()[..]).read_to_end(&mut bits).unwrap();
        assert_eq!(bits.len(), 16 * 1024);
        (0..bits.len() * 8).filter(|index| bits[index / 8] & (0x80 >> (index % 8)) != 0).collect()
    }

    /// Sets the result of the attempt.
    async fn override_result(&self, result: &str) {
        let mut teacher = self.app.signed_in("teacher@example.org").await;
        let csrf = csrf_in(&teacher.get(&format!("/sessions/{}", self.attempt)).await.text());
        let form = [("csrf", csrf.as_str()), ("score", "55"), ("result", result), ("reason", "The hand was led.")];
        let done = teacher.form(&format!("/sessions/{}/override", self.attempt), &form).await;
        assert!(done.status.as_u16() < 400, "{}", done.text());
    }

    async fn erase(&self) {
        let school = self.ada.person.school_id;
        let entry =
            directory::find_anybody(self.app.state.db.reader(), school, self.ada.person.id).await.unwrap().unwrap();
        let by = Eraser { actor: Actor::CommandLine, why: None };
        erasing::erase(&self.app.state, by, &entry, school, ErasureScope::default()).await.unwrap();
    }
}

fn issuer(app: &App) -> String {
    badges::issuer(&app.state).unwrap().did
}

fn index_of(badge: &Value) -> usize {
    badge["credentialStatus"]["statusListIndex"].as_str().unwrap().parse().unwrap()
}

#[tokio::test]
async fn badge_is_verifiable_by_the_published_documents() {
    let mastered = Mastered::new().await;
    let app = &mastered.app;
    let mut browser = app.signed_in("ada@example.org").await;
    let home = browser.get("/").await.text();
    assert!(
        home.contains("certificates/one-step/badge.json") && home.contains("certificates/one-step/badge.svg"),
        "{home}"
    );
    let answer = mastered.badge(&mut browser, "json").await;
    assert_eq!((answer.status.as_u16(), answer.header("content-type")), (200, "application/vc"));
    assert!(answer.header("content-disposition").contains("badge-one-step.json"));
    let key = certificates::public_key(&app.state.config.keys_dir).unwrap();
    let badge = check_badge(answer.text().as_bytes(), &key).unwrap();
    assert_eq!((badge.school.as_str(), badge.achievement.name.as_str()), ("North & Sons", "One <step> & no more"));
    assert_eq!((badge.person, &badge.issuer.did), (mastered.ada.person.id, &issuer(app)));
    let narrative = &badge.achievement.narrative;
    assert!(
        narrative.contains("mastered with 1 pass") && narrative.contains("Simulated performance only"),
        "{narrative}"
    );
    assert!(!answer.text().contains(&mastered.ada.person.display_name), "a badge has no name");

    let picture = mastered.badge(&mut browser, "svg").await;
    assert_eq!(picture.header("content-type"), "image/svg+xml");
    assert!(picture.text().contains("One &#60;step&#62; &#38; no more"), "{}", picture.text());
    assert_eq!(check_badge(picture.text().as_bytes(), &key).unwrap(), badge, "the same badge, issued once");

    let document = app.stranger().get("/.well-known/did.json").await;
    assert_eq!(document.header("content-type"), "application/did+ld+json");
    let document: Value = document.json();
    let method = &answer.json()["proof"]["verificationMethod"];
    assert_eq!((&document["id"], &document["assertionMethod"][0]), (&issuer(app).into(), method));
    assert_eq!(&document["verificationMethod"][0]["id"], method);
    assert_eq!(app.stranger().get("/badges/status/1").await.status, 404);
    assert_eq!(app.stranger().get("/badges/status/18446744073709551615").await.status, 404);
    assert_eq!(app.stranger().get("/badges/status/x").await.status, 404);
}

#[tokio::test]
async fn badge_is_revoked_for_good_when_mastery_is_withdrawn() {
    let mastered = Mastered::new().await;
    let app = &mastered.app;
    let mut browser = app.signed_in("ada@example.org").await;
    let first = index_of(&mastered.badge(&mut browser, "json").await.json());
    assert_eq!(badges::revoke_lost_badges(&app.state).await.unwrap(), 0);
    assert_eq!(mastered.revoked().await, Vec::<usize>::new());

    mastered.override_result("failed").await;
    assert_eq!(mastered.badge(&mut browser, "json").await.status, 409);
    assert_eq!(badges::revoke_lost_badges(&app.state).await.unwrap(), 1);
    assert_eq!(badges::revoke_lost_badges(&app.state).await.unwrap(), 0, "once");
    assert_eq!(mastered.revoked().await, [first]);

    mastered.override_result("passed").await;
    let second = index_of(&mastered.badge(&mut browser, "json").await.json());
    assert_ne!(second, first, "another badge at another place");
    assert_eq!(badges::revoke_lost_badges(&app.state).await.unwrap(), 0);
    assert_eq!(mastered.revoked().await, [first], "a revoked badge stays revoked");
}

#[tokio::test]
async fn badge_survives_stricter_rules_and_ends_with_the_person() {
    let mastered = Mastered::new().await;
    let app = &mastered.app;
    let mut browser = app.signed_in("ada@example.org").await;
    let place = index_of(&mastered.badge(&mut browser, "json").await.json());
    let mut head = app.signed_in("head@example.org").await;
    let csrf = csrf_in(&head.get("/admin").await.text());
    head.form("/admin/certificate-needs", &[("csrf", &csrf), ("needed", "supervised")]).await;
    assert_eq!(mastered.badge(&mut browser, "json").await.status, 409, "another is not issued");
    assert_eq!(badges::revoke_lost_badges(&app.state).await.unwrap(), 0, "it states what counted");
    assert_eq!(mastered.revoked().await, Vec::<usize>::new());
    mastered.erase().await;
    assert_eq!(mastered.revoked().await, [place]);
}
