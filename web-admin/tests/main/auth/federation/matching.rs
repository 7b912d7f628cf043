//! Who a user of the provider is here. Fails when an address alone opens somebody's account, when two users share one, when a provider gives a
//! role that it may not give, or when it signs in to another school.

use model::Role;
use store::people::{self, Person};

use super::{ADA, ADMIN, HEAD, World, add, flow, is_signed_in, is_signed_in_as, reasons, texts};
use crate::support::PASSWORD;
use crate::support::client::{Answer, Client, csrf_in};
use crate::support::provider::User;

const JOIN: &str = "/sign-in/join";
const NUMBER: (&str, &str) = ("match_claim", "matriculation");
const TRUSTED: (&str, &str) = ("addresses_verified", "true");

/// Sends a form of the page on which a user whom nobody knows ends.
async fn send_half(browser: &mut Client, path: &str, fields: &[(&str, &str)]) -> Answer {
    let page = browser.get(JOIN).await;
    assert_eq!(page.status, 200, "{}", page.text());
    let csrf = csrf_in(&page.text());
    browser.form(path, &[&[("csrf", csrf.as_str())], fields].concat()).await
}

/// Signs a user in at the provider; where the browser is sent next.
async fn enter_as(world: &World, user: User) -> (Client, String) {
    world.provider.set_user(user);
    let (browser, answer) = world.enter_anew().await;
    assert_eq!(answer.status, 303, "{}: {:?}", answer.text(), reasons(&world.app).await);
    (browser, answer.header("location").to_owned())
}

/// Signs in a user for whom an account is made, at once or after a question.
async fn begin_as(world: &World, user: User) -> Client {
    let (mut browser, location) = enter_as(world, user).await;
    if location == JOIN {
        let begun = send_half(&mut browser, "/sign-in/begin", &[]).await;
        assert_eq!((begun.status.as_u16(), begun.header("location")), (303, "/"), "{}", begun.text());
    }
    assert!(is_signed_in(&mut browser).await);
    browser
}

async fn person_by_name(world: &World, name: &str) -> Option<(String, String)> {
    let query = "SELECT role, CASE WHEN email LIKE '%@no-address.invalid' THEN '' ELSE email END FROM people WHERE display_name = $1";
    sqlx::query_as(query).bind(name).fetch_optional(world.app.state.db.reader()).await.unwrap()
}

#[tokio::test]
async fn an_identity_is_known_by_its_subject_alone() {
    let world = World::with(&[TRUSTED]).await;
    let ada = world.invited(Role::Trainee, ADA, None).await;
    assert_eq!(enter_as(&world, User::new("ada", ADA)).await.1, "/");
    let (mut browser, location) = enter_as(&world, User::new("ada", "married@example.org")).await;
    assert!(location == "/" && is_signed_in_as(&mut browser, &ada).await, "another address, the same person");
    for other in ["Ada", "ada ", "ada2"] {
        assert_eq!(enter_as(&world, User::new(other, ADA)).await.1, JOIN, "{other:?}: another subject, another person");
    }
    let (_, own) = person_by_name(&world, "Invited").await.unwrap();
    assert_eq!(own, ADA, "a provider changes no address");
}

#[tokio::test]
async fn the_registrars_number_finds_one_person_once() {
    let world = World::with(&[NUMBER]).await;
    let ada = world.invited(Role::Trainee, ADA, Some("4711")).await;
    world.invited(Role::Trainee, "ben@example.org", None).await;
    let user = |subject: &str, number: &str| User::new(subject, "x@example.net").with("matriculation", number);
    for stranger in ["0815", "", "471", "4711 x"] {
        assert_eq!(enter_as(&world, user("x", stranger)).await.1, JOIN, "{stranger:?}");
    }
    let (mut browser, location) = enter_as(&world, user("a1", "4711")).await;
    assert!(location == "/" && is_signed_in_as(&mut browser, &ada).await);
    assert_eq!(world.identities().await, ["matched a1"]);
    assert_eq!(enter_as(&world, user("a2", "4711")).await.1, JOIN, "the person has an identity of this provider");
    assert_eq!(world.identities().await, ["matched a1"]);
}

#[tokio::test]
async fn an_address_finds_a_person_only_if_vouched_for() {
    let user = || User::new("ada", "Ada@Example.org");
    let table = [
        (None, user(), false),
        (None, user().verified(false), false),
        (None, user().verified(true), true),
        (None, user().with("email_verified", "yes"), false),
        (Some(TRUSTED), user(), true),
    ];
    for (change, user, joins) in table {
        let world = World::with(change.as_slice()).await;
        let ada = world.invited(Role::Trainee, ADA, None).await;
        let (mut browser, location) = enter_as(&world, user.clone()).await;
        assert_eq!(location == "/", joins, "{change:?} {user:?}: {location}");
        assert_eq!(is_signed_in_as(&mut browser, &ada).await, joins, "{change:?} {user:?}");
        assert_eq!(world.identities().await.len(), usize::from(joins));
    }
}

