//! Calendars of due dates. Fails when one is read without its secret, after its end or by a disabled person's address, when it sets a cookie, when
//! a done or withdrawn assignment stays, or when a due date is not the school's instant.

use axum::body::Body;
use axum::http::Request;
use model::Role;

use super::assignments::World;
use crate::support::client::{Answer, csrf_in};

const PAGE: &str = "/account/calendar";

/// Creates an address for Ada's calendar and returns its path.
async fn subscribe(world: &World) -> String {
    let mut ada = world.app.signed_in("ada@example.org").await;
    let csrf = csrf_in(&ada.get(PAGE).await.text());
    let made = ada.form(PAGE, &[("csrf", &csrf)]).await;
    assert_eq!(made.status, 200, "{}", made.text());
    let page = made.text();
    let rest = page.split("/calendar/").nth(1).filter(|rest| rest.len() > 64).expect("an address");
    format!("/calendar/{}", rest.split('"').next().expect("an end"))
}

async fn read(world: &World, path: &str) -> Answer {
    world.app.stranger().get(path).await
}

#[tokio::test]
async fn a_calendar_has_what_is_due_on_the_schools_clock() {
    let mut world = World::new().await;
    let assignment = world.assign("2026-03-27T18:00", "").await;
    let path = subscribe(&world).await;
    let feed = read(&world, &path).await;
    assert_eq!((feed.status.as_u16(), feed.header("content-type")), (200, "text/calendar; charset=utf-8"));
    assert!(feed.header("set-cookie").is_empty() && feed.header("cache-control").contains("no-cache"));
    let text = feed.text();
    assert!(text.contains("DTSTART:20260327T170000Z\r\n") && text.contains("SEQUENCE:0\r\n"), "{text}");
    let uid = |text: &str| text.split("UID:").nth(1).unwrap().split("DTSTAMP").next().unwrap().to_owned();

    let request = Request::get(&path).header("if-none-match", feed.header("etag")).body(Body::empty()).unwrap();
    assert_eq!(world.app.stranger().send(request).await.status, 304);
    let ada = world.ada.person.id.to_string();
    world.post(&format!("{assignment}/extend"), &[("person", &ada), ("days", "7")]).await;
    let later = read(&world, &path).await.text();
    // The clocks change on 29 March 2026.
    assert!(later.contains("DTSTART:20260403T160000Z\r\n") && later.contains("SEQUENCE:7\r\n"), "{later}");
    assert_eq!(uid(&later), uid(&text), "the same event");
    world.post(&format!("{assignment}/withdraw"), &[]).await;
    assert!(!read(&world, &path).await.text().contains("VEVENT"));
}

#[tokio::test]
async fn an_address_ends_when_it_is_replaced_or_revoked() {
    let world = World::new().await;
    let first = subscribe(&world).await;
    let second = subscribe(&world).await;
    assert_eq!(read(&world, &first).await.status, 404);
    assert_eq!(read(&world, &second).await.status, 200);
    let mut ada = world.app.signed_in("ada@example.org").await;
    let page = ada.get(PAGE).await.text();
    assert!(!page.contains(&second), "it is shown once");
    let revoked = ada.form(&format!("{PAGE}/revoke"), &[("csrf", &csrf_in(&page))]).await;
    assert_eq!((revoked.status.as_u16(), revoked.header("location")), (303, PAGE));
    assert_eq!(read(&world, &second).await.status, 404);
    assert!(ada.get("/account/export").await.json()["calendar_feed"].as_array().is_none_or(Vec::is_empty));
}

#[tokio::test]
async fn a_disabled_person_has_no_calendar() {
    let world = World::new().await;
    world.app.member(world.school, Role::Administrator, "head@example.org").await;
    let path = subscribe(&world).await;
    let mut head = world.app.signed_in("head@example.org").await;
    let csrf = csrf_in(&head.get("/people").await.text());
    let disabled = head.form(&format!("/people/{}/disable", world.ada.person.id), &[("csrf", &csrf)]).await;
    assert_eq!(disabled.status, 303, "{}", disabled.text());
    assert_eq!(read(&world, &path).await.status, 404);
}

#[tokio::test]
async fn guesses_from_one_address_are_braked() {
    let world = World::new().await;
    let path = subscribe(&world).await;
    let mut refused = 0;
    for n in 0..20 {
        let guess = read(&world, &format!("/calendar/{n:064x}.ics")).await.status;
        assert!(guess == 404 || guess == 429, "{guess}");
        refused += u32::from(guess == 429);
    }
    assert!(refused > 5, "{refused}");
    assert_eq!(read(&world, &path).await.status, 200, "the right secret is no guess");
}
