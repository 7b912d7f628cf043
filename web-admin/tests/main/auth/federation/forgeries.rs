//! Answers with one thing wrong. Fails when one of them signs a user in, or when the audit log names another reason.

use model::Role;

use super::{ADA, World, assert_refused, is_signed_in_as, reasons};
use crate::support::provider::{Endpoint, Forgery, Trouble};
use crate::support::signer::Algorithm;

/// Each forgery, with the reason for which it is refused.
fn table() -> [(Forgery, &'static str); 20] {
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
        (Forgery::EmptySubject, "subject"),
        (Forgery::NoSubject, "subject"),
        (Forgery::OtherSubjectAtUserinfo, "userinfo"),
        (Forgery::TwoParts, "malformed"),
        (Forgery::At(Endpoint::Token, Trouble::NotJson), "malformed"),
        (Forgery::At(Endpoint::Userinfo, Trouble::NotJson), "malformed"),
    ]
}

/// A world in which Ada, the provider's usual user, has an account without a password.
async fn world() -> (World, store::people::Person) {
    let world = World::with(&[("addresses_verified", "true")]).await;
    let ada = world.invited(Role::Trainee, ADA, None).await;
    (world, ada)
}

#[tokio::test]
async fn each_forgery_is_refused_for_its_own_reason() {
    let (world, ada) = world().await;
    for (n, (forgery, reason)) in table().into_iter().enumerate() {
        world.provider.forge(forgery.clone());
        let (mut browser, answer) = world.enter_anew().await;
        let found = assert_refused(&world.app, &mut browser, &answer, n).await;
        assert_eq!(found, reason, "{forgery:?}");
        // The limits on requests to an address and on new keys are by the minute.
        world.app.state.clock.advance(61);
    }
    assert_eq!(world.identities().await, Vec::<String>::new());
    world.provider.stop_forging();
    let (mut browser, answer) = world.enter_anew().await;
    assert_eq!((answer.status.as_u16(), answer.header("location")), (303, "/"), "{}", answer.text());
    assert!(is_signed_in_as(&mut browser, &ada).await);
    assert_eq!(reasons(&world.app).await.len(), table().len());
}

#[tokio::test]
async fn a_known_user_is_refused_by_the_same_forgeries() {
    let (world, _) = world().await;
    assert_eq!(world.enter_anew().await.1.header("location"), "/");
    for (n, forgery) in [Forgery::Nonce, Forgery::AnotherKey, Forgery::NoAlgorithm].into_iter().enumerate() {
        world.app.state.clock.advance(61);
        world.provider.forge(forgery);
        let (mut browser, answer) = world.enter_anew().await;
        assert_refused(&world.app, &mut browser, &answer, n).await;
    }
}

#[tokio::test]
async fn the_hash_of_another_access_token_is_refused() {
    let (world, _) = world().await;
    world.provider.forge(Forgery::AccessTokenHash);
    let (mut browser, answer) = world.enter_anew().await;
    assert_refused(&world.app, &mut browser, &answer, 0).await;
}

#[tokio::test]
async fn a_list_of_one_audience_is_accepted() {
    let (world, ada) = world().await;
    world.provider.forge(Forgery::AudienceInList);
    let (mut browser, answer) = world.enter_anew().await;
    assert_eq!(answer.header("location"), "/", "{:?}", reasons(&world.app).await);
    assert!(is_signed_in_as(&mut browser, &ada).await);
}

#[tokio::test]
async fn every_accepted_algorithm_signs_in() {
    let (world, ada) = world().await;
    for algorithm in Algorithm::ALL {
        world.provider.add_key(algorithm.name(), algorithm);
        let (mut browser, answer) = world.enter_anew().await;
        assert_eq!(answer.header("location"), "/", "{algorithm:?}: {:?}", reasons(&world.app).await);
        assert!(is_signed_in_as(&mut browser, &ada).await, "{algorithm:?}");
        world.app.state.clock.advance(61);
    }
}
