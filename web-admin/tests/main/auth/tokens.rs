//! One's own tokens for programs. Fails when one outlives its end or its revocation, is shown twice, is made by a browser that was
//! left open, or when a token of before stops working.

use model::{Moment, PersonKey, Role};
use platform::clock::Clock;
use platform::secret;
use store::auth::tokens;
use store::auth::tokens::NewToken;

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::{App, Member, PASSWORD, web_admin};

const PAGE: &str = "/account/tokens";
const DAY_S: i64 = 86_400;

async fn app() -> (App, Member) {
    let app = App::with(Clock::fixed(Moment::from_micros(1_700_000_000_000_000)), |_| {}).await;
    let school = app.school("North").await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    (app, ada)
}

async fn ask(client: &mut Client, name: &str, days: &str, password: &str) -> Answer {
    let csrf = csrf_in(&client.get(PAGE).await.text());
    client.form(PAGE, &[("csrf", &csrf), ("name", name), ("days", days), ("password", password)]).await
}

/// Makes a token, and gives it.
async fn make(client: &mut Client, name: &str, days: &str) -> String {
    let answer = ask(client, name, days, PASSWORD).await;
    assert_eq!(answer.status, 200, "{}", answer.text());
    let page = answer.text();
    let token = page.split("<code class=\"link-to-copy\">").nth(1).unwrap().split('<').next().unwrap();
    token.to_owned()
}

#[tokio::test]
async fn a_token_is_shown_once_and_good_until_its_end() {
    let (app, _) = app().await;
    let mut ada = app.signed_in("ada@example.org").await;
    let token = make(&mut ada, " Analysis ", "30").await;
    let page = ada.get(PAGE).await.text();
    assert!(page.contains("Analysis") && page.contains("never") && !page.contains(&token), "{page}");
    assert_eq!(app.with_token(&token).get("/api/v1/sessions").await.status, 200);
    let page = ada.get(PAGE).await.text();
    assert!(
        page.contains("14 Nov 2023, 22:00") && page.contains("14 Dec 2023"),
        "used at 22:13, told to the hour: {page}"
    );
    app.state.clock.advance(30 * DAY_S - 1);
    assert_eq!(app.with_token(&token).get("/api/v1/sessions").await.status, 200);
    app.state.clock.advance(1);
    let ended = app.with_token(&token).get("/api/v1/sessions").await;
    ended.is_problem(401, "this token expired at 2023-12-14T22:13:20Z");
    let upload = app.with_token(&token).upload(b"anything").await;
    upload.is_problem(401, "expired");
    let mut ada = app.signed_in("ada@example.org").await;
    assert!(ada.get(PAGE).await.text().contains("Expired"));
}

#[tokio::test]
async fn only_a_name_a_known_time_and_the_password_make_one() {
    let (app, _) = app().await;
    let mut ada = app.signed_in("ada@example.org").await;
    for (name, days, password, status, word) in [
        ("Analysis", "30", "a guess", 422, "not your current password"),
        ("", "30", PASSWORD, 422, "0 characters"),
        (&"x".repeat(61), "30", PASSWORD, 422, "61 characters"),
        ("a\u{202e}b", "30", PASSWORD, 422, "U+202E"),
        ("Analysis", "366", PASSWORD, 400, "allowed: 30, 90, 365"),
        ("Analysis", "-1", PASSWORD, 400, "allowed: 30, 90, 365"),
    ] {
        let answer = ask(&mut ada, name, days, password).await;
        assert!(answer.status == status && answer.text().contains(word), "{name} {days}: {}", answer.text());
    }
    assert_eq!(ada.get(PAGE).await.text().matches("/revoke\"").count(), 1, "the one of before");
}

