//! The pages on which administrators configure providers and local passwords. Fails when a provider is added that cannot be right, when the
//! client secret is shown or readable in the database, when trying a provider signs somebody in, or when nobody can sign in any more.

use model::Role;

use super::{
    ADA, ADMIN, HEAD, World, authorize_url, flow, ids, is_signed_in, is_signed_in_as, press, reasons, send_provider,
    texts,
};
use crate::support::PASSWORD;
use crate::support::client::csrf_in;
use crate::support::database::rows_of;
use crate::support::provider::{CLIENT_SECRET, Endpoint, User};

#[tokio::test]
async fn a_form_that_cannot_be_right_adds_no_provider() {
    let mut world = World::new().await;
    let before = ids(&world.head.get(ADMIN).await.text());
    let issuer = world.provider.issuer().to_owned();
    let long = "x".repeat(100_000);
    for (field, value) in [
        ("name", ""),
        ("client_id", ""),
        ("client_secret", ""),
        ("subject_claim", ""),
        ("issuer", ""),
        ("issuer", "provider.example.org"),
        ("issuer", "ftp://provider.example.org"),
        ("issuer", "https://user:secret@provider.example.org"),
        ("creates", "administrator"),
        ("creates", "instructor"),
        ("role_map", "staff = administrator"),
        ("role_map", "staff"),
        ("name", &long),
    ] {
        let changes = [("client_id", "another"), ("role_claim", "affiliation"), (field, value)];
        let answer = send_provider(&mut world.head, ADMIN, &issuer, &changes).await;
        let value = value.get(..40).unwrap_or(value);
        assert!([400, 413, 422].contains(&answer.status.as_u16()), "{field} {value}: {}", answer.status);
    }
    assert_eq!(ids(&world.head.get(ADMIN).await.text()), before);
}

#[tokio::test]
async fn the_discovered_issuer_equals_the_typed_one() {
    let mut world = World::new().await;
    let before = ids(&world.head.get(ADMIN).await.text());
    let issuer = world.provider.issuer().to_owned();
    for typed in [format!("{issuer}/"), issuer.replace("http", "HTTP"), format!("{issuer}/realms/main")] {
        let answer = send_provider(&mut world.head, ADMIN, &typed, &[("client_id", "another")]).await;
        assert_eq!(answer.status, 422, "{typed}: {}", answer.text());
    }
    assert_eq!(ids(&world.head.get(ADMIN).await.text()), before);
}

#[tokio::test]
async fn one_client_of_an_issuer_is_added_once() {
    let mut world = World::new().await;
    let issuer = world.provider.issuer().to_owned();
    let again = send_provider(&mut world.head, ADMIN, &issuer, &[("name", "Again")]).await;
    assert!([409, 422].contains(&again.status.as_u16()), "{}: {}", again.status, again.text());
    assert_eq!(ids(&world.head.get(ADMIN).await.text()).len(), 1);
}

#[tokio::test]
async fn only_administrators_configure_providers() {
    let world = World::new().await;
    world.app.member(world.school, Role::Instructor, "teacher@example.org").await;
    world.app.member(world.school, Role::Trainee, ADA).await;
    let own = format!("{ADMIN}/{}", world.id);
    for email in ["teacher@example.org", ADA] {
        let mut client = world.app.signed_in(email).await;
        let csrf = csrf_in(&client.get("/account").await.text());
        for path in [ADMIN, &own] {
            assert_eq!(client.get(path).await.status, 403, "{email} {path}");
        }
        for act in ["", "/try", "/disable", "/enable"] {
            let answer = client.form(&format!("{own}{act}"), &[("csrf", &csrf)]).await;
            assert_eq!(answer.status, 403, "{email} {act}");
        }
        let local = [("csrf", csrf.as_str()), ("local", "administrators")];
        assert_eq!(client.form(&format!("{ADMIN}/local"), &local).await.status, 403, "{email}");
    }
}

#[tokio::test]
async fn the_client_secret_is_kept_and_shown_nowhere() {
    let mut world = World::with(&[("addresses_verified", "true")]).await;
    world.invited(Role::Trainee, ADA, None).await;
    let own = format!("{ADMIN}/{}", world.id);
    let issuer = world.provider.issuer().to_owned();
    let changes = [("name", "Hospital"), ("client_secret", ""), ("addresses_verified", "true")];
    let changed = send_provider(&mut world.head, &own, &issuer, &changes).await;
    assert_eq!(changed.status, 303, "{}", changed.text());
    for path in [ADMIN, &own, "/admin/audit"] {
        let page = world.head.get(path).await.text();
        assert!(!page.contains(CLIENT_SECRET) && !page.contains("a secret/"), "{path}");
    }
    assert!(world.head.get(&own).await.text().contains("Hospital"));
    let hex: String = CLIENT_SECRET.bytes().map(|byte| format!("{byte:02X}")).collect();
    for table in ["sign_in_providers", "audit_log"] {
        for row in rows_of(&world.app.state.db, table).await {
            assert!(!row.contains(CLIENT_SECRET) && !row.to_uppercase().contains(&hex), "{row}");
        }
    }
    assert_eq!(world.enter_anew().await.1.header("location"), "/", "the old secret still authenticates");
    let wrong = [("client_secret", "another secret"), ("addresses_verified", "true")];
    assert_eq!(send_provider(&mut world.head, &own, &issuer, &wrong).await.status, 303);
    let (mut browser, answer) = world.enter_anew().await;
    assert_eq!(super::assert_refused(&world.app, &mut browser, &answer, 0).await, "code");
}

