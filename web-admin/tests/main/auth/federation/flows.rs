//! The way to the provider and back. Fails when a callback is accepted that belongs to no flow of this browser, or to a flow that was used or is
//! over, and when a planted session survives the sign-in.

use futures::future::join_all;
use model::Role;
use platform::config::Config;

use super::{
    ADA, ADMIN, HEAD, World, add, app_for, assert_refused, authorize_url, fixed_clock, is_signed_in, is_signed_in_as,
    press, reasons,
};
use crate::support::App;
use crate::support::client::{Answer, Client};
use crate::support::provider::{Endpoint, Forgery, Provider, callback, parameters};

/// A world in which Ada, the provider's usual user, has an account without a password.
async fn world() -> (World, store::people::Person) {
    let world = World::with(&[("addresses_verified", "true")]).await;
    let ada = world.invited(Role::Trainee, ADA, None).await;
    (world, ada)
}

#[tokio::test]
async fn the_button_leads_to_the_provider_and_back() {
    let (world, ada) = world().await;
    let mut browser = world.app.stranger();
    let page = browser.get("/login").await.text();
    assert!(page.contains(&format!("action=\"/sign-in/{}\"", world.id)) && page.contains("University"), "{page}");
    let form_cookie = browser.cookie_named("stylet_form");
    assert!(form_cookie.is_some());
    let begun = press(&mut browser, &world.id, "/account/tokens").await;
    let url = authorize_url(&begun);
    assert_eq!(begun.header("cache-control"), "no-store");
    let asked = parameters(&url);
    assert_eq!(asked["scope"], "openid profile email");
    assert!(!asked.contains_key("prompt") && !asked.contains_key("max_age"), "{url}");
    let back = browser.get(&world.provider.log_in(&url)).await;
    assert_eq!((back.status.as_u16(), back.header("location")), (303, "/account/tokens"), "{}", back.text());
    assert!(is_signed_in_as(&mut browser, &ada).await);
    assert_eq!(reasons(&world.app).await, Vec::<String>::new());
}

#[tokio::test]
async fn an_address_elsewhere_is_not_where_one_goes_next() {
    let (world, _) = world().await;
    for next in ["//evil.example", "https://evil.example/", "/\\evil.example"] {
        let mut browser = world.app.stranger();
        let begun = press(&mut browser, &world.id, next).await;
        let back = browser.get(&world.provider.log_in(&authorize_url(&begun))).await;
        assert_eq!(back.header("location"), "/", "{next}");
    }
}

#[tokio::test]
async fn a_form_of_another_site_starts_no_flow() {
    let (world, _) = world().await;
    for fields in [&[("next", "/")][..], &[("csrf", "0"), ("next", "/")]] {
        let mut browser = world.app.stranger();
        browser.get("/login").await;
        assert_eq!(browser.form(&format!("/sign-in/{}", world.id), fields).await.status, 403);
    }
}

/// A browser that has been at the provider, and the address to which it is sent back.
async fn returning(world: &World) -> (Client, String) {
    let mut browser = world.app.stranger();
    let begun = press(&mut browser, &world.id, "/").await;
    let address = world.provider.log_in(&authorize_url(&begun));
    (browser, address)
}

/// Asserts that an answer is refused because no sign-in has its state. Anybody can send one, so it is counted by the hour and has no row of
/// its own.
async fn assert_unknown(world: &World, browser: &mut Client, answer: &Answer, refused: usize) {
    assert!(answer.status == 403 && answer.text().contains("no_flow"), "{}", answer.text());
    assert_eq!(reasons(&world.app).await.len(), refused);
    assert!(!is_signed_in(browser).await);
}

#[tokio::test]
async fn a_callback_without_a_state_of_ours_is_refused() {
    let (world, _) = world().await;
    let issuer = world.provider.issuer();
    for address in [
        callback(&[]),
        callback(&[("code", "code-1"), ("iss", issuer)]),
        callback(&[("code", "code-1"), ("state", ""), ("iss", issuer)]),
        callback(&[("code", "code-1"), ("state", &"A".repeat(43)), ("iss", issuer)]),
        callback(&[("error", "access_denied"), ("state", &"A".repeat(43))]),
        callback(&[("code", "code-1"), ("state", &"x".repeat(3000))]),
    ] {
        let (mut browser, _) = returning(&world).await;
        let answer = browser.get(&address).await;
        assert_unknown(&world, &mut browser, &answer, 0).await;
    }
    assert_eq!(world.provider.requests(Endpoint::Token), 0);
}

