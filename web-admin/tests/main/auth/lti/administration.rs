//! The pages on which administrators register learning platforms, and the limits. Fails when a registration is added that cannot be right or
//! exists already, when another school sees or changes it, or when the launches of one platform hinder those of another.

use acts::auth::rate_limits;
use model::Role;
use model::ids::PlatformId;

use super::{ADA, ADMIN, CLIENT, HEAD, World, login, send_platform};
use crate::auth::federation::texts;
use crate::support::client::csrf_in;
use crate::support::learning_platform::LaunchMessage;

#[tokio::test]
async fn a_form_that_cannot_be_right_adds_no_platform() {
    let mut world = World::new().await;
    let long = "x".repeat(100_000);
    for (field, value) in [
        ("name", ""),
        ("client_id", ""),
        ("issuer", ""),
        ("issuer", "https://lms.example.edu two"),
        ("auth_url", ""),
        ("auth_url", "javascript:alert(1)"),
        ("auth_url", "http://lms.example.edu/auth"),
        ("token_url", "ftp://lms.example.edu/"),
        ("keys_url", "https://user:secret@lms.example.edu/keys"),
        ("keys_url", "file:///etc/passwd"),
        ("number_claim", "email"),
        ("name", &long),
    ] {
        let changes = [("client_id", "another"), (field, value)];
        let answer = send_platform(&mut world.head, ADMIN, &world.platform, &changes).await;
        let value = value.get(..40).unwrap_or(value);
        assert!([413, 422].contains(&answer.status.as_u16()), "{field} {value}: {}", answer.status);
    }
    assert_eq!(texts(&world.app, "SELECT client_id FROM platforms").await, [CLIENT]);
}

#[tokio::test]
async fn a_registration_exists_once_over_all_schools() {
    let mut world = World::new().await;
    let again = send_platform(&mut world.head, ADMIN, &world.platform, &[("name", "Again")]).await;
    assert_eq!(again.status, 422, "{}", again.text());
    let south = world.app.school("South").await;
    world.app.member(south, Role::Administrator, "head@south.example").await;
    let mut abroad = world.app.signed_in("head@south.example").await;
    assert_eq!(send_platform(&mut abroad, ADMIN, &world.platform, &[]).await.status, 422);
    let own = format!("{ADMIN}/{}", world.id);
    assert_eq!(abroad.get(&own).await.status, 404);
    assert!(!abroad.get(ADMIN).await.text().contains(&world.id));
    let csrf = csrf_in(&abroad.get(ADMIN).await.text());
    let refused = world.launch_anew(&LaunchMessage::by("x").with_lti("deployment_id", "2")).await.1;
    assert_eq!(super::refusal(&refused), "deployment");
    for act in ["admit", "disable", "enable"] {
        let answer = abroad.form(&format!("{own}/{act}"), &[("csrf", &csrf), ("deployment", "2")]).await;
        assert_eq!(answer.status, 404, "{act}");
    }
    let changed = abroad.form(&own, &[("csrf", &csrf), ("name", "x")]).await;
    assert!(changed.status.is_client_error(), "{}", changed.status);
    assert!(world.head.get(ADMIN).await.text().contains("1 deployment waits to be admitted"));
    world.admit("2").await;
}

#[tokio::test]
async fn only_administrators_register_platforms() {
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
        for act in ["", "/admit", "/disable", "/enable"] {
            let answer = client.form(&format!("{own}{act}"), &[("csrf", &csrf), ("deployment", "1")]).await;
            assert_eq!(answer.status, 403, "{email} {act}");
        }
    }
}

#[tokio::test]
async fn the_page_shows_what_to_enter_and_keeps_what_was_typed() {
    let mut world = World::new().await;
    let page = world.head.get(ADMIN).await.text();
    for entry in ["/lti/login", "/lti/launch", "/.well-known/jwks.json"] {
        assert!(page.contains(&format!("https://training.example.org{entry}")), "{entry}");
    }
    let own = format!("{ADMIN}/{}", world.id);
    let changes =
        [("name", "Moodle <b>"), ("number_claim", "student_number"), ("token_audience", "https://aud.example")];
    let changed = send_platform(&mut world.head, &own, &world.platform, &changes).await;
    assert_eq!(changed.header("location"), ADMIN);
    let page = world.head.get(&own).await.text();
    for kept in
        ["Moodle &#60;b&#62;", "value=\"student_number\" selected", "https://aud.example", &world.platform.auth_url()]
    {
        assert!(page.contains(kept), "{kept} in {page}");
    }
    let acts = "SELECT action FROM audit_log WHERE action LIKE 'platform.%' ORDER BY seq";
    assert_eq!(texts(&world.app, acts).await, ["platform.added", "platform.deployment_admitted", "platform.changed"]);
    for (act, action) in [("disable", "platform.disabled"), ("enable", "platform.enabled")] {
        assert_eq!(world.act(act).await.status, 303);
        assert_eq!(texts(&world.app, acts).await.last().unwrap(), action);
    }
}

#[tokio::test]
async fn many_launches_of_one_platform_hinder_no_other() {
    let mut world = World::with(&[("creates_trainees", "true")]).await;
    let own: PlatformId = world.id.parse().unwrap();
    let mut taken = 0;
    while rate_limits::take_launch(&world.app.state, own).await.is_ok() {
        taken += 1;
    }
    assert!((300..1000).contains(&taken), "{taken} launches in a minute");
    let (_, limited) = world.launch_anew(&LaunchMessage::by("ada")).await;
    assert_eq!(limited.status, 429, "{}", limited.text());
    assert!(!limited.header("retry-after").is_empty());
    assert_eq!(world.identities().await, Vec::<String>::new());

    let changes = [("client_id", "client-2"), ("creates_trainees", "true")];
    let other = super::add(&mut world.head, &world.platform, &changes).await;
    let mut browser = world.app.stranger();
    let begun = browser.get(&login(&[("client_id", "client-2")])).await;
    let url = super::authorize_url(&begun);
    let answer = super::post(&mut browser, &world.platform.confirm(&url, &LaunchMessage::by("ada"))).await;
    assert_eq!(super::refusal(&answer), "deployment", "the launch itself is taken");
    assert_ne!(other, world.id);
    world.clock().advance(2);
    assert_eq!(world.launch_anew(&LaunchMessage::by("ada")).await.1.header("location"), "/");
}

#[tokio::test]
async fn logins_from_one_address_are_limited() {
    let world = World::new().await;
    let mut statuses = Vec::new();
    for _ in 0..520 {
        let status = world.app.stranger().get(&login(&[])).await.status.as_u16();
        statuses.push(status);
        if status != 200 {
            break;
        }
    }
    assert_eq!(statuses.last(), Some(&429), "{}", statuses.len());
    assert!(statuses.len() > 300, "a lecture of 300 people gets in: {}", statuses.len());
    assert_eq!(world.app.signed_in(HEAD).await.get(ADMIN).await.status, 200, "other pages are answered");
}
