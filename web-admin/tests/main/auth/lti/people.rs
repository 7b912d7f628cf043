//! Who a user of the platform is here. Fails when an address alone opens an account, when two users share one, when a platform gives a role, or
//! when it signs in to another school.

use model::Role;
use model::ids::SchoolId;
use serde_json::json;
use store::people::{NewPerson, Person};

use super::{ADA, CLIENT, World, add, login, post, refusal};
use crate::auth::federation::{authorize_url, invite, is_signed_in, is_signed_in_as, texts};
use crate::support::PASSWORD;
use crate::support::client::{Answer, Client, csrf_in};
use crate::support::learning_platform::LaunchMessage;

const JOIN: &str = "/sign-in/join";

async fn invited(world: &World, email: &str, number: Option<&str>) -> Person {
    let role = Role::Trainee;
    let new = NewPerson { school_id: world.school, role, email, display_name: "Invited", password_hash: "" };
    invite(&world.app, new, number).await
}

async fn launch(world: &World, message: LaunchMessage) -> (Client, String) {
    let (browser, answer) = world.launch_anew(&message).await;
    assert_eq!(answer.status, 303, "{}: {:?}", answer.text(), world.reasons().await);
    (browser, answer.header("location").to_owned())
}

async fn send_half(browser: &mut Client, path: &str, fields: &[(&str, &str)]) -> Answer {
    let page = browser.get(JOIN).await;
    assert_eq!(page.status, 200, "{}", page.text());
    let csrf = csrf_in(&page.text());
    browser.form(path, &[&[("csrf", csrf.as_str())], fields].concat()).await
}

#[tokio::test]
async fn the_registrars_number_finds_one_person_once() {
    for (claim, object, member) in
        [("person_sourcedid", "lis", "person_sourcedid"), ("student_number", "custom", "student_number")]
    {
        let world = World::with(&[("number_claim", claim)]).await;
        let ada = invited(&world, ADA, Some("4711")).await;
        let message =
            |subject: &str, number: &str| LaunchMessage::by(subject).with_lti(object, json!({ member: number }));
        for stranger in ["0815", "", "471", "$Person.sourcedId"] {
            assert_eq!(launch(&world, message("x", stranger)).await.1, JOIN, "{stranger:?}");
        }
        let elsewhere = if object == "lis" { "custom" } else { "lis" };
        let other =
            LaunchMessage::by("x").with_lti(elsewhere, json!({ "student_number": "4711", "person_sourcedid": "4711" }));
        assert_eq!(launch(&world, other).await.1, JOIN, "another claim than the configured one");
        let (mut browser, location) = launch(&world, message("a1", "4711")).await;
        assert!(location == "/" && is_signed_in_as(&mut browser, &ada).await);
        assert_eq!(launch(&world, message("a2", "4711")).await.1, JOIN, "the person has an identity of this platform");
        assert_eq!(world.identities().await, ["lti matched a1"]);
    }
}

#[tokio::test]
async fn an_address_opens_no_account() {
    let world = World::with(&[("creates_trainees", "true"), ("number_claim", "person_sourcedid")]).await;
    invited(&world, ADA, None).await;
    let message = LaunchMessage::by("a1").with("email", ADA).with("email_verified", true);
    let (mut browser, location) = launch(&world, message).await;
    assert!(location == JOIN && !is_signed_in(&mut browser).await, "{location}");
    assert_eq!(world.identities().await, Vec::<String>::new());
    let begun = send_half(&mut browser, "/sign-in/begin", &[]).await;
    assert_eq!(begun.header("location"), "/", "{}", begun.text());
    assert_eq!(texts(&world.app, "SELECT display_name FROM people WHERE email = 'ada@example.org'").await, ["Invited"]);
}

#[tokio::test]
async fn a_new_account_is_a_trainees_whatever_the_platform_says() {
    let world = World::with(&[("creates_trainees", "true")]).await;
    let roles = json!([
        "http://purl.imsglobal.org/vocab/lis/v2/institution/person#Administrator",
        "http://purl.imsglobal.org/vocab/lis/v2/membership#Instructor"
    ]);
    let (mut browser, location) =
        launch(&world, LaunchMessage::by("a1").with_lti("roles", roles).with("email", "new@example.org")).await;
    assert_eq!(location, "/");
    let people = "SELECT role || ' ' || display_name || ' ' || email FROM people WHERE display_name LIKE 'Name%'";
    assert_eq!(texts(&world.app, people).await, ["trainee Name of a1 new@example.org"]);
    assert_eq!(browser.get("/admin/platforms").await.status, 403);
    let seen = "SELECT c.title || ' ' || l.resource_link_id || ' ' || l.page FROM platform_links l JOIN platform_contexts c ON c.id = l.context_id";
    assert_eq!(texts(&world.app, seen).await, ["Nursing, first year link-1 /"]);
}

