//! Identities of a person, and what ends them. Fails when the last way in can be removed, when an identity changes its owner, when a disabled
//! person gets in, or when a second factor is left out.

use model::Role;

use super::{ADA, World, assert_refused, authorize_url, is_signed_in, is_signed_in_as, texts};
use crate::auth::second_factors::{enrol, say_code, send};
use crate::support::client::{Answer, Client, csrf_in};
use crate::support::provider::User;
use crate::support::{App, Member};

const PAGE: &str = "/account/identities";
const TRUSTED: (&str, &str) = ("addresses_verified", "true");

/// Joins the identity of the provider's user to the account that a browser is signed in to; the answer to the callback.
async fn join(world: &World, browser: &mut Client) -> Answer {
    let action = format!("{PAGE}/join/{}", world.id);
    let begun = send(browser, PAGE, &action, &[]).await;
    browser.get(&world.provider.log_in(&authorize_url(&begun))).await
}

/// Ids of the identities that the page of a person offers to remove.
fn removable(page: &str) -> Vec<String> {
    let start = format!("action=\"{PAGE}/");
    let actions = page.split(&start).skip(1).filter_map(|rest| rest.split('"').next());
    actions.filter_map(|action| action.strip_suffix("/remove")).map(str::to_owned).collect()
}

/// A person with a password whose identity is joined, and their browser.
async fn joined(world: &World) -> (Member, Client) {
    let ada = world.app.member(world.school, Role::Trainee, ADA).await;
    let mut browser = world.app.signed_in(ADA).await;
    let answer = join(world, &mut browser).await;
    assert_eq!((answer.status.as_u16(), answer.header("location")), (303, PAGE), "{}", answer.text());
    (ada, browser)
}

#[tokio::test]
async fn a_person_joins_and_removes_an_identity() {
    let world = World::new().await;
    let (ada, mut browser) = joined(&world).await;
    assert_eq!(world.identities().await, ["joined ada"]);
    let page = browser.get(PAGE).await.text();
    let listed = removable(&page);
    let [id] = &listed[..] else { panic!("one identity is listed: {page}") };
    assert!(page.contains("University"), "{page}");
    let (mut elsewhere, answer) = world.enter_anew().await;
    assert_eq!(answer.header("location"), "/");
    assert!(is_signed_in_as(&mut elsewhere, &ada.person).await);
    let removed = send(&mut browser, PAGE, &format!("{PAGE}/{id}/remove"), &[]).await;
    assert_eq!(removed.status, 303, "{}", removed.text());
    assert_eq!(world.identities().await, Vec::<String>::new());
    assert!(!is_signed_in(&mut elsewhere).await, "a sign-in by a removed identity ends");
    assert_eq!(world.enter_anew().await.1.header("location"), "/sign-in/join");
}

#[tokio::test]
async fn the_last_way_in_is_not_removed() {
    let world = World::with(&[TRUSTED]).await;
    let ada = world.invited(Role::Trainee, ADA, None).await;
    let (mut browser, answer) = world.enter_anew().await;
    assert_eq!(answer.header("location"), "/");
    let id: String = only_identity(&world.app).await;
    let refused = send(&mut browser, "/account", &format!("{PAGE}/{id}/remove"), &[]).await;
    assert!([409, 422].contains(&refused.status.as_u16()), "{}: {}", refused.status, refused.text());
    assert_eq!(world.identities().await.len(), 1);
    assert!(is_signed_in_as(&mut world.enter_anew().await.0, &ada).await);
}

/// The id of the only identity, as an address carries it.
async fn only_identity(app: &App) -> String {
    let id: uuid::Uuid =
        sqlx::query_scalar("SELECT id FROM identities").fetch_one(app.state.db.reader()).await.unwrap();
    id.to_string()
}

