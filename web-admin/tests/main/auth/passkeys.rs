//! Passkeys. Fails when a password alone signs in where a passkey is asked for; when an answer is taken that is another site's,
//! another question's, somebody else's, late, given before, or of a copied key; and when a passkey outlives its removal.

use model::ids::SchoolId;
use model::{Moment, Role};
use platform::clock::Clock;
use serde_json::Value;
use web_admin::outbox;

use crate::support::authenticator::Authenticator;
use crate::support::client::{Answer, Client, csrf_in};
use crate::support::{App, Member, PASSWORD};

const ORIGIN: &str = "https://training.example.org";
const PAGE: &str = "/account/second-factor";
const KEYS: &str = "/account/second-factor/passkeys";
const ADA: &str = "ada@example.org";

async fn app() -> (App, SchoolId) {
    let clock = Clock::fixed(Moment::from_micros(1_700_000_000_000_000));
    let app = App::with(clock, |config| config.public_url = Some(ORIGIN.to_owned())).await;
    let school = app.school("North").await;
    (app, school)
}

/// Sends a form with the token of a page.
async fn send(client: &mut Client, page: &str, action: &str, fields: &[(&str, &str)]) -> Answer {
    let csrf = csrf_in(&client.get(page).await.text());
    client.form(action, &[&[("csrf", csrf.as_str())], fields].concat()).await
}

/// What a page asks of a passkey.
fn asked(page: &Answer) -> Value {
    let text = page.text();
    let rest = text.split("data-options=\"").nth(1).unwrap_or_else(|| panic!("nothing is asked in {text}"));
    serde_json::from_str(&rest.split('"').next().unwrap().replace("&#34;", "\"")).unwrap()
}

/// Answers what a page has asked.
async fn answer(client: &mut Client, page: &Answer, action: &str, answer: &Value) -> Answer {
    client.form(action, &[("csrf", &csrf_in(&page.text())), ("answer", &answer.to_string())]).await
}

/// Where a new passkey is asked for, by somebody who has no second factor.
async fn begin(client: &mut Client, name: &str) -> Answer {
    let page = send(client, PAGE, KEYS, &[("name", name), ("password", PASSWORD)]).await;
    assert_eq!(page.status, 200, "{}", page.text());
    page
}

/// Adds the first passkey; the recovery codes.
async fn enrol(client: &mut Client, key: &mut Authenticator) -> Vec<String> {
    let page = begin(client, "Key").await;
    let done = answer(client, &page, &format!("{KEYS}/confirm"), &key.make(&asked(&page))).await;
    assert_eq!(done.status, 200, "{}", done.text());
    done.text().split("<li><code>").skip(1).map(|rest| rest.split('<').next().unwrap().to_owned()).collect()
}

/// Somebody with a passkey, and where they are signed in.
async fn ada_with_key(app: &App, school: SchoolId) -> (Member, Client, Authenticator, Vec<String>) {
    let ada = app.member(school, Role::Trainee, ADA).await;
    let (mut client, mut key) = (app.signed_in(ADA).await, Authenticator::new(1, ORIGIN));
    let codes = enrol(&mut client, &mut key).await;
    (ada, client, key, codes)
}

/// A client whose password is right, and the page that asks for the passkey.
async fn half(app: &App) -> (Client, Answer) {
    let mut client = app.stranger();
    assert_eq!(client.sign_in(ADA, PASSWORD).await.header("location"), "/login/code");
    let page = client.get("/login/code").await;
    (client, page)
}

async fn sign_in(app: &App, key: &mut Authenticator) -> Answer {
    let (mut client, page) = half(app).await;
    answer(&mut client, &page, "/login/code", &key.sign(&asked(&page))).await
}

async fn log_of(app: &App, person: &Member) -> Vec<String> {
    sqlx::query_scalar("SELECT action || ' ' || details FROM audit_log WHERE object = $1 ORDER BY seq")
        .bind(person.person.id.to_string())
        .fetch_all(app.state.db.reader())
        .await
        .unwrap()
}

