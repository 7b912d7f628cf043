//! Providers that answer too much, too slowly, or from elsewhere. Fails when the service waits longer than 11 s, reads without a limit, follows
//! a redirect to another host, or connects to an address of the inside.

use std::time::Duration;

use futures::future::join_all;
use model::Role;
use platform::outgoing::OutgoingRules;
use tokio::time::timeout;

use super::{ADA, ADMIN, HEAD, World, add, app_for, assert_refused, fixed_clock, flow, ids, reasons, send_provider};
use crate::support::App;
use crate::support::client::Client;
use crate::support::provider::{Endpoint, Forgery, ORIGIN, Provider, Trouble};

/// Time for a whole sign-in: the budget is 10 s.
const LONGEST: Duration = Duration::from_secs(11);

/// A school with its administrator.
async fn school(app: &App) -> Client {
    let school = app.school("North").await;
    app.member(school, Role::Administrator, HEAD).await;
    app.signed_in(HEAD).await
}

#[tokio::test]
async fn a_slow_or_endless_answer_is_cut_off() {
    let clock = fixed_clock();
    let mut providers = Vec::new();
    let mut troubles = Vec::new();
    for endpoint in [Endpoint::Keys, Endpoint::Token, Endpoint::Userinfo] {
        for trouble in [Trouble::Slow, Trouble::Endless] {
            providers.push(Provider::start(&clock).await);
            troubles.push(Forgery::At(endpoint, trouble));
        }
    }
    let app = app_for(&clock, &providers.iter().collect::<Vec<_>>()).await;
    let mut head = school(&app).await;
    let mut waiting = Vec::new();
    for (provider, trouble) in providers.iter().zip(troubles) {
        let id = add(&mut head, provider.issuer(), &[("name", &provider.address)]).await;
        provider.forge(trouble.clone());
        let mut browser = app.stranger();
        waiting.push(async move {
            let answer = timeout(LONGEST, flow(&mut browser, provider, &id)).await;
            answer.unwrap_or_else(|_| panic!("{trouble:?} took longer than {LONGEST:?}"))
        });
    }
    let count = waiting.len();
    for answer in join_all(waiting).await {
        assert!([403, 503].contains(&answer.status.as_u16()), "{}: {}", answer.status, answer.text());
    }
    let reasons = reasons(&app).await;
    assert_eq!(reasons.len(), count, "{reasons:?}");
    assert!(reasons.iter().all(|reason| ["unreachable", "malformed"].contains(&reason.as_str())), "{reasons:?}");
}

#[tokio::test]
async fn an_unreadable_discovery_document_adds_no_provider() {
    let clock = fixed_clock();
    let (provider, trap) = (Provider::start(&clock).await, Provider::start(&clock).await);
    let app = app_for(&clock, &[&provider, &trap]).await;
    let mut head = school(&app).await;
    let elsewhere = format!("{}/.well-known/openid-configuration", trap.issuer());
    for trouble in [
        Trouble::NotJson,
        Trouble::Broken,
        Trouble::Endless,
        Trouble::Slow,
        Trouble::RedirectTo(elsewhere),
        Trouble::RedirectTo("http://169.254.169.254/latest/meta-data/".to_owned()),
    ] {
        provider.forge(Forgery::At(Endpoint::Discovery, trouble.clone()));
        let answer = timeout(LONGEST, send_provider(&mut head, ADMIN, provider.issuer(), &[])).await;
        let answer = answer.unwrap_or_else(|_| panic!("{trouble:?} took longer than {LONGEST:?}"));
        assert_eq!(answer.status, 422, "{trouble:?}: {}", answer.text());
        assert!(answer.text().contains(provider.issuer()), "the form keeps its fields");
    }
    assert!(ids(&head.get(ADMIN).await.text()).is_empty());
    assert_eq!(trap.all_requests(), 0, "a redirect to another host was followed");
}

#[tokio::test]
async fn redirects_of_other_endpoints_are_not_followed() {
    let clock = fixed_clock();
    let trap = Provider::start(&clock).await;
    for endpoint in [Endpoint::Keys, Endpoint::Token, Endpoint::Userinfo] {
        let provider = Provider::start(&clock).await;
        let app = app_for(&clock, &[&provider, &trap]).await;
        let mut head = school(&app).await;
        let id = add(&mut head, provider.issuer(), &[]).await;
        for (n, target) in
            [format!("{}/keys", trap.issuer()), "http://169.254.169.254/".to_owned()].into_iter().enumerate()
        {
            provider.forge(Forgery::At(endpoint, Trouble::RedirectTo(target)));
            let mut browser = app.stranger();
            let answer = timeout(LONGEST, flow(&mut browser, &provider, &id)).await.expect("an answer in time");
            let reason = assert_refused(&app, &mut browser, &answer, n).await;
            assert!(["unreachable", "malformed", "code"].contains(&reason.as_str()), "{endpoint:?}: {reason}");
            app.state.clock.advance(61);
        }
    }
    assert_eq!(trap.all_requests(), 0);
}

#[tokio::test]
async fn addresses_of_the_inside_are_refused() {
    let clock = fixed_clock();
    let provider = Provider::start(&clock).await;
    let port = provider.address.rsplit(':').next().unwrap();
    let names = ["localhost", "127.0.0.1", "[::1]", "127.1", "2130706433", "[::ffff:127.0.0.1]", "0.0.0.0"];
    let plain_http = names.iter().map(|name| format!("{name}:{port}")).collect();
    let app = App::with(clock, |config| {
        config.public_url = Some(ORIGIN.to_owned());
        config.outgoing = OutgoingRules { plain_http, private_addresses: false };
    })
    .await;
    let mut head = school(&app).await;
    let inside = names.iter().map(|name| format!("http://{name}:{port}"));
    let further =
        ["https://169.254.169.254", "https://10.0.0.1", "https://[fe80::1]", "https://[fd00::1]", "https://224.0.0.1"];
    for issuer in inside.chain(further.map(str::to_owned)) {
        let answer = timeout(LONGEST, send_provider(&mut head, ADMIN, &issuer, &[])).await.expect("an answer in time");
        assert_eq!(answer.status, 422, "{issuer}: {}", answer.text());
    }
    assert_eq!(provider.all_requests(), 0);
}

#[tokio::test]
async fn plain_http_is_refused_unless_allowed() {
    let clock = fixed_clock();
    let provider = Provider::start(&clock).await;
    let app = App::with(clock, |config| config.outgoing.private_addresses = true).await;
    let mut head = school(&app).await;
    let answer = send_provider(&mut head, ADMIN, provider.issuer(), &[]).await;
    assert_eq!(answer.status, 422, "{}", answer.text());
    assert_eq!(provider.all_requests(), 0);
}

#[tokio::test]
async fn large_answers_are_bounded() {
    for forgery in [Forgery::ManyClaims, Forgery::ManyKeys] {
        let world = World::with(&[("addresses_verified", "true")]).await;
        world.invited(Role::Trainee, ADA, None).await;
        world.provider.forge(forgery.clone());
        let (mut browser, answer) =
            timeout(LONGEST, world.enter_anew()).await.unwrap_or_else(|_| panic!("{forgery:?} took too long"));
        if answer.status != 303 {
            assert_refused(&world.app, &mut browser, &answer, 0).await;
        }
        let largest = "SELECT CAST(coalesce(max(length(details)), 0) AS TEXT) FROM audit_log";
        let largest: usize = super::texts(&world.app, largest).await[0].parse().unwrap();
        assert!(largest < 2000, "{forgery:?}: {largest} bytes of claims in the audit log");
    }
}