#[tokio::test]
async fn a_password_joins_an_unknown_identity() {
    let world = World::new().await;
    let ada = world.app.member(world.school, Role::Instructor, ADA).await;
    let exercise = "/exercises/feel-the-layers";
    let message = LaunchMessage::by("a1").with_lti("custom", json!({ "stylet": exercise }));
    // Ben is signed in in this browser, and does not become Ada's.
    world.app.member(world.school, Role::Trainee, "ben@example.org").await;
    let mut browser = world.app.signed_in("ben@example.org").await;
    assert_eq!(world.launch(&mut browser, &message).await.header("location"), JOIN);
    let page = browser.get(JOIN).await.text();
    assert!(page.contains("Canvas") && !page.contains("/sign-in/begin"), "{page}");
    let fields = |password| [("email", ADA), ("password", password)];
    assert_eq!(send_half(&mut browser, JOIN, &fields("a guess")).await.status, 401);
    assert_eq!(world.identities().await, Vec::<String>::new());
    let joined = send_half(&mut browser, JOIN, &fields(PASSWORD)).await;
    assert_eq!((joined.status.as_u16(), joined.header("location")), (303, exercise), "{}", joined.text());
    assert!(is_signed_in_as(&mut browser, &ada.person).await);
    assert_eq!(world.identities().await, ["lti joined a1"]);
    assert!(browser.get("/account/identities").await.text().contains("Canvas"));
    assert_eq!(launch(&world, LaunchMessage::by("a1")).await.1, "/");
}

#[tokio::test]
async fn a_disabled_person_is_not_let_in() {
    let world = World::with(&[("number_claim", "person_sourcedid")]).await;
    invited(&world, ADA, Some("4711")).await;
    let message = LaunchMessage::by("a1").with_lti("lis", json!({ "person_sourcedid": "4711" }));
    assert_eq!(launch(&world, message.clone()).await.1, "/");
    let now = world.clock().now();
    world
        .app
        .write(async |tx| {
            sqlx::query("UPDATE people SET disabled_at = $1 WHERE email = $2")
                .bind(now)
                .bind(ADA)
                .execute(tx)
                .await
                .unwrap();
        })
        .await;
    let (mut browser, answer) = world.launch_anew(&message).await;
    assert_eq!(world.assert_refused(&mut browser, &answer, 0).await, "disabled");
}

/// A second school that has registered the same platform under a client id of its own.
async fn south(world: &World) -> (SchoolId, Client, String) {
    let south = world.app.school("South").await;
    world.app.member(south, Role::Administrator, "head@south.example").await;
    let mut head = world.app.signed_in("head@south.example").await;
    let changes = [("client_id", "client-2"), ("creates_trainees", "true"), ("number_claim", "person_sourcedid")];
    let id = add(&mut head, &world.platform, &changes).await;
    (south, head, id)
}

#[tokio::test]
async fn two_schools_with_one_issuer_never_mix() {
    let world = World::with(&[("number_claim", "person_sourcedid"), ("creates_trainees", "true")]).await;
    let ada = invited(&world, ADA, Some("4711")).await;
    let message = LaunchMessage::by("7").with_lti("lis", json!({ "person_sourcedid": "4711" }));
    let (mut browser, _) = launch(&world, message.clone()).await;
    assert!(is_signed_in_as(&mut browser, &ada).await);

    let (south, mut head, id) = south(&world).await;
    // The same deployment of the same issuer is not admitted there, and the login needs the client id now.
    assert_eq!(refusal(&world.app.stranger().get(&login(&[("client_id", "")])).await), "platform");
    let there = async |message: &LaunchMessage| {
        let mut browser = world.app.stranger();
        let url = authorize_url(&browser.get(&login(&[("client_id", "client-2")])).await);
        let answer = post(&mut browser, &world.platform.confirm(&url, message)).await;
        (browser, answer)
    };
    assert_eq!(refusal(&there(&message).await.1), "deployment");
    let own = format!("/admin/platforms/{id}");
    let page = head.get(&own).await.text();
    let fields = [("csrf", csrf_in(&page)), ("deployment", "1".to_owned())];
    let fields = fields.each_ref().map(|(name, value)| (*name, value.as_str()));
    assert_eq!(head.form(&format!("{own}/admit"), &fields).await.status, 303);

    let (mut browser, answer) = there(&message).await;
    assert_eq!(answer.header("location"), "/", "{}", answer.text());
    assert!(!is_signed_in_as(&mut browser, &ada).await, "the same user and number is another person there");
    let places = "SELECT s.name || ' ' || i.issuer || ' ' || i.subject FROM identities i JOIN schools s ON s.id = i.school_id ORDER BY s.name";
    assert_eq!(
        texts(&world.app, places).await,
        [
            format!("North https://canvas.example.com {CLIENT} 7"),
            "South https://canvas.example.com client-2 7".to_owned()
        ]
    );
    let people = sqlx::query_scalar("SELECT count(*) FROM people WHERE school_id = $1").bind(south);
    let count: i64 = people.fetch_one(world.app.state.db.reader()).await.unwrap();
    assert_eq!(count, 2);

    // A token for one registration is none for the other.
    let (mut north, mut abroad) = (world.app.stranger(), world.app.stranger());
    let url = authorize_url(&north.get(&login(&[])).await);
    let elsewhere = authorize_url(&abroad.get(&login(&[("client_id", "client-2")])).await);
    let (own, other) = (world.platform.confirm(&url, &message), world.platform.confirm(&elsewhere, &message));
    let answer = post(&mut abroad, &[other[0].clone(), own[1].clone()]).await;
    assert_eq!(refusal(&answer), "audience");
    assert!(!is_signed_in(&mut abroad).await);
}