async fn count(app: &App, table: &'static str) -> i64 {
    sqlx::query_scalar(sqlx::AssertSqlSafe(format!("SELECT count(*) FROM {table}")))
        .fetch_one(app.state.db.reader())
        .await
        .unwrap()
}

#[tokio::test]
async fn a_passkey_is_made_and_asked_for_when_signing_in() {
    let (app, school) = app().await;
    let ada = app.member(school, Role::Trainee, ADA).await;
    let (mut here, mut elsewhere) = (app.signed_in(ADA).await, app.signed_in(ADA).await);
    let wrong = send(&mut here, PAGE, KEYS, &[("name", "Key"), ("password", "a guess")]).await;
    assert_eq!(wrong.status, 422, "a browser that was left open makes none");
    let nameless = send(&mut here, PAGE, KEYS, &[("name", " "), ("password", PASSWORD)]).await;
    assert!(nameless.status == 422 && nameless.text().contains("allowed: 1 to"), "{}", nameless.text());
    let mut key = Authenticator::new(1, ORIGIN);
    let page = begin(&mut here, "Key").await;
    assert_eq!(asked(&page)["publicKey"]["rp"]["id"], "training.example.org");
    assert_eq!(app.stranger().sign_in(ADA, PASSWORD).await.header("location"), "/", "nothing is on yet");
    let codes = enrol(&mut here, &mut key).await;
    assert_eq!(codes.len(), 10);
    assert_eq!(here.get("/").await.status, 200, "whoever has made it stays signed in");
    assert_eq!(elsewhere.get("/").await.header("location"), "/login", "everywhere else they are signed out");

    let (mut waiting, page) = half(&app).await;
    assert_eq!(
        waiting.get("/account").await.header("location"),
        "/login?next=/account",
        "half signed in opens nothing"
    );
    assert_eq!(asked(&page)["publicKey"]["userVerification"], "required");
    let before = waiting.cookie.clone();
    let done = answer(&mut waiting, &page, "/login/code", &key.sign(&asked(&page))).await;
    assert_eq!((done.status.as_u16(), done.header("location")), (303, "/"), "{}", done.text());
    assert_ne!(waiting.cookie, before, "the session has another id");
    let list = waiting.get(PAGE).await.text();
    assert!(list.contains(">Key</a>") && list.contains("last used"), "{list}");
    let log = log_of(&app, &ada).await;
    assert!(log.iter().any(|line| line.starts_with("passkey.added {\"first\":true,\"passkey\":\"")), "{log:#?}");
    assert_eq!(log.last().unwrap(), "person.signed_in {\"second_factor\":\"passkey\"}");
}

#[tokio::test]
async fn what_does_not_fit_is_refused() {
    let (app, school) = app().await;
    let (ada, _, mut key, _) = ada_with_key(&app, school).await;
    for (what, change) in [
        (
            "of another origin",
            (|key, _| key.origin = "https://training.example.com".to_owned()) as fn(&mut Authenticator, &mut Value),
        ),
        ("of a page without TLS", |key, _| key.origin = "http://training.example.org".to_owned()),
        ("for another site", |_, asked| asked["publicKey"]["rpId"] = "example.com".into()),
        ("to another challenge", |_, asked| asked["publicKey"]["challenge"] = "AAAA".into()),
        ("of nobody recognised", |key, _| key.verifies = false),
    ] {
        let (mut client, page) = half(&app).await;
        let (mut other, mut question) = (key.clone(), asked(&page));
        change(&mut other, &mut question);
        let done = answer(&mut client, &page, "/login/code", &other.sign(&question)).await;
        assert!(done.status == 401 && done.text().contains("does not match"), "{what}: {}", done.text());
        assert_eq!(client.get("/").await.header("location"), "/login", "{what}");
    }
    let (mut client, page) = half(&app).await;
    let foreign = Authenticator::new(2, ORIGIN).sign(&asked(&page));
    assert_eq!(answer(&mut client, &page, "/login/code", &foreign).await.status, 401, "of a key that nobody has added");
    let (mut client, page) = half(&app).await;
    let mut forged = key.clone().sign(&asked(&page));
    forged["response"]["signature"] = foreign["response"]["signature"].clone();
    assert_eq!(answer(&mut client, &page, "/login/code", &forged).await.status, 401, "another key's signature");
    let refusals = log_of(&app, &ada).await.iter().filter(|line| line.starts_with("second_factor.refused")).count();
    assert_eq!(refusals, 7);
    assert_eq!(sign_in(&app, &mut key).await.status, 303, "the right one still does");
}