#[tokio::test]
async fn trying_a_provider_shows_claims_and_signs_nobody_in() {
    let mut world = World::with(&[("addresses_verified", "true"), ("creates", "trainee")]).await;
    world.invited(Role::Trainee, ADA, None).await;
    world.app.keep_time_zone(world.school, "Europe/Berlin").await;
    let user = User::new("ada", ADA).with("eduperson_affiliation", "<b>student</b>");
    world.provider.set_user(user);
    let begun = world.act("try").await;
    let address = world.provider.log_in(&authorize_url(&begun));
    let shown = world.head.get(&address).await;
    assert_eq!(shown.status, 200, "{}", shown.text());
    let page = shown.text();
    for wanted in [ADA, "eduperson_affiliation", "Name of ada", "student", "Europe/Berlin"] {
        assert!(page.contains(wanted), "{wanted} in {page}");
    }
    assert!(!page.contains("<b>student") && !page.contains("eyJ") && !page.contains("access-"), "{page}");
    assert_eq!(world.identities().await, Vec::<String>::new());
    assert_eq!(world.head.get(ADMIN).await.status, 200, "the administrator stays signed in");
    assert_eq!(texts(&world.app, "SELECT display_name FROM people").await.len(), 2);
}

#[tokio::test]
async fn a_trial_works_in_the_administrators_browser_alone() {
    let mut world = World::with(&[("addresses_verified", "true")]).await;
    world.invited(Role::Trainee, ADA, None).await;
    let begun = world.act("try").await;
    let address = world.provider.log_in(&authorize_url(&begun));
    let mut eve = world.app.stranger();
    eve.get("/login").await;
    let answer = eve.get(&address).await;
    assert_eq!(super::assert_refused(&world.app, &mut eve, &answer, 0).await, "no_flow");
    assert!(!answer.text().contains(ADA));
}

#[tokio::test]
async fn local_passwords_may_be_for_administrators_alone() {
    let mut world = World::with(&[("addresses_verified", "true")]).await;
    let ada = world.invited(Role::Trainee, ADA, None).await;
    for (role, email) in [(Role::Trainee, "ben@example.org"), (Role::Instructor, "teacher@example.org")] {
        world.app.member(world.school, role, email).await;
    }
    assert!(!world.app.stranger().get("/login").await.text().contains("<details"));
    for nonsense in ["nobody", "", "trainee"] {
        let answer = world.set_local(nonsense).await;
        assert!([400, 422].contains(&answer.status.as_u16()), "{nonsense}: {}", answer.status);
    }
    assert_eq!(world.set_local("administrators").await.header("location"), ADMIN);
    let page = world.app.stranger().get("/login").await.text();
    assert!(page.contains("<details") && page.contains("name=\"password\""), "{page}");
    for email in ["ben@example.org", "teacher@example.org"] {
        let mut client = world.app.stranger();
        let answer = client.sign_in(email, PASSWORD).await;
        assert!(answer.status.is_client_error() && !is_signed_in(&mut client).await, "{email}: {}", answer.status);
    }
    assert_eq!(world.app.stranger().sign_in(HEAD, PASSWORD).await.header("location"), "/");
    let (mut browser, answer) = world.enter_anew().await;
    assert_eq!(answer.header("location"), "/");
    assert!(is_signed_in_as(&mut browser, &ada).await);
    assert_eq!(world.set_local("everybody").await.header("location"), ADMIN);
    assert_eq!(world.app.stranger().sign_in("ben@example.org", PASSWORD).await.header("location"), "/");
}

#[tokio::test]
async fn local_passwords_of_another_school_stay_open() {
    let mut world = World::new().await;
    let south = world.app.school("South").await;
    world.app.member(south, Role::Trainee, "cat@south.example").await;
    assert_eq!(world.set_local("administrators").await.status, 303);
    assert_eq!(world.app.stranger().sign_in("cat@south.example", PASSWORD).await.header("location"), "/");
}

#[tokio::test]
async fn a_changed_issuer_takes_no_identity_along() {
    let mut world = World::with(&[("addresses_verified", "true")]).await;
    world.invited(Role::Trainee, ADA, None).await;
    assert_eq!(world.enter_anew().await.1.header("location"), "/");
    let own = format!("{ADMIN}/{}", world.id);
    let elsewhere = format!("{}/", world.provider.issuer());
    let refused = send_provider(&mut world.head, &own, &elsewhere, &[("addresses_verified", "true")]).await;
    assert_eq!(refused.status, 422, "{}", refused.text());
    assert_eq!(world.enter_anew().await.1.header("location"), "/", "unchanged");
    assert_eq!(reasons(&world.app).await, Vec::<String>::new());
}

#[tokio::test]
async fn every_change_of_a_provider_is_in_the_audit_log() {
    let mut world = World::new().await;
    let count = async |world: &World| texts(&world.app, "SELECT action FROM audit_log").await.len();
    let mut before = count(&world).await;
    for act in ["disable", "enable"] {
        assert_eq!(world.act(act).await.status, 303);
        let after = count(&world).await;
        assert_eq!(after, before + 1, "{act}");
        before = after;
    }
    assert_eq!(world.set_local("administrators").await.status, 303);
    assert_eq!(count(&world).await, before + 1);
}

#[tokio::test]
async fn an_unknown_provider_starts_nothing() {
    let world = World::new().await;
    for id in ["0", "callback", "00000000-0000-4000-8000-000000000000"] {
        let mut browser = world.app.stranger();
        let answer = press(&mut browser, id, "/").await;
        assert!(answer.status != 200 && answer.header("refresh").is_empty(), "{id}: {}", answer.status);
    }
    let before = world.provider.requests(Endpoint::Token);
    let mut browser = world.app.stranger();
    flow(&mut browser, &world.provider, &world.id).await;
    assert_eq!(world.provider.requests(Endpoint::Token), before + 1);
}
