//! The way to the platform and back. Fails when a launch is accepted that this browser has not begun, that was used or is over, and when another
//! page than the one that opens a window may be shown in a frame.

use model::Role;

use super::{ADA, CLIENT, World, frame_ancestors, get_framed, login, post, refusal};
use crate::auth::federation::{authorize_url, is_signed_in, is_signed_in_as};
use crate::support::learning_platform::{ISSUER, LaunchMessage};
use crate::support::provider::{ORIGIN, parameters};

#[tokio::test]
async fn a_launch_leads_to_the_platform_and_back() {
    let world = World::with(&[("creates_trainees", "true")]).await;
    let mut browser = world.app.stranger();
    let begun = browser.get(&login(&[])).await;
    let url = authorize_url(&begun);
    let asked = world.platform.check(&url);
    assert_eq!((asked["client_id"].as_str(), asked["login_hint"].as_str()), (CLIENT, "user-7"));
    assert_eq!(asked["lti_message_hint"], "message-9");
    let cookies: Vec<_> = begun.headers.get_all("set-cookie").iter().map(|set| set.to_str().unwrap()).collect();
    let cookie = cookies.iter().find(|set| set.starts_with(&format!("__Host-lti-{}=", &asked["state"][..8]))).unwrap();
    for attribute in ["HttpOnly", "SameSite=None", "Secure", "Partitioned", "Path=/", "Max-Age=600"] {
        assert!(cookie.contains(attribute), "{attribute} in {cookie}");
    }
    assert!(!cookie.contains(&asked["state"]) && !url.contains(cookie.split(['=', ';']).nth(1).unwrap()));

    let back = post(&mut browser, &world.platform.confirm(&url, &LaunchMessage::by("ada"))).await;
    assert_eq!((back.status.as_u16(), back.header("location")), (303, "/"), "{}", back.text());
    assert!(browser.get("/account").await.text().contains("Name of ada"));
    assert_eq!(world.identities().await, ["lti created ada"]);
    assert!(browser.cookie_named(&asked["state"][..8]).is_none(), "the cookie of the launch is removed");
    assert_eq!(world.reasons().await, Vec::<String>::new());

    let (mut elsewhere, again) = world.launch_anew(&LaunchMessage::by("ada")).await;
    assert!(again.header("location") == "/" && is_signed_in(&mut elsewhere).await);
    assert_eq!(world.identities().await.len(), 1);
}

#[tokio::test]
async fn a_launch_may_be_begun_by_a_form_or_without_client_id() {
    let world = World::with(&[("creates_trainees", "true")]).await;
    let target = format!("{ORIGIN}/lti/launch");
    let mut browser = world.app.stranger();
    let fields = [("iss", ISSUER), ("login_hint", "7"), ("target_link_uri", target.as_str())];
    let url = authorize_url(&browser.form("/lti/login", &fields).await);
    assert!(!parameters(&url).contains_key("lti_message_hint"), "{url}");
    let back = post(&mut browser, &world.platform.confirm(&url, &LaunchMessage::by("ada"))).await;
    assert!(back.header("location") == "/" && is_signed_in(&mut browser).await, "{}", back.text());
}

#[tokio::test]
async fn the_page_is_the_one_that_the_link_names() {
    let world = World::with(&[("creates_trainees", "true")]).await;
    world.app.publish(world.school).await;
    let exercise = "/exercises/feel-the-layers";
    let whole = format!("{ORIGIN}{exercise}");
    let by = || LaunchMessage::by("ada");
    for (message, page) in [
        (by().with_lti("custom", serde_json::json!({ "stylet": exercise })), exercise),
        (by().with_lti("custom", serde_json::json!({ "stylet": "/curricula" })), "/curricula"),
        (by().with_lti("custom", serde_json::json!({ "stylet": "//evil.example/x" })), "/"),
        (by().with_lti("target_link_uri", whole.as_str()), exercise),
        (by().with_lti("target_link_uri", format!("{ORIGIN}/admin/settings")), "/"),
    ] {
        let (mut browser, back) = world.launch_anew(&message).await;
        assert_eq!(back.header("location"), page, "{message:?}: {}", back.text());
        assert_eq!(browser.get(page).await.status, 200, "{page}");
    }
}