#[tokio::test]
async fn an_answer_is_good_once_in_its_session_and_for_a_while() {
    let (app, school) = app().await;
    let (_, _, mut key, _) = ada_with_key(&app, school).await;
    let (mut first, page) = half(&app).await;
    let given = key.sign(&asked(&page));
    let (mut other, other_page) = half(&app).await;
    let taken = answer(&mut other, &other_page, "/login/code", &given).await;
    assert!(taken.status == 401 && taken.text().contains("does not match"), "another session has asked something else");
    let mut copy = first.clone();
    assert_eq!(answer(&mut first, &page, "/login/code", &given).await.status, 303);
    let (mut again, again_page) = half(&app).await;
    assert_eq!(answer(&mut again, &again_page, "/login/code", &given).await.status, 401, "replayed elsewhere");
    assert_eq!(answer(&mut copy, &page, "/login/code", &given).await.status, 403, "the session has ended");

    let (mut slow, page) = half(&app).await;
    let late = key.sign(&asked(&page));
    app.state.clock.advance(300);
    let done = answer(&mut slow, &page, "/login/code", &late).await;
    assert!(done.status == 401 && done.text().contains("too late"), "{}", done.text());
    let fresh = key.sign(&asked(&done));
    assert_eq!(answer(&mut slow, &done, "/login/code", &fresh).await.status, 303, "it is asked anew at once");
    let (mut twice, page) = half(&app).await;
    let wrong = Authenticator::new(2, ORIGIN).sign(&asked(&page));
    assert_eq!(answer(&mut twice, &page, "/login/code", &wrong).await.status, 401);
    assert_eq!(answer(&mut twice, &page, "/login/code", &key.sign(&asked(&page))).await.status, 401, "used up");
}

#[tokio::test]
async fn a_copied_key_is_told_by_its_counter() {
    let (app, school) = app().await;
    let (ada, _, mut key, codes) = ada_with_key(&app, school).await;
    let mut copy = key.clone();
    assert_eq!(sign_in(&app, &mut key).await.status, 303);
    let refused = sign_in(&app, &mut copy).await;
    assert!(refused.status == 401 && refused.text().contains("copy"), "{}", refused.text());
    assert!(log_of(&app, &ada).await.contains(&"passkey.counted_backwards {}".to_owned()));
    // Two questions at one count: the second answer counts by what is kept meanwhile.
    let ((mut one, first), (mut two, second)) = (half(&app).await, half(&app).await);
    let mut twin = key.clone();
    assert_eq!(answer(&mut one, &first, "/login/code", &key.sign(&asked(&first))).await.status, 303);
    assert_eq!(answer(&mut two, &second, "/login/code", &twin.sign(&asked(&second))).await.status, 401);
    let by_code = send(&mut two, "/login/code", "/login/code", &[("code", &codes[0])]).await;
    assert_eq!(by_code.status, 303, "a recovery code does instead");
}

#[tokio::test]
async fn a_key_that_counts_nothing_goes_on() {
    let (app, school) = app().await;
    app.member(school, Role::Trainee, ADA).await;
    let mut key = Authenticator::new(3, ORIGIN);
    key.counts = false;
    enrol(&mut app.signed_in(ADA).await, &mut key).await;
    assert_eq!(sign_in(&app, &mut key).await.status, 303);
    assert_eq!(sign_in(&app, &mut key).await.status, 303);
}

