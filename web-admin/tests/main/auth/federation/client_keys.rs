//! Keys with which the service authenticates at a provider. Fails when an assertion is refused by the provider, when a key signs before it
//! was published for a week or is no longer published while it may be needed, or when a private key leaves the service.

use acts::operations::upkeep;
use model::Role;
use serde_json::Value;

use super::{ADMIN, World, app_for, fixed_clock, send_provider};
use crate::support::App;
use crate::support::client::Client;
use crate::support::provider::Provider;

const BY_KEY: [(&str, &str); 2] = [("authentication", "key"), ("client_secret", "")];
const DAY_S: i64 = 24 * 3600;

/// A school with a provider that accepts keys alone, and the form of that provider as its administrator has sent it.
async fn world_by_key() -> World {
    let clock = fixed_clock();
    let provider = Provider::start(&clock).await;
    provider.set_methods(&["private_key_jwt"]);
    let app = app_for(&clock, &[&provider]).await;
    let school = app.school("North").await;
    app.member(school, Role::Administrator, super::HEAD).await;
    let mut head = app.signed_in(super::HEAD).await;
    let id = super::add(&mut head, provider.issuer(), &[&BY_KEY[..], &[("creates", "trainee")]].concat()).await;
    World { app, school, provider, id, head }
}

/// The published key set.
async fn key_set(app: &App) -> Value {
    let answer = app.stranger().get("/.well-known/jwks.json").await;
    assert_eq!((answer.status.as_u16(), answer.header("cache-control")), (200, "public, max-age=600"));
    serde_json::from_str(&answer.text()).unwrap()
}

async fn kids(app: &App) -> Vec<String> {
    let set = key_set(app).await;
    set["keys"].as_array().unwrap().iter().map(|key| key["kid"].as_str().unwrap().to_owned()).collect()
}

/// Whether a user gets in by the provider.
async fn gets_in(world: &World) -> bool {
    world.enter_anew().await.1.header("location") == "/"
}

#[tokio::test]
async fn a_provider_accepts_the_key_of_the_service() {
    let mut world = world_by_key().await;
    let set = key_set(&world.app).await;
    let [key] = &set["keys"].as_array().unwrap()[..] else { panic!("one key: {set}") };
    assert_eq!((&key["kty"], &key["alg"], &key["use"]), (&"RSA".into(), &"RS256".into(), &"sig".into()));
    assert!(["d", "p", "q", "dp", "dq", "qi"].iter().all(|private| key.get(private).is_none()), "{key}");
    assert!(!gets_in(&world).await, "the provider does not know the key yet");
    world.provider.set_client_keys(set);
    assert!(gets_in(&world).await);
    assert!(gets_in(&world).await, "each assertion is a new one");
    let page = format!("{ADMIN}/{}", world.id);
    let form = world.head.get(&page).await.text();
    assert!(form.contains("<option value=\"key\" selected>") && form.contains("/.well-known/jwks.json"), "{form}");
    // Back to a secret, which is asked for: none is stored.
    world.provider.set_methods(&["client_secret_basic"]);
    let issuer = world.provider.issuer().to_owned();
    let refused = send_provider(&mut world.head, &page, &issuer, &[("client_secret", "")]).await;
    assert_eq!(refused.status, 422, "{}", refused.text());
    let changed = send_provider(&mut world.head, &page, &issuer, &[]).await;
    assert_eq!(changed.status, 303, "{}", changed.text());
    assert!(gets_in(&world).await);
}

#[tokio::test]
async fn an_unsupported_authentication_is_refused() {
    let clock = fixed_clock();
    let provider = Provider::start(&clock).await;
    let app = app_for(&clock, &[&provider]).await;
    let school = app.school("North").await;
    app.member(school, Role::Administrator, super::HEAD).await;
    let mut head: Client = app.signed_in(super::HEAD).await;
    for (method, changes) in [
        ("client_secret_basic", &BY_KEY[..]),
        ("private_key_jwt", &[][..]),
        ("tls_client_auth", &[][..]),
        ("client_secret_basic", &[("authentication", "none")][..]),
    ] {
        provider.set_methods(&[method]);
        let refused = send_provider(&mut head, ADMIN, provider.issuer(), changes).await;
        assert_eq!(refused.status, 422, "{method}: {}", refused.text());
    }
}

#[tokio::test]
async fn keys_are_announced_replaced_and_retired() {
    let world = world_by_key().await;
    let [first] = &kids(&world.app).await[..] else { panic!("one key") };
    let pass_days = async |days: i64| {
        world.app.state.clock.advance(days * DAY_S);
        upkeep::forget_expired(&world.app.state).await.unwrap();
        kids(&world.app).await
    };
    assert_eq!(pass_days(350).await, std::slice::from_ref(first));
    let both = pass_days(9).await;
    assert_eq!((both.len(), &both[0]), (2, first), "the next key is published");
    let only = |kid: &String, set: &Value| {
        let keys = set["keys"].as_array().unwrap().iter().filter(|key| key["kid"] == kid.as_str());
        serde_json::json!({ "keys": keys.collect::<Vec<_>>() })
    };
    let set = key_set(&world.app).await;
    world.provider.set_client_keys(only(first, &set));
    assert!(gets_in(&world).await, "the earlier key signs for a week");
    assert_eq!(pass_days(8).await, both);
    assert!(!gets_in(&world).await, "the next key signs");
    world.provider.set_client_keys(only(&both[1], &set));
    assert!(gets_in(&world).await);
    assert_eq!(pass_days(31).await, both[1..]);
}