#[tokio::test]
async fn an_identity_of_another_person_is_left_alone() {
    let world = World::new().await;
    let (ada, _) = joined(&world).await;
    world.app.member(world.school, Role::Trainee, "ben@example.org").await;
    let mut ben = world.app.signed_in("ben@example.org").await;
    let answer = join(&world, &mut ben).await;
    assert!(answer.status.is_client_error(), "{}: {}", answer.status, answer.text());
    let id = only_identity(&world.app).await;
    let removed = send(&mut ben, PAGE, &format!("{PAGE}/{id}/remove"), &[]).await;
    assert_eq!(removed.status, 404, "{}", removed.text());
    assert_eq!(world.identities().await, ["joined ada"]);
    assert!(is_signed_in_as(&mut world.enter_anew().await.0, &ada.person).await);
}

#[tokio::test]
async fn a_flow_to_join_ends_in_the_account_that_began_it() {
    let world = World::new().await;
    world.app.member(world.school, Role::Trainee, ADA).await;
    world.app.member(world.school, Role::Trainee, "ben@example.org").await;
    let mut browser = world.app.signed_in(ADA).await;
    let begun = send(&mut browser, PAGE, &format!("{PAGE}/join/{}", world.id), &[]).await;
    let address = world.provider.log_in(&authorize_url(&begun));
    // Another person signs in on the same machine before the provider answers.
    let csrf = csrf_in(&browser.get("/account").await.text());
    browser.form("/logout", &[("csrf", &csrf)]).await;
    browser.sign_in("ben@example.org", crate::support::PASSWORD).await;
    let answer = browser.get(&address).await;
    assert!(answer.status.is_client_error(), "{}: {}", answer.status, answer.text());
    assert_eq!(world.identities().await, Vec::<String>::new());
}

#[tokio::test]
async fn a_disabled_person_is_refused() {
    let mut world = World::with(&[TRUSTED]).await;
    let ada = world.invited(Role::Trainee, ADA, None).await;
    assert_eq!(world.enter_anew().await.1.header("location"), "/");
    let page = format!("/people/{}", ada.id);
    let disabled = send(&mut world.head, &page, &format!("{page}/disable"), &[]).await;
    assert_eq!(disabled.status, 303, "{}", disabled.text());
    let (mut browser, answer) = world.enter_anew().await;
    assert_eq!(assert_refused(&world.app, &mut browser, &answer, 0).await, "disabled");
}

#[tokio::test]
async fn erasing_a_person_erases_their_identities() {
    let mut world = World::new().await;
    let (ada, mut browser) = joined(&world).await;
    let export = browser.get("/account/export").await.text();
    assert!(export.contains(world.provider.issuer()), "the export lists identities: {export}");
    let page = format!("/people/{}", ada.person.id);
    let erased = send(&mut world.head, &page, &format!("{page}/erase"), &[("confirm", ADA)]).await;
    assert_eq!(erased.status, 303, "{}", erased.text());
    assert_eq!(world.identities().await, Vec::<String>::new());
    assert_eq!(world.enter_anew().await.1.header("location"), "/sign-in/join");
}

#[tokio::test]
async fn a_second_factor_is_asked_for_after_the_provider() {
    let world = World::new().await;
    let (ada, mut here) = joined(&world).await;
    let device = enrol(&world.app, &mut here).await;
    world.provider.set_user(User { amr: vec!["mfa"], ..User::new("ada", ADA) });
    let (mut browser, answer) = world.enter_anew().await;
    assert_eq!((answer.status.as_u16(), answer.header("location")), (303, "/login/code"), "not trusted for it");
    assert!(!is_signed_in(&mut browser).await);
    let entered = say_code(&mut browser, &device.code(&world.app)).await;
    assert_eq!((entered.status.as_u16(), entered.header("location")), (303, "/"), "{}", entered.text());
    assert!(is_signed_in_as(&mut browser, &ada.person).await);
}

