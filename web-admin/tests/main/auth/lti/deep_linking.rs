//! Choice of content for a course of a learning platform. Fails when a platform could not verify the response, when it links to something else
//! than was chosen, and when a choice is made twice, by another person, or by one who does not teach here.

use acts::training::assignments;
use model::Role;
use model::ids::AssignmentId;
use model::training::assignment::AssignmentTask;
use serde_json::{Value, json};
use store::training::assignments::NewAssignment;
use store::training::cohorts;

use super::{CLIENT, World, refusal};
use crate::auth::federation::texts;
use crate::support::Member;
use crate::support::assertions::read_signed;
use crate::support::client::{Answer, Client, csrf_in};
use crate::support::learning_platform::{DEEP_LINKING, ISSUER, LTI, LaunchMessage};

const TEACHER: &str = "teacher@example.org";
const EXERCISE: &str = "exercise:feel-the-layers";

/// A school with published exercises, whose teacher the platform knows.
async fn world() -> (World, Member) {
    let world = World::new().await;
    world.app.publish(world.school).await;
    let teacher = world.known(Role::Instructor, TEACHER, "t1").await;
    (world, teacher)
}

/// Opens the page of a choice by a launch; its address.
async fn open(world: &World, message: &LaunchMessage) -> (Client, String) {
    let (browser, answer) = world.launch_anew(message).await;
    let path = answer.header("location").to_owned();
    assert!(path.starts_with("/lti/deep-link/"), "{path}: {}", answer.text());
    (browser, path)
}

async fn choose(browser: &mut Client, path: &str, chosen: &[&str]) -> Answer {
    let csrf = csrf_in(&browser.get(path).await.text());
    let fields: Vec<_> = chosen.iter().map(|id| ("content", *id)).chain([("csrf", csrf.as_str())]).collect();
    browser.form(path, &fields).await
}

/// The claims of the response on a page, verified by the published keys.
async fn read_response(world: &World, answer: &Answer) -> Value {
    let page = answer.text();
    assert_eq!(answer.status, 200, "{page}");
    assert!(
        page.contains("<form class=\"stack\" method=\"post\" action=\"https://canvas.example.com/return?course=5\">")
    );
    let jwt = page.split("name=\"JWT\" value=\"").nth(1).unwrap().split('"').next().unwrap();
    let keys = world.app.stranger().get("/.well-known/jwks.json").await.json();
    read_signed(jwt, &keys).expect("a response signed with a published key")
}

fn items(response: &Value) -> &Vec<Value> {
    response[format!("{DEEP_LINKING}content_items")].as_array().unwrap()
}

#[tokio::test]
async fn a_platform_verifies_what_was_chosen() {
    let (world, teacher) = world().await;
    let assignment = assign(&world, &teacher).await;
    let (mut browser, path) = open(&world, &LaunchMessage::choice_by("t1")).await;
    let page = browser.get(&path).await.text();
    for offered in [EXERCISE, "course:lower-back-basics", &format!("assignment:{assignment}")] {
        assert!(page.contains(&format!("type=\"checkbox\" name=\"content\" value=\"{offered}\"")), "{offered}: {page}");
    }
    let answer = choose(&mut browser, &path, &[EXERCISE, &format!("assignment:{assignment}")]).await;
    let policy = answer.header("content-security-policy");
    assert!(policy.contains("form-action https://canvas.example.com;") && !policy.contains("script-src"), "{policy}");
    let response = read_response(&world, &answer).await;
    let now_s = world.clock().now().micros() / 1_000_000;
    for (claim, value) in [
        ("iss".to_owned(), json!(CLIENT)),
        ("aud".to_owned(), json!(ISSUER)),
        ("iat".to_owned(), json!(now_s)),
        (format!("{LTI}message_type"), json!("LtiDeepLinkingResponse")),
        (format!("{LTI}version"), json!("1.3.0")),
        (format!("{LTI}deployment_id"), json!("1")),
        (format!("{DEEP_LINKING}data"), json!("op=321&v=44")),
    ] {
        assert_eq!(response[&claim], value, "{claim}");
    }
    assert!(response["nonce"].as_str().unwrap().len() >= 22 && response["exp"].as_i64().unwrap() > now_s);
    let [task, exercise] = &items(&response)[..] else { panic!("two items: {response}") };
    assert_eq!(task["custom"]["stylet"], json!(format!("/assignments/{assignment}")));
    assert_eq!(exercise["custom"]["stylet"], "/exercises/feel-the-layers");
    assert_eq!((&exercise["type"], &exercise["url"]), (&json!("ltiResourceLink"), &json!(super::launch_address())));
    let line_item = &exercise["lineItem"];
    assert_eq!((&line_item["resourceId"], &line_item["scoreMaximum"]), (&json!(EXERCISE), &json!(100)));
    assert_eq!(line_item["label"], exercise["title"]);
    let acts = "SELECT action FROM audit_log WHERE action = 'platform.content_linked'";
    assert_eq!(texts(&world.app, acts).await.len(), 1);
}