#[tokio::test]
async fn a_token_of_before_goes_on_until_it_is_revoked() {
    let (app, member) = app().await;
    app.state.clock.advance(1000 * DAY_S);
    assert_eq!(app.with_token(&member.token).get("/api/v1/sessions").await.status, 200);
    let mut ada = app.signed_in("ada@example.org").await;
    let page = ada.get(PAGE).await.text();
    assert!(page.contains("no expiry") && page.contains("without a name"), "{page}");
    let href = format!(
        "{PAGE}/{}/revoke",
        page.split(&format!("action=\"{PAGE}/")).nth(1).unwrap().split('/').next().unwrap()
    );
    let school = member.person.school_id;
    app.member(school, Role::Administrator, "head@example.org").await;
    let mut head = app.signed_in("head@example.org").await;
    let csrf = csrf_in(&head.get(PAGE).await.text());
    assert_eq!(head.form(&href, &[("csrf", &csrf)]).await.status, 404, "somebody else's");
    let csrf = csrf_in(&page);
    assert_eq!(ada.form(&href, &[("csrf", &csrf)]).await.header("location"), PAGE);
    app.with_token(&member.token).get("/api/v1/sessions").await.is_problem(401, "token");
    assert_eq!(ada.form(&href, &[("csrf", &csrf)]).await.status, 404, "once is enough");
    let log: Vec<String> = sqlx::query_scalar("SELECT action FROM audit_log WHERE action LIKE 'token.%' ORDER BY seq")
        .fetch_all(app.state.db.reader())
        .await
        .unwrap();
    assert_eq!(log, ["token.revoked"]);
}

#[tokio::test]
async fn there_is_a_most() {
    let (app, member) = app().await;
    let owner = PersonKey { school_id: member.person.school_id, person_id: member.person.id };
    let now = app.state.clock.now();
    app.write(async |tx| {
        for n in 1..50 {
            let new = NewToken { owner, name: "x", expires_at: now.plus_s(DAY_S) };
            tokens::add_personal_token(tx, new, &secret::token_sha256(&n.to_string()), now).await.unwrap();
        }
    })
    .await;
    let mut ada = app.signed_in("ada@example.org").await;
    let answer = ask(&mut ada, "One more", "30", PASSWORD).await;
    assert!(answer.status == 422 && answer.text().contains("50 tokens, the most allowed"), "{}", answer.text());
}

#[tokio::test]
async fn ones_own_data_tell_of_tokens_and_erasing_forgets_their_names() {
    let (app, member) = app().await;
    // After the token of before, which comes first.
    app.state.clock.advance(1);
    let mut ada = app.signed_in("ada@example.org").await;
    make(&mut ada, "Analysis of Ada", "365").await;
    let held = ada.get("/account/export").await.json();
    assert_eq!(held["access"]["tokens"][1]["name"], "Analysis of Ada", "{}", held["access"]);
    assert_eq!(held["access"]["tokens"][1]["expires_at"], "2024-11-13T22:13:21Z");
    app.member(member.person.school_id, Role::Administrator, "head@example.org").await;
    let mut head = app.signed_in("head@example.org").await;
    let page = format!("/people/{}", member.person.id);
    let csrf = csrf_in(&head.get(&page).await.text());
    let erased = head.form(&format!("{page}/erase"), &[("csrf", &csrf), ("confirm", "ada@example.org")]).await;
    assert_eq!(erased.status, 303);
    let names: i64 = sqlx::query_scalar("SELECT count(*) FROM api_tokens WHERE name IS NOT NULL")
        .fetch_one(app.state.db.reader())
        .await
        .unwrap();
    assert_eq!(names, 0);
}

#[tokio::test]
async fn a_token_of_the_command_line_has_a_name_and_an_end_too() {
    let app = App::new().await;
    let school = app.school("North").await;
    app.member(school, Role::Trainee, "ada@example.org").await;
    let run = |arguments: &[&str]| {
        let whose = ["user", "token", "--email", "ada@example.org"];
        let made = web_admin(app.folder.path(), &[&whose, arguments].concat());
        (made.status.code(), String::from_utf8(made.stdout).unwrap(), String::from_utf8(made.stderr).unwrap())
    };
    let (status, token, _) = run(&["--days", "30", "--name", "Laboratory"]);
    assert_eq!(status, Some(0));
    assert_eq!(app.with_token(token.trim()).get("/api/v1/sessions").await.status, 200);
    assert_eq!(run(&[]).0, Some(0));
    for days in ["0", "366", "never"] {
        let (status, _, said) = run(&["--days", days]);
        assert!(status == Some(2) && said.contains("--days") && said.contains(days), "{said}");
    }
    let (status, _, said) = run(&["--name", "a\u{2028}b"]);
    assert!(status == Some(2) && said.contains("--name") && said.contains("U+2028"), "{said}");
    let days: Vec<(String, i64)> = sqlx::query_as(
        "SELECT name, (expires_at - created_at) / 86400000000 FROM api_tokens WHERE name IS NOT NULL ORDER BY created_at",
    )
    .fetch_all(app.state.db.reader())
    .await
    .unwrap();
    assert_eq!(days, [("Laboratory".to_owned(), 30), ("command line".to_owned(), 365)]);
}