#[tokio::test]
async fn an_address_opens_no_account_with_a_password() {
    let world = World::with(&[TRUSTED]).await;
    world.app.member(world.school, Role::Trainee, ADA).await;
    for address in [ADA, HEAD] {
        let (mut browser, location) = enter_as(&world, User::new(address, address).verified(true)).await;
        assert!(location == JOIN && !is_signed_in(&mut browser).await, "{address}: {location}");
    }
    assert_eq!(world.identities().await, Vec::<String>::new());
}

#[tokio::test]
async fn a_password_joins_an_unknown_identity() {
    let world = World::new().await;
    let ada = world.app.member(world.school, Role::Trainee, ADA).await;
    let (mut browser, location) = enter_as(&world, User::new("a1", "x@example.net")).await;
    assert_eq!(location, JOIN);
    let page = browser.get(JOIN).await.text();
    assert!(page.contains("No account here knows you yet") && !page.contains("/sign-in/begin"), "{page}");
    let fields = |password| [("email", ADA), ("password", password)];
    let wrong = send_half(&mut browser, JOIN, &fields("a guess")).await;
    assert!(wrong.status.is_client_error(), "{}", wrong.status);
    assert_eq!(world.identities().await, Vec::<String>::new());
    let right = send_half(&mut browser, JOIN, &fields(PASSWORD)).await;
    assert_eq!((right.status.as_u16(), right.header("location")), (303, "/"), "{}", right.text());
    assert!(is_signed_in_as(&mut browser, &ada.person).await);
    assert_eq!(world.identities().await, ["joined a1"]);
    assert_eq!(enter_as(&world, User::new("a1", "x@example.net")).await.1, "/");
}

#[tokio::test]
async fn guessing_on_the_join_page_is_limited() {
    let world = World::new().await;
    world.app.member(world.school, Role::Trainee, ADA).await;
    let (mut browser, _) = enter_as(&world, User::new("eve", "eve@example.net")).await;
    let mut statuses = Vec::new();
    for _ in 0..20 {
        let fields = [("email", ADA), ("password", "a guess")];
        statuses.push(send_half(&mut browser, JOIN, &fields).await.status.as_u16());
    }
    assert_eq!(statuses.last(), Some(&429), "{statuses:?}");
}

#[tokio::test]
async fn the_join_page_needs_an_answer_of_the_provider() {
    let world = World::with(&[("creates", "trainee")]).await;
    let mut stranger = world.app.stranger();
    let page = stranger.get(JOIN).await;
    assert_ne!(page.status, 200, "{}", page.text());
    let csrf = stranger.csrf().await;
    for path in [JOIN, "/sign-in/begin"] {
        let fields = [("csrf", csrf.as_str()), ("email", HEAD), ("password", PASSWORD)];
        let answer = stranger.form(path, &fields).await;
        assert!(!is_signed_in(&mut stranger).await, "{path}: {}", answer.status);
    }
    assert_eq!(world.identities().await, Vec::<String>::new());
}

#[tokio::test]
async fn an_account_is_made_only_where_the_school_allows_it() {
    let world = World::new().await;
    let (mut browser, _) = enter_as(&world, User::new("new", "new@example.org")).await;
    let refused = send_half(&mut browser, "/sign-in/begin", &[]).await;
    assert!(refused.status.is_client_error(), "{}", refused.status);
    assert_eq!(person_by_name(&world, "Name of new").await, None);

    let world = World::with(&[("creates", "trainee"), NUMBER]).await;
    let mut browser = begin_as(&world, User::new("new", "new@example.org").with("matriculation", "42")).await;
    let made = person_by_name(&world, "Name of new").await;
    assert_eq!(made, Some(("trainee".to_owned(), "new@example.org".to_owned())));
    assert_eq!(world.identities().await, ["created new"]);
    assert!(browser.get("/account").await.text().contains("Name of new"));
    let number = "SELECT registrar_id FROM people WHERE display_name = 'Name of new'";
    assert_eq!(texts(&world.app, number).await, ["42"]);
}

#[tokio::test]
async fn two_users_with_one_address_have_two_accounts() {
    for changes in [&[("creates", "trainee")][..], &[("creates", "trainee"), TRUSTED]] {
        let world = World::with(changes).await;
        begin_as(&world, User::new("first", "shared@example.org").verified(true)).await;
        begin_as(&world, User::new("second", "shared@example.org").verified(true)).await;
        assert_eq!(world.identities().await, ["created first", "created second"]);
        let first = person_by_name(&world, "Name of first").await.unwrap();
        let second = person_by_name(&world, "Name of second").await.unwrap();
        assert_eq!((first.1.as_str(), second.1.as_str()), ("shared@example.org", ""), "one of them has the address");
    }
}