/// Gives a cohort of the teacher and of a trainee, whom the platform calls `ada`, an exercise.
async fn assign(world: &World, teacher: &Member) -> AssignmentId {
    let ada = world.known(Role::Trainee, super::ADA, "ada").await;
    world.app.cohort(world.school, "Spring", &[&teacher.person, &ada.person]).await;
    let now = world.clock().now();
    let cohort = world.app.write(async |tx| cohorts::find_or_create(tx, world.school, "Spring", now).await).await;
    let new = NewAssignment {
        since_only: false,
        task: AssignmentTask::Exercise("feel-the-layers".to_owned()),
        cohort_id: Some(cohort.unwrap().id),
        person_id: None,
        supervised: false,
        attempt_limit: None,
        due: None,
        time_zone: "UTC".to_owned(),
    };
    assignments::make(&world.app.state, &teacher.person.clone().into_current().unwrap(), &new).await.unwrap()
}

#[tokio::test]
async fn a_link_to_an_assignment_opens_the_exercise() {
    let (world, teacher) = world().await;
    let page = format!("/assignments/{}", assign(&world, &teacher).await);
    let link = |by: &str| LaunchMessage::by(by).with_lti("custom", json!({ "stylet": page }));
    let (mut ada, answer) = world.launch_anew(&link("ada")).await;
    assert_eq!(answer.header("location"), page);
    assert_eq!(ada.get(&page).await.header("location"), "/exercises/feel-the-layers");
    let (mut teacher, _) = world.launch_anew(&link("t1")).await;
    assert_eq!(teacher.get(&page).await.status, 200);
    world.known(Role::Trainee, "other@example.org", "other").await;
    let (mut other, _) = world.launch_anew(&link("other")).await;
    assert_eq!(other.get(&page).await.status, 404, "not theirs");
}

#[tokio::test]
async fn a_choice_is_made_once() {
    let (world, _) = world().await;
    let (mut browser, path) = open(&world, &LaunchMessage::choice_by("t1")).await;
    let csrf = csrf_in(&browser.get(&path).await.text());
    let fields = [("csrf", csrf.as_str()), ("content", EXERCISE)];
    assert_eq!(browser.form(&path, &fields).await.status, 200);
    assert_eq!(browser.form(&path, &fields).await.status, 404, "used");
    assert_eq!(browser.get(&path).await.status, 404);
    let (mut late, path) = open(&world, &LaunchMessage::choice_by("t1")).await;
    world.clock().advance(3599);
    assert_eq!(late.get(&path).await.status, 200);
    world.clock().advance(2);
    assert_eq!(late.get(&path).await.status, 404, "an hour later");
}