#[tokio::test]
async fn in_a_frame_one_page_opens_a_window() {
    let mut world = World::with(&[("creates_trainees", "true")]).await;
    let mut framed = world.app.stranger();
    let page = get_framed(&mut framed, &login(&[])).await;
    assert_eq!(page.status, 200);
    assert_eq!(frame_ancestors(&page), format!("http://{}", world.platform.address));
    assert!(page.headers.get("refresh").is_none() && page.headers.get("set-cookie").is_none(), "{:?}", page.headers);
    let html = page.text();
    assert!(html.contains("target=\"_blank\"") && html.matches("<form").count() == 1, "{html}");
    for (name, value) in
        [("iss", ISSUER), ("client_id", CLIENT), ("login_hint", "user-7"), ("lti_message_hint", "message-9")]
    {
        assert!(html.contains(&format!("name=\"{name}\" value=\"{value}\"")), "{name}: {html}");
    }

    let (mut browser, _) = world.launch_anew(&LaunchMessage::by("ada")).await;
    for path in ["/", "/login", "/account", "/assets/none", "/lti/login?iss=unknown"] {
        let answer = get_framed(&mut browser, path).await;
        assert_eq!(frame_ancestors(&answer), "'none'", "{path}");
    }
    assert_eq!(frame_ancestors(&browser.get(&login(&[])).await), "'none'", "the page outside of a frame");
    assert_eq!(world.act("disable").await.status, 303);
    assert_eq!(refusal(&browser.get(&login(&[])).await), "disabled");
}

#[tokio::test]
async fn without_its_cookie_a_launch_begins_anew() {
    let world = World::with(&[("creates_trainees", "true")]).await;
    for broken in [None, Some("__Host-lti-00000000=0"), Some("")] {
        let mut browser = world.app.stranger();
        let url = world.begin(&mut browser).await;
        let fields = world.platform.confirm(&url, &LaunchMessage::by("ada"));
        browser.cookie = broken.map(str::to_owned).filter(|cookie| !cookie.is_empty());
        let page = post(&mut browser, &fields).await;
        assert_eq!((page.status.as_u16(), page.header("location")), (200, ""));
        assert_eq!(frame_ancestors(&page), format!("http://{}", world.platform.address));
        let html = page.text();
        assert!(
            html.contains("value=\"user-7\"") && html.contains("value=\"message-9\"") && !html.contains("eyJ"),
            "{html}"
        );
        assert!(!is_signed_in(&mut browser).await);
        assert_eq!(refusal(&post(&mut browser, &fields).await), "no_flow", "used up");
    }
    assert_eq!(world.identities().await, Vec::<String>::new());
    assert_eq!(world.reasons().await, Vec::<String>::new(), "nothing was believed, nothing refused");
}

#[tokio::test]
async fn a_launch_of_another_browser_is_worth_nothing() {
    let world = World::with(&[("creates_trainees", "true")]).await;
    let (mut own, mut other) = (world.app.stranger(), world.app.stranger());
    let url = world.begin(&mut own).await;
    world.begin(&mut other).await;
    let fields = world.platform.confirm(&url, &LaunchMessage::by("eve"));
    let answer = post(&mut other, &fields).await;
    assert!(answer.status == 200 && !is_signed_in(&mut other).await, "the page that opens a window");
    assert_eq!(refusal(&post(&mut own, &fields).await), "no_flow");
    assert!(!is_signed_in(&mut own).await);
    assert_eq!(world.identities().await, Vec::<String>::new());
}

#[tokio::test]
async fn a_launch_is_good_once_and_for_ten_minutes() {
    let world = World::with(&[("creates_trainees", "true")]).await;
    let mut browser = world.app.stranger();
    let url = world.begin(&mut browser).await;
    let cookies = browser.cookie.clone();
    let fields = world.platform.confirm(&url, &LaunchMessage::by("ada"));
    assert_eq!(post(&mut browser, &fields).await.status, 303);
    let mut replayed = world.app.stranger();
    replayed.cookie = cookies;
    assert_eq!(refusal(&post(&mut replayed, &fields).await), "no_flow");
    assert!(!is_signed_in(&mut replayed).await);

    let mut late = world.app.stranger();
    let url = world.begin(&mut late).await;
    world.clock().advance(601);
    let answer = post(&mut late, &world.platform.confirm(&url, &LaunchMessage::by("ada"))).await;
    assert_eq!(world.assert_refused(&mut late, &answer, 0).await, "no_flow");
}

#[tokio::test]
async fn a_launch_replaces_who_was_signed_in() {
    let world = World::with(&[("creates_trainees", "true")]).await;
    let ada = world.app.member(world.school, Role::Trainee, ADA).await;
    let mut browser = world.app.signed_in(ADA).await;
    let back = world.launch(&mut browser, &LaunchMessage::by("ben")).await;
    assert_eq!(back.header("location"), "/");
    assert!(!is_signed_in_as(&mut browser, &ada.person).await);
    assert!(browser.get("/account").await.text().contains("Name of ben"));
    let theirs = "SELECT subject FROM identities JOIN people ON people.id = person_id WHERE email = 'ada@example.org'";
    assert!(crate::auth::federation::texts(&world.app, theirs).await.is_empty());
}
