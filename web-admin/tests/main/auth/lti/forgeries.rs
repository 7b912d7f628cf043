//! Launches with one thing wrong. Fails when one of them signs a user in, or when the audit log names another reason.

use serde_json::{Value, json};

use super::{ADMIN, World, login, post, refusal, send_platform};
use crate::support::learning_platform::LaunchMessage;
use crate::support::provider::{Forgery, ORIGIN};

/// Each forgery of a token, with the reason for which it is refused.
fn table() -> [(Forgery, &'static str); 18] {
    [
        (Forgery::Issuer, "issuer"),
        (Forgery::Audience, "audience"),
        (Forgery::SeveralAudiences, "audience"),
        (Forgery::AuthorizedParty, "audience"),
        (Forgery::Nonce, "nonce"),
        (Forgery::NoNonce, "nonce"),
        (Forgery::NoAlgorithm, "algorithm"),
        (Forgery::PublicKeyAsSecret, "algorithm"),
        (Forgery::UnknownKey, "key"),
        (Forgery::AnotherKey, "signature"),
        (Forgery::Expired, "expired"),
        (Forgery::IssuedInTheFuture, "from_the_future"),
        (Forgery::NotYetValid, "from_the_future"),
        (Forgery::TooOld, "too_old"),
        (Forgery::EmptySubject, "anonymous"),
        (Forgery::NoSubject, "anonymous"),
        (Forgery::TwoParts, "malformed"),
        (Forgery::ManyClaims, ""),
    ]
}

#[tokio::test]
async fn each_forgery_is_refused_for_its_own_reason() {
    let mut world = World::with(&[("creates_trainees", "true")]).await;
    // With one key that signs by ECDSA: the RSA key of the tests is always the same, so no other key has its id.
    world.platform.rotate("second");
    world.clock().advance(61);
    let mut refused = 0;
    for (forgery, reason) in table() {
        world.platform.forge(Some(forgery.clone()));
        let (mut browser, answer) = world.launch_anew(&LaunchMessage::by("eve")).await;
        if reason.is_empty() {
            assert_eq!(answer.header("location"), "/", "{forgery:?}");
        } else {
            assert_eq!(world.assert_refused(&mut browser, &answer, refused).await, reason, "{forgery:?}");
            refused += 1;
        }
        // New keys are fetched once a minute.
        world.clock().advance(61);
    }
    assert_eq!(world.identities().await, ["lti created eve"], "40 kB of claims are no forgery");
    let audit = world.head.get("/admin/audit").await.text();
    assert!(audit.contains("refused at a launch from a learning platform"), "{audit}");
}

#[tokio::test]
async fn other_messages_and_targets_are_refused() {
    let world = World::with(&[("creates_trainees", "true")]).await;
    let by = || LaunchMessage::by("eve");
    let table = [
        (by().with_lti("message_type", "LtiSubmissionReviewRequest"), "message"),
        (by().with_lti("message_type", "LtiDeepLinkingRequest"), "content"),
        (by().with_lti("message_type", Value::Null), "message"),
        (by().with_lti("version", "1.1.0"), "message"),
        (by().with_lti("version", "LTI-1p0"), "message"),
        (by().with_lti("target_link_uri", "https://evil.example/lti/launch"), "target"),
        (by().with_lti("target_link_uri", format!("{ORIGIN}.evil.example/")), "target"),
        (by().with_lti("target_link_uri", format!("{ORIGIN}@evil.example/")), "target"),
        (by().with_lti("target_link_uri", Value::Null), "malformed"),
        (by().with_lti("deployment_id", Value::Null), "malformed"),
        (by().with_lti("resource_link", Value::Null), "malformed"),
        (by().with_lti("resource_link", json!({ "id": "x".repeat(300) })), "malformed"),
        (by().with_lti("deployment_id", "2"), "deployment"),
    ];
    for (n, (message, reason)) in table.into_iter().enumerate() {
        let (mut browser, answer) = world.launch_anew(&message).await;
        assert_eq!(world.assert_refused(&mut browser, &answer, n).await, reason, "{message:?}");
    }
    assert_eq!(world.identities().await, Vec::<String>::new());
}

#[tokio::test]
async fn a_nonce_is_good_for_one_launch() {
    let world = World::with(&[("creates_trainees", "true")]).await;
    let (mut first, mut second) = (world.app.stranger(), world.app.stranger());
    let (url, other) = (world.begin(&mut first).await, world.begin(&mut second).await);
    let used = world.platform.confirm(&url, &LaunchMessage::by("ada"));
    assert_eq!(post(&mut first, &used).await.status, 303);
    let own = world.platform.confirm(&other, &LaunchMessage::by("ada"));
    let answer = post(&mut second, &[own[0].clone(), used[1].clone()]).await;
    assert_eq!(world.assert_refused(&mut second, &answer, 0).await, "nonce");
}

#[tokio::test]
async fn an_answer_without_a_token_is_refused() {
    let world = World::new().await;
    for (n, (fields, reason)) in
        [(vec![], "malformed"), (vec![("error", "login_required".to_owned())], "denied")].into_iter().enumerate()
    {
        let mut browser = world.app.stranger();
        let state = world.platform.check(&world.begin(&mut browser).await)["state"].clone();
        let answer = post(&mut browser, &[vec![("state", state)], fields].concat()).await;
        assert_eq!(world.assert_refused(&mut browser, &answer, n).await, reason);
    }
    let mut browser = world.app.stranger();
    for fields in [vec![], vec![("state", "é".repeat(5))], vec![("state", "unknown".to_owned())]] {
        assert_eq!(refusal(&post(&mut browser, &fields).await), "no_flow", "{fields:?}");
    }
}

#[tokio::test]
async fn a_login_that_cannot_be_right_begins_nothing() {
    let world = World::new().await;
    let long = "x".repeat(4001);
    let mut refused = 0;
    for (changes, reason) in [
        (("iss", "https://other.example"), "platform"),
        (("iss", ""), "platform"),
        (("client_id", "another"), "platform"),
        (("target_link_uri", "https://evil.example/"), "target"),
        (("target_link_uri", "javascript:alert(1)"), "target"),
        (("login_hint", ""), "malformed"),
        (("lti_message_hint", long.as_str()), "malformed"),
    ] {
        let mut browser = world.app.stranger();
        let answer = browser.get(&login(&[changes])).await;
        assert_eq!(refusal(&answer), reason, "{changes:?}");
        assert!(answer.headers.get("refresh").is_none() && browser.cookie_named("").is_none());
        // An unregistered platform has no school, and so no audit log.
        refused += usize::from(reason != "platform");
        assert_eq!(world.reasons().await.len(), refused, "{changes:?}");
    }
}

#[tokio::test]
async fn a_disabled_platform_launches_nothing() {
    let mut world = World::with(&[("creates_trainees", "true")]).await;
    let mut begun = world.app.stranger();
    let url = world.begin(&mut begun).await;
    assert_eq!(world.act("disable").await.header("location"), ADMIN);
    let answer = post(&mut begun, &world.platform.confirm(&url, &LaunchMessage::by("ada"))).await;
    assert_eq!(world.assert_refused(&mut begun, &answer, 0).await, "disabled");
    let mut browser = world.app.stranger();
    let answer = browser.get(&login(&[])).await;
    assert_eq!(world.assert_refused(&mut browser, &answer, 1).await, "disabled");
    assert_eq!(world.act("enable").await.header("location"), ADMIN);
    assert_eq!(world.launch_anew(&LaunchMessage::by("ada")).await.1.header("location"), "/");
}

#[tokio::test]
async fn a_new_key_is_fetched_and_an_absent_one_reported() {
    let mut world = World::with(&[("creates_trainees", "true")]).await;
    world.clock().advance(61);
    world.platform.rotate("second");
    assert_eq!(world.launch_anew(&LaunchMessage::by("ada")).await.1.header("location"), "/");
    let own = format!("{ADMIN}/{}", world.id);
    let closed = format!("http://{}/closed", world.platform.address);
    let changes = [("keys_url", closed.as_str()), ("creates_trainees", "true")];
    assert_eq!(send_platform(&mut world.head, &own, &world.platform, &changes).await.status, 303);
    let (mut browser, answer) = world.launch_anew(&LaunchMessage::by("ada")).await;
    assert_eq!(world.assert_refused(&mut browser, &answer, 0).await, "unreachable");
    assert_eq!(answer.status, 503);
}