#[tokio::test]
async fn an_account_may_be_made_without_an_address() {
    let world = World::with(&[("creates", "trainee")]).await;
    let user = || User { email: None, ..User::new("new", "") };
    let mut browser = begin_as(&world, user()).await;
    assert_eq!(person_by_name(&world, "Name of new").await, Some(("trainee".to_owned(), String::new())));
    for page in ["/", "/account", "/account/identities"] {
        assert_eq!(browser.get(page).await.status, 200, "{page}");
    }
    let mut head = world.app.signed_in(HEAD).await;
    assert!(head.get("/people").await.text().contains("Name of new"));
    assert_eq!(enter_as(&world, user()).await.1, "/");
}

#[tokio::test]
async fn roles_come_from_the_map_and_only_at_the_beginning() {
    let map = "staff@uni.example = instructor\nstudent@uni.example = trainee";
    let world = World::with(&[("creates", "trainee"), ("role_claim", "affiliation"), ("role_map", map)]).await;
    let user = |subject: &str, affiliation: &[&str]| {
        User::new(subject, &format!("{subject}@example.org")).with("affiliation", affiliation.to_vec())
    };
    for (subject, affiliation, role) in [
        ("teacher", &["member@uni.example", "staff@uni.example"][..], "instructor"),
        ("student", &["student@uni.example"], "trainee"),
        ("other", &["alum@uni.example"], "trainee"),
        ("boss", &["administrator", "administrator@uni.example"], "trainee"),
        ("nobody", &[], "trainee"),
    ] {
        begin_as(&world, user(subject, affiliation)).await;
        let made = person_by_name(&world, &format!("Name of {subject}")).await.unwrap();
        assert_eq!(made.0, role, "{subject}");
        world.app.state.clock.advance(61);
    }
    enter_as(&world, user("student", &["staff@uni.example"])).await;
    assert_eq!(person_by_name(&world, "Name of student").await.unwrap().0, "trainee", "a later claim changes no role");
}

#[tokio::test]
async fn another_claim_may_be_the_subject() {
    let world = World::with(&[TRUSTED, ("subject_claim", "eppn")]).await;
    let ada = world.invited(Role::Trainee, ADA, None).await;
    let user = |subject: &str| User::new(subject, ADA).with("eppn", "ada@uni.example");
    for subject in ["changes", "at each sign-in"] {
        let (mut browser, location) = enter_as(&world, user(subject)).await;
        assert!(location == "/" && is_signed_in_as(&mut browser, &ada).await, "{subject}");
    }
    assert_eq!(texts(&world.app, "SELECT subject FROM identities").await, ["ada@uni.example"]);
    world.provider.set_user(User::new("ada", ADA));
    let (mut browser, answer) = world.enter_anew().await;
    assert_eq!(super::assert_refused(&world.app, &mut browser, &answer, 0).await, "subject");
}

/// A second school, with its administrator and a person without a password.
async fn south(world: &World) -> (Client, Person) {
    let app = &world.app;
    let school = app.school("South").await;
    app.member(school, Role::Administrator, "head@south.example").await;
    app.member(school, Role::Trainee, "cat@south.example").await;
    let new = people::NewPerson {
        school_id: school,
        role: Role::Trainee,
        email: "bob@south.example",
        display_name: "Bob",
        password_hash: "",
    };
    let now = app.state.clock.now();
    let bob = app.write(async |tx| people::add_person(tx, &new, now).await.unwrap()).await;
    (app.signed_in("head@south.example").await, bob)
}

#[tokio::test]
async fn a_provider_signs_in_to_its_own_school_only() {
    let world = World::with(&[TRUSTED]).await;
    let (mut abroad, bob) = south(&world).await;
    let mut stranger = world.app.stranger();
    let button = format!("/sign-in/{}", world.id);
    assert!(stranger.get("/login?school=North").await.text().contains(&button));
    assert!(!stranger.get("/login?school=South").await.text().contains(&button));
    let own = format!("{ADMIN}/{}", world.id);
    assert_eq!(abroad.get(&own).await.status, 404);
    assert!(!abroad.get(ADMIN).await.text().contains(&world.id));

    let (mut browser, location) = enter_as(&world, User::new("bob", "bob@south.example").verified(true)).await;
    assert!(location == JOIN && !is_signed_in_as(&mut browser, &bob).await);
    let fields = [("email", "cat@south.example"), ("password", PASSWORD)];
    let joined = send_half(&mut browser, JOIN, &fields).await;
    assert!(joined.status.is_client_error() && !is_signed_in(&mut browser).await, "{}", joined.status);
    assert_eq!(world.identities().await, Vec::<String>::new());

    // The same provider and the same user are another identity at the other school.
    let there = add(&mut abroad, world.provider.issuer(), &[TRUSTED]).await;
    let mut browser = world.app.stranger();
    let answer = flow(&mut browser, &world.provider, &there).await;
    assert_eq!(answer.header("location"), "/", "{}", answer.text());
    assert!(is_signed_in_as(&mut browser, &bob).await);
    assert_eq!(enter_as(&world, User::new("bob", "bob@south.example")).await.1, JOIN, "unknown at the first school");
}