#[tokio::test]
async fn a_trusted_second_factor_is_not_asked_for_again() {
    let world = World::with(&[("second_factor_trusted", "true")]).await;
    let (ada, mut here) = joined(&world).await;
    enrol(&world.app, &mut here).await;
    for (amr, is_enough) in [
        (vec![], false),
        (vec!["pwd"], false),
        (vec!["pwd", "sms"], false),
        (vec!["pwd", "mfa"], true),
        (vec!["hwk"], true),
        (vec!["swk"], true),
        (vec!["otp"], true),
        (vec!["fpt"], true),
        (vec!["face"], true),
    ] {
        world.provider.set_user(User { amr: amr.clone(), ..User::new("ada", ADA) });
        let (mut browser, answer) = world.enter_anew().await;
        let expected = if is_enough { "/" } else { "/login/code" };
        assert_eq!(answer.header("location"), expected, "{amr:?}");
        assert_eq!(is_signed_in_as(&mut browser, &ada.person).await, is_enough, "{amr:?}");
        world.app.state.clock.advance(61);
    }
}

#[tokio::test]
async fn a_listed_acr_counts_as_a_second_factor() {
    let listed = ("second_factor_acr", " urn:example:strong \r\n\r\nhttps://refeds.org/profile/mfa");
    for (changes, acr, is_enough) in [
        (&[("second_factor_trusted", "true"), listed][..], "https://refeds.org/profile/mfa", true),
        (&[("second_factor_trusted", "true"), listed], "urn:example:strong", true),
        (&[("second_factor_trusted", "true"), listed], "urn:example:strong2", false),
        (&[("second_factor_trusted", "true")], "urn:example:strong", false),
        (&[listed], "urn:example:strong", false),
    ] {
        let world = World::with(changes).await;
        let (ada, mut here) = joined(&world).await;
        enrol(&world.app, &mut here).await;
        world.provider.set_user(User::new("ada", ADA).with("acr", acr));
        let (mut browser, _) = world.enter_anew().await;
        assert_eq!(is_signed_in_as(&mut browser, &ada.person).await, is_enough, "{changes:?}, {acr}");
    }
}

#[tokio::test]
async fn a_trusted_second_factor_is_none_that_is_owed() {
    let mut world = World::with(&[("second_factor_trusted", "true"), ("addresses_verified", "true")]).await;
    let ada = world.invited(Role::Trainee, ADA, None).await;
    let csrf = csrf_in(&world.head.get("/admin/sign-in").await.text());
    let ruled = world.head.form("/admin/second-factor", &[("csrf", &csrf), ("rule", "everybody")]).await;
    assert_eq!(ruled.status, 303, "{}", ruled.text());
    for (amr, is_enough) in [(vec!["pwd"], false), (vec!["pwd", "otp"], true)] {
        world.provider.set_user(User { amr, ..User::new("ada", ADA) });
        let (mut browser, _) = world.enter_anew().await;
        assert_eq!(is_signed_in_as(&mut browser, &ada).await, is_enough);
    }
    let query = "SELECT details FROM audit_log WHERE action = 'person.signed_in' AND details <> '{}'";
    assert_eq!(texts(&world.app, query).await, [r#"{"second_factor":"provider"}"#], "one sign-in had a second factor");
}

#[tokio::test]
async fn joining_by_password_asks_for_the_second_factor() {
    let world = World::new().await;
    world.app.member(world.school, Role::Trainee, ADA).await;
    let device = enrol(&world.app, &mut world.app.signed_in(ADA).await).await;
    let (mut browser, answer) = world.enter_anew().await;
    assert_eq!(answer.header("location"), "/sign-in/join");
    let fields = [("email", ADA), ("password", crate::support::PASSWORD)];
    let half = send(&mut browser, "/sign-in/join", "/sign-in/join", &fields).await;
    assert_eq!((half.status.as_u16(), half.header("location")), (303, "/login/code"), "{}", half.text());
    assert!(!is_signed_in(&mut browser).await);
    assert_eq!(say_code(&mut browser, &device.code(&world.app)).await.status, 303);
    assert!(is_signed_in(&mut browser).await);
}
