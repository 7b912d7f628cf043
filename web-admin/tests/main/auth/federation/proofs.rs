//! Proving anew who one is, without a password. Fails when a browser that was left open makes a token, when a proof is old, of another user or
//! without a time, or when it is good for longer than five minutes.

use model::Role;
use store::people::Person;

use super::{ADA, World, authorize_url, is_signed_in_as};
use crate::auth::second_factors::send;
use crate::support::client::{Answer, Client};
use crate::support::provider::{User, parameters};

const TOKENS: &str = "/account/tokens";

/// A person without a password, signed in by the provider.
async fn ada() -> (World, Person, Client) {
    let world = World::with(&[("addresses_verified", "true")]).await;
    let ada = world.invited(Role::Trainee, ADA, None).await;
    let (browser, answer) = world.enter_anew().await;
    assert_eq!(answer.header("location"), "/", "{}", answer.text());
    (world, ada, browser)
}

/// Asks for a token without a password.
async fn ask(browser: &mut Client) -> u16 {
    send(browser, TOKENS, TOKENS, &[("name", "Analysis"), ("days", "30"), ("password", "")]).await.status.as_u16()
}

/// Proves anew; the answer to the callback.
async fn prove(world: &World, browser: &mut Client) -> Answer {
    let action = format!("/account/prove/{}", world.id);
    let begun = send(browser, TOKENS, &action, &[("next", TOKENS)]).await;
    let url = authorize_url(&begun);
    let asked = parameters(&url);
    assert_eq!((asked["prompt"].as_str(), asked["max_age"].as_str()), ("login", "0"), "{url}");
    browser.get(&world.provider.log_in(&url)).await
}

#[tokio::test]
async fn a_fresh_proof_makes_a_token_for_five_minutes() {
    let (world, ada, mut browser) = ada().await;
    assert_eq!(ask(&mut browser).await, 422, "signing in is no fresh proof");
    let page = browser.get(TOKENS).await.text();
    assert!(page.contains("/account/identities?next=/account/tokens#prove"), "{page}");
    let proved = prove(&world, &mut browser).await;
    assert_eq!((proved.status.as_u16(), proved.header("location")), (303, TOKENS), "{}", proved.text());
    assert!(is_signed_in_as(&mut browser, &ada).await);
    assert_eq!(ask(&mut browser).await, 200);
    world.app.state.clock.advance(299);
    assert_eq!(ask(&mut browser).await, 200);
    world.app.state.clock.advance(2);
    assert_eq!(ask(&mut browser).await, 422);
}

#[tokio::test]
async fn a_proof_of_another_browser_is_worth_nothing_here() {
    let (world, _, mut browser) = ada().await;
    let (mut elsewhere, _) = world.enter_anew().await;
    assert_eq!(prove(&world, &mut elsewhere).await.status, 303);
    assert_eq!(ask(&mut browser).await, 422);
    assert_eq!(ask(&mut elsewhere).await, 200);
}

#[tokio::test]
async fn a_proof_needs_a_recent_time_and_the_same_user() {
    let (world, ada, mut browser) = ada().await;
    let authenticated = |ago| User { authenticated_s_ago: ago, ..User::new("ada", ADA) };
    for user in [
        authenticated(None),
        authenticated(Some(361)),
        authenticated(Some(86_400)),
        authenticated(Some(-3600)),
        User::new("somebody-else", ADA),
    ] {
        world.provider.set_user(user.clone());
        let answer = prove(&world, &mut browser).await;
        assert!(answer.status.is_client_error(), "{user:?}: {} {}", answer.status, answer.header("location"));
        assert_eq!(ask(&mut browser).await, 422, "{user:?}");
        assert!(is_signed_in_as(&mut browser, &ada).await, "{user:?}: the session goes on");
        world.app.state.clock.advance(61);
    }
    assert_eq!(world.identities().await.len(), 1);
}

#[tokio::test]
async fn a_password_is_still_asked_of_those_who_have_one() {
    let world = World::new().await;
    world.app.member(world.school, Role::Trainee, ADA).await;
    let mut browser = world.app.signed_in(ADA).await;
    let joining = format!("/account/identities/join/{}", world.id);
    let begun = send(&mut browser, "/account/identities", &joining, &[]).await;
    assert_eq!(browser.get(&world.provider.log_in(&authorize_url(&begun))).await.status, 303);
    assert_eq!(ask(&mut browser).await, 422);
    let begun = send(&mut browser, TOKENS, &format!("/account/prove/{}", world.id), &[("next", TOKENS)]).await;
    if begun.status == 200 {
        browser.get(&world.provider.log_in(&authorize_url(&begun))).await;
    }
    assert_eq!(ask(&mut browser).await, 422);
}

#[tokio::test]
async fn a_password_is_chosen_after_a_fresh_proof() {
    let (world, _, mut browser) = ada().await;
    let chosen = "ferry lantern opal";
    let fields = [("old", ""), ("password", chosen), ("again", chosen)];
    let refused = send(&mut browser, "/account", "/account/password", &fields).await;
    assert_eq!(refused.status, 422);
    let page = refused.text();
    assert!(page.contains("You have no password here") && !page.contains("not your current password"), "{page}");
    assert_eq!(prove(&world, &mut browser).await.status, 303);
    assert_eq!(send(&mut browser, "/account", "/account/password", &fields).await.status, 303);
    assert_eq!(world.app.stranger().sign_in(ADA, chosen).await.header("location"), "/");
}

#[tokio::test]
async fn without_an_enabled_provider_the_page_says_what_helps() {
    let (mut world, _, mut browser) = ada().await;
    assert!(browser.get("/account/identities").await.text().contains("Confirm at University"));
    assert_eq!(world.act("disable").await.status, 303);
    let page = browser.get("/account/identities?next=/account/tokens").await.text();
    assert!(page.contains("id=\"prove\"") && page.contains("Choose a password first"), "{page}");
}