#[tokio::test]
async fn a_choice_belongs_to_who_has_begun_it() {
    let (world, _) = world().await;
    let (_, path) = open(&world, &LaunchMessage::choice_by("t1")).await;
    world.known(Role::Instructor, "colleague@example.org", "t2").await;
    let south = world.app.school("South").await;
    world.app.member(south, Role::Instructor, "abroad@example.org").await;
    for email in ["colleague@example.org", super::HEAD, "abroad@example.org"] {
        let mut other = world.app.signed_in(email).await;
        assert_eq!(other.get(&path).await.status, 404, "{email}");
        let csrf = csrf_in(&other.get("/account").await.text());
        assert_eq!(other.form(&path, &[("csrf", &csrf), ("content", EXERCISE)]).await.status, 404, "{email}");
    }
    let mut own = world.app.signed_in(TEACHER).await;
    assert_eq!(own.get(&path).await.status, 200, "in whichever browser");
}

#[tokio::test]
async fn only_people_who_teach_here_choose_content() {
    let (world, _) = world().await;
    world.known(Role::Trainee, super::ADA, "ada").await;
    let (mut trainee, path) = open(&world, &LaunchMessage::choice_by("ada")).await;
    let page = trainee.get(&path).await;
    assert!(page.status == 403 && page.text().contains("for instructors"), "{}", page.text());
    let csrf = csrf_in(&trainee.get("/account").await.text());
    assert_eq!(trainee.form(&path, &[("csrf", &csrf), ("content", EXERCISE)]).await.status, 403);
}

#[tokio::test]
async fn a_choice_keeps_to_what_the_platform_accepts() {
    let (world, _) = world().await;
    let alone = LaunchMessage::choice_by("t1").with_setting("accept_multiple", false);
    let (mut browser, path) = open(&world, &alone.with_setting("accept_lineitem", false)).await;
    assert!(browser.get(&path).await.text().contains("type=\"radio\" name=\"content\""));
    for (chosen, why) in [
        (&[EXERCISE, "course:lower-back-basics"][..], "one link at a time"),
        (&["exercise:none"], "not in the list"),
        (&["/admin"], "not in the list"),
    ] {
        let refused = choose(&mut browser, &path, chosen).await;
        assert!(refused.status == 422 && refused.text().contains(why), "{}", refused.text());
    }
    let response = read_response(&world, &choose(&mut browser, &path, &[EXERCISE]).await).await;
    assert!(items(&response).len() == 1 && items(&response)[0].get("lineItem").is_none(), "{response}");
    let (mut browser, path) = open(&world, &LaunchMessage::choice_by("t1").with_setting("data", Value::Null)).await;
    let response = read_response(&world, &choose(&mut browser, &path, &[]).await).await;
    assert!(items(&response).is_empty() && response.get(format!("{DEEP_LINKING}data")).is_none(), "{response}");
}

#[tokio::test]
async fn a_request_that_cannot_be_answered_is_refused() {
    let (world, _) = world().await;
    let by = || LaunchMessage::choice_by("t1");
    for (n, (message, reason)) in [
        (by().with_setting("accept_types", json!(["html"])), "content"),
        (by().with_setting("deep_link_return_url", "javascript:alert(1)"), "malformed"),
        (by().with_setting("deep_link_return_url", "http://canvas.example.com/return"), "malformed"),
        (by().with_setting("deep_link_return_url", "https://user:secret@canvas.example.com/return"), "malformed"),
        (by().with_setting("deep_link_return_url", Value::Null), "malformed"),
        (by().with_lti("deployment_id", "2"), "deployment"),
    ]
    .into_iter()
    .enumerate()
    {
        let (mut browser, answer) = world.launch_anew(&message).await;
        assert_eq!(refusal(&answer), reason);
        assert_eq!(world.assert_refused(&mut browser, &answer, n).await, reason, "{message:?}");
    }
    assert_eq!(texts(&world.app, "SELECT issuer FROM content_choices").await, Vec::<String>::new());
}