#[tokio::test]
async fn nobody_registers_what_is_anothers_or_was_not_asked() {
    let (app, school) = app().await;
    let (_, _, key, _) = ada_with_key(&app, school).await;
    app.member(school, Role::Trainee, "ben@example.org").await;
    let mut ben = app.signed_in("ben@example.org").await;
    let page = begin(&mut ben, "Mine").await;
    let taken = answer(&mut ben, &page, &format!("{KEYS}/confirm"), &key.clone().make(&asked(&page))).await;
    assert!(taken.status == 409 && taken.text().contains("already registered here"), "{}", taken.text());
    let page = begin(&mut ben, "Mine").await;
    let mut elsewhere = Authenticator::new(2, "https://training.example.com");
    let wrong = answer(&mut ben, &page, &format!("{KEYS}/confirm"), &elsewhere.make(&asked(&page))).await;
    assert!(wrong.status == 422 && wrong.text().contains("No passkey was added"), "{}", wrong.text());
    let mut own = Authenticator::new(2, ORIGIN);
    let page = begin(&mut ben, "Mine").await;
    let made = own.make(&asked(&page));
    app.state.clock.advance(300);
    assert_eq!(answer(&mut ben, &page, &format!("{KEYS}/confirm"), &made).await.status, 422, "too late");
    assert_eq!(app.stranger().sign_in("ben@example.org", PASSWORD).await.header("location"), "/", "none is on");
    assert_eq!(count(&app, "passkeys").await, 1);
}

#[tokio::test]
async fn several_are_named_renamed_and_removed_by_password_and_factor() {
    let (app, school) = app().await;
    let (ada, mut client, mut key, codes) = ada_with_key(&app, school).await;
    let alone = send(&mut client, PAGE, KEYS, &[("name", "Two"), ("password", PASSWORD)]).await;
    assert_eq!(alone.status, 422, "the password alone adds none any more");
    let page = client.get(PAGE).await;
    let signed = key.sign(&asked(&page)).to_string();
    let csrf = csrf_in(&page.text());
    let fields = [("csrf", csrf.as_str()), ("name", "Two"), ("password", PASSWORD), ("answer", &signed)];
    let page = client.form(KEYS, &fields).await;
    let excluded = asked(&page)["publicKey"]["excludeCredentials"].as_array().map_or(0, Vec::len);
    assert_eq!((page.status.as_u16(), excluded), (200, 1), "a device that has one makes no second");
    let mut second = Authenticator::new(2, ORIGIN);
    // The list is in the order in which they were made.
    app.state.clock.advance(1);
    let made = answer(&mut client, &page, &format!("{KEYS}/confirm"), &second.make(&asked(&page))).await;
    assert_eq!(made.header("location"), PAGE, "recovery codes of before go on: {}", made.text());
    assert_eq!(sign_in(&app, &mut second).await.status, 303);

    let list = client.get(PAGE).await;
    let own = list.link(&format!("{KEYS}/"));
    assert_eq!(send(&mut client, &own, &format!("{own}/rename"), &[("name", "")]).await.status, 422);
    assert_eq!(send(&mut client, &own, &format!("{own}/rename"), &[("name", "Drawer")]).await.status, 303);
    assert!(client.get(PAGE).await.text().contains(">Drawer</a>"));
    for fields in [[("password", "a guess"), ("code", codes[0].as_str())], [("password", PASSWORD), ("code", "x")]] {
        assert_eq!(send(&mut client, &own, &format!("{own}/remove"), &fields).await.status, 422, "{fields:?}");
    }
    let by_code = [("password", PASSWORD), ("code", codes[0].as_str())];
    assert_eq!(send(&mut client, &own, &format!("{own}/remove"), &by_code).await.status, 303);
    assert_eq!(client.get(&own).await.status, 404);
    assert_eq!(sign_in(&app, &mut key).await.status, 401, "it signs nobody in any more");
    assert_eq!(count(&app, "recovery_codes").await, 9, "another factor is left");

    let last = client.get(PAGE).await.link(&format!("{KEYS}/"));
    assert!(client.get(&last).await.text().contains("password only"));
    let by_code = [("password", PASSWORD), ("code", codes[1].as_str())];
    assert_eq!(send(&mut client, &last, &format!("{last}/remove"), &by_code).await.status, 303);
    assert_eq!(count(&app, "recovery_codes").await, 0);
    assert_eq!(app.stranger().sign_in(ADA, PASSWORD).await.header("location"), "/");
    outbox::work_off_letters(&app.state).await.unwrap();
    assert_eq!(std::fs::read_dir(app.folder.path().join("mail")).unwrap().count(), 1, "a mail says so");
    let log = log_of(&app, &ada).await;
    for action in ["passkey.added", "passkey.renamed", "passkey.removed", "second_factor.off"] {
        assert!(log.iter().any(|line| line.starts_with(action)), "{action}: {log:#?}");
    }
}