#[tokio::test]
async fn a_callback_of_another_browser_is_refused() {
    let (world, _) = world().await;
    let (_, address) = returning(&world).await;
    let mut eve = world.app.stranger();
    eve.get("/login").await;
    let answer = eve.get(&address).await;
    assert_eq!(assert_refused(&world.app, &mut eve, &answer, 0).await, "no_flow");
    let (_, address) = returning(&world).await;
    let mut bare = world.app.stranger();
    let answer = bare.get(&address).await;
    assert_eq!(assert_refused(&world.app, &mut bare, &answer, 1).await, "no_flow");
    assert_eq!(world.provider.requests(Endpoint::Token), 0, "the code was not sent on");
}

#[tokio::test]
async fn a_callback_is_accepted_once() {
    let (world, _) = world().await;
    let (mut browser, address) = returning(&world).await;
    let kept = browser.clone();
    assert_eq!(browser.get(&address).await.status, 303);
    let mut again = kept;
    let answer = again.get(&address).await;
    assert_unknown(&world, &mut again, &answer, 0).await;
    assert_eq!(world.provider.requests(Endpoint::Token), 1);
}

#[tokio::test]
async fn a_flow_ends_after_ten_minutes() {
    let (world, _) = world().await;
    let mut browser = world.app.stranger();
    let begun = press(&mut browser, &world.id, "/").await;
    world.app.state.clock.advance(599);
    let address = world.provider.log_in(&authorize_url(&begun));
    assert_eq!(browser.get(&address).await.status, 303);
    let mut browser = world.app.stranger();
    let begun = press(&mut browser, &world.id, "/").await;
    world.app.state.clock.advance(601);
    let address = world.provider.log_in(&authorize_url(&begun));
    let answer = browser.get(&address).await;
    assert_eq!(assert_refused(&world.app, &mut browser, &answer, 0).await, "no_flow");
}

#[tokio::test]
async fn a_refused_callback_ends_its_flow() {
    let (world, _) = world().await;
    let (mut browser, address) = returning(&world).await;
    let state = parameters(&address)["state"].clone();
    let guessed = callback(&[("code", "guessed"), ("state", &state), ("iss", world.provider.issuer())]);
    let answer = browser.get(&guessed).await;
    assert_eq!(assert_refused(&world.app, &mut browser, &answer, 0).await, "code");
    let answer = browser.get(&address).await;
    assert_unknown(&world, &mut browser, &answer, 1).await;
    let begun = press(&mut browser, &world.id, "/").await;
    let url = authorize_url(&begun);
    let answer = browser.get(&world.provider.deny(&url)).await;
    assert_eq!(assert_refused(&world.app, &mut browser, &answer, 1).await, "denied");
    let answer = browser.get(&world.provider.log_in(&url)).await;
    assert_unknown(&world, &mut browser, &answer, 2).await;
}

#[tokio::test]
async fn an_answer_in_the_name_of_another_provider_is_refused() {
    let clock = fixed_clock();
    let (one, other) = (Provider::start(&clock).await, Provider::start(&clock).await);
    let app = app_for(&clock, &[&one, &other]).await;
    let school = app.school("North").await;
    app.member(school, Role::Administrator, HEAD).await;
    let mut head = app.signed_in(HEAD).await;
    let id = add(&mut head, one.issuer(), &[]).await;
    add(&mut head, other.issuer(), &[("name", "Hospital")]).await;
    for (n, issuer) in
        [Some(other.issuer()), Some("https://provider.example.net"), Some(""), None].into_iter().enumerate()
    {
        let mut browser = app.stranger();
        let begun = press(&mut browser, &id, "/").await;
        let sent = parameters(&one.log_in(&authorize_url(&begun)));
        let mut fields = vec![("code", sent["code"].as_str()), ("state", sent["state"].as_str())];
        fields.extend(issuer.map(|issuer| ("iss", issuer)));
        let answer = browser.get(&callback(&fields)).await;
        assert_eq!(assert_refused(&app, &mut browser, &answer, n).await, "issuer", "{issuer:?}");
    }
    assert_eq!((one.requests(Endpoint::Token), other.requests(Endpoint::Token)), (0, 0));
}