#[tokio::test]
async fn what_is_asked_of_teachers_a_passkey_satisfies() {
    let (app, school) = app().await;
    app.member(school, Role::Administrator, "head@example.org").await;
    let mut head = app.signed_in("head@example.org").await;
    send(&mut head, "/admin", "/admin/second-factor", &[("rule", "teachers")]).await;
    assert_eq!(head.get("/people").await.header("location"), PAGE);
    enrol(&mut head, &mut Authenticator::new(1, ORIGIN)).await;
    assert_eq!(head.get("/people").await.status, 200);
}

#[tokio::test]
async fn nobody_reaches_anothers() {
    let (app, school) = app().await;
    let (_, mut ada, _, _) = ada_with_key(&app, school).await;
    app.member(school, Role::Administrator, "head@example.org").await;
    let mut head = app.signed_in("head@example.org").await;
    let own = ada.get(PAGE).await.link(&format!("{KEYS}/"));
    assert_eq!(head.get(&own).await.status, 404);
    for act in ["rename", "remove"] {
        let fields = [("name", "Mine"), ("password", PASSWORD)];
        assert_eq!(send(&mut head, PAGE, &format!("{own}/{act}"), &fields).await.status, 404, "{act}");
    }
    assert_eq!(count(&app, "passkeys").await, 1);
}

#[tokio::test]
async fn it_is_exported_reset_and_erased() {
    let (app, school) = app().await;
    let (ada, mut client, _, _) = ada_with_key(&app, school).await;
    app.member(school, Role::Administrator, "head@example.org").await;
    let held = client.get("/account/export").await.json();
    assert_eq!(held["access"]["passkeys"][0]["name"], "Key", "{}", held["access"]);
    let mut head = app.signed_in("head@example.org").await;
    let page = format!("/people/{}", ada.person.id);
    let reset = send(&mut head, &page, &format!("{page}/second-factor/reset"), &[]).await;
    assert_eq!((reset.status.as_u16(), count(&app, "passkeys").await), (303, 0));
    enrol(&mut app.signed_in(ADA).await, &mut Authenticator::new(1, ORIGIN)).await;
    let erased = send(&mut head, &page, &format!("{page}/erase"), &[("confirm", ADA)]).await;
    assert_eq!((erased.status.as_u16(), count(&app, "passkeys").await), (303, 0), "{}", erased.text());
}

#[tokio::test]
async fn without_a_name_for_the_host_there_are_none_and_codes_do() {
    let (app, school) = app().await;
    let (_, _, _, codes) = ada_with_key(&app, school).await;
    let moved = App::in_folder(app.folder, app.state.clock.clone(), |config| {
        config.public_url = Some("http://10.0.0.1".to_owned());
    });
    let moved = moved.await;
    let (mut client, page) = half(&moved).await;
    assert!(
        !page.text().contains("data-options") && page.text().contains("do not work at this address"),
        "{}",
        page.text()
    );
    let done = send(&mut client, "/login/code", "/login/code", &[("code", &codes[0])]).await;
    assert_eq!(done.status, 303, "{}", done.text());
    assert!(client.get(PAGE).await.text().contains("Passkeys are not available here"));
    let more = [("name", "Two"), ("password", PASSWORD), ("code", codes[1].as_str())];
    assert_eq!(send(&mut client, PAGE, KEYS, &more).await.status, 409);
}