#[tokio::test]
async fn a_planted_session_is_replaced() {
    let (world, ada) = world().await;
    world.app.member(world.school, Role::Trainee, "eve@example.org").await;
    let planted = world.app.signed_in("eve@example.org").await.cookie_named("stylet_session").unwrap();
    let (mut browser, address) = returning(&world).await;
    browser.cookie = Some(format!("{}; stylet_session={planted}", browser.cookie.unwrap()));
    let answer = browser.get(&address).await;
    assert_eq!(answer.status, 303, "{}", answer.text());
    assert_ne!(browser.cookie_named("stylet_session").unwrap(), planted);
    assert!(is_signed_in_as(&mut browser, &ada).await);
    let mut eve = world.app.stranger();
    eve.cookie = Some(format!("stylet_session={planted}"));
    assert!(!is_signed_in_as(&mut eve, &ada).await);
}

#[tokio::test]
async fn rotated_keys_are_fetched_once_more() {
    let (world, _) = world().await;
    assert_eq!(world.enter_anew().await.1.header("location"), "/");
    let before = world.provider.requests(Endpoint::Keys);
    assert_eq!(before, 1);
    world.app.state.clock.advance(61);
    assert_eq!(world.enter_anew().await.1.header("location"), "/");
    assert_eq!(world.provider.requests(Endpoint::Keys), before, "known keys are not fetched again");
    world.provider.rotate("second");
    world.app.state.clock.advance(61);
    assert_eq!(world.enter_anew().await.1.header("location"), "/");
    assert_eq!(world.provider.requests(Endpoint::Keys), before + 1);
}

#[tokio::test]
async fn concurrent_sign_ins_fetch_new_keys_once() {
    let (world, _) = world().await;
    assert_eq!(world.enter_anew().await.1.header("location"), "/");
    let before = world.provider.requests(Endpoint::Keys);
    world.app.state.clock.advance(61);
    world.provider.rotate("second");
    let mut waiting = Vec::new();
    for _ in 0..6 {
        waiting.push(returning(&world).await);
    }
    let answers =
        join_all(waiting.into_iter().map(|(mut browser, address)| async move { browser.get(&address).await }));
    for answer in answers.await {
        assert_eq!(answer.header("location"), "/", "{}", answer.text());
    }
    assert_eq!(world.provider.requests(Endpoint::Keys), before + 1);
}

#[tokio::test]
async fn invented_key_ids_cost_one_fetch_a_minute() {
    let (world, _) = world().await;
    assert_eq!(world.enter_anew().await.1.header("location"), "/");
    let before = world.provider.requests(Endpoint::Keys);
    world.app.state.clock.advance(61);
    world.provider.forge(Forgery::UnknownKey);
    for n in 0..3 {
        let (mut browser, answer) = world.enter_anew().await;
        assert_eq!(assert_refused(&world.app, &mut browser, &answer, n).await, "key");
    }
    assert_eq!(world.provider.requests(Endpoint::Keys), before + 1);
}

#[tokio::test]
async fn a_disabled_provider_signs_nobody_in() {
    let (mut world, _) = world().await;
    let (mut browser, address) = returning(&world).await;
    assert_eq!(world.act("disable").await.header("location"), ADMIN);
    let answer = browser.get(&address).await;
    assert_eq!(assert_refused(&world.app, &mut browser, &answer, 0).await, "disabled");
    let page = browser.get("/login").await.text();
    assert!(!page.contains(&format!("/sign-in/{}", world.id)), "{page}");
    let begun = press(&mut browser, &world.id, "/").await;
    assert!(begun.status.is_client_error() && begun.header("refresh").is_empty(), "{}", begun.status);
    assert_eq!(world.act("enable").await.header("location"), ADMIN);
    assert_eq!(world.enter_anew().await.1.header("location"), "/");
}

#[tokio::test]
async fn administrators_get_in_when_the_provider_is_gone() {
    let (mut world, _) = world().await;
    world.provider.stop().await;
    let (mut browser, answer) = world.enter_anew().await;
    assert_eq!(answer.status, 503, "{}", answer.text());
    assert_refused(&world.app, &mut browser, &answer, 0).await;
    assert_eq!(browser.get("/login").await.status, 200);
    assert_eq!(world.set_local("administrators").await.status, 303);
    assert!(is_signed_in(&mut world.app.signed_in(HEAD).await).await);
}

#[tokio::test]
async fn outgoing_requests_are_restricted_by_default() {
    let folder = tempfile::tempdir().unwrap();
    let rules = Config::in_folder(folder.path()).outgoing;
    assert!(rules.plain_http.is_empty() && !rules.private_addresses);
    let app = App::new().await;
    assert!(app.state.config.outgoing.plain_http.is_empty());
}
