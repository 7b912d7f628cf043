//! Second factors. Fails when a password alone signs in where a code is asked for, when a code is good twice or late, when
//! guessing is not braked, when a half signed-in session opens anything, or when somebody who must have one gets by without.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::str::FromStr;

use axum::http::Method;
use data_encoding::BASE32_NOPAD;
use model::ids::SchoolId;
use model::{Moment, Role, TotpSecret};
use platform::clock::Clock;
use platform::sealing::KEY_FILE;
use sqlx::migrate::Migrator;
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{Connection, SqliteConnection};
use web_admin::outbox;

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::database::program;
use crate::support::{App, Member, PASSWORD};

const PAGE: &str = "/account/second-factor";
const STEP_S: i64 = 30;

/// Somebody's app, and their recovery codes.
pub(crate) struct Device {
    secret: TotpSecret,
    codes: Vec<String>,
}

impl Device {
    /// What the app shows now.
    pub(crate) fn code(&self, app: &App) -> String {
        self.secret.code_at(app.state.clock.now()).unwrap()
    }
}

async fn app() -> (App, SchoolId) {
    let app = App::with(Clock::fixed(Moment::from_micros(1_700_000_000_000_000)), |_| {}).await;
    let school = app.school("North").await;
    (app, school)
}

/// The text between two others.
fn between<'a>(page: &'a str, before: &str, after: &str) -> &'a str {
    let rest = page.split(before).nth(1).unwrap_or_else(|| panic!("no {before} in {page}"));
    rest.split(after).next().unwrap()
}

/// Sends a form of a page, with the token that the page has.
pub(crate) async fn send(client: &mut Client, page: &str, action: &str, fields: &[(&str, &str)]) -> Answer {
    let csrf = csrf_in(&client.get(page).await.text());
    client.form(action, &[&[("csrf", csrf.as_str())], fields].concat()).await
}

/// Begins, and gives the secret that is offered.
async fn begin(client: &mut Client) -> TotpSecret {
    let answer = send(client, PAGE, PAGE, &[("password", PASSWORD)]).await;
    assert_eq!((answer.status.as_u16(), answer.header("location")), (303, PAGE), "{}", answer.text());
    let page = client.get(PAGE).await.text();
    let text = between(&page, "<code class=\"link-to-copy\">", "<").replace('-', "");
    assert!(page.contains(&format!("secret={text}&")) || page.contains(&format!("secret={text}&#38;")), "{page}");
    TotpSecret::from_bytes(&BASE32_NOPAD.decode(text.as_bytes()).unwrap()).unwrap()
}

pub(crate) async fn enrol(app: &App, client: &mut Client) -> Device {
    let secret = begin(client).await;
    let code = secret.code_at(app.state.clock.now()).unwrap();
    let answer = send(client, PAGE, &format!("{PAGE}/confirm"), &[("code", &code)]).await;
    assert_eq!(answer.status, 200, "{}", answer.text());
    let codes = codes_in(&answer.text());
    assert_eq!(codes.len(), 10);
    // The next code is another.
    app.state.clock.advance(STEP_S);
    Device { secret, codes }
}

fn codes_in(page: &str) -> Vec<String> {
    page.split("<li><code>").skip(1).map(|rest| rest.split('<').next().unwrap().to_owned()).collect()
}

/// A client whose password is right and whose code is asked for.
async fn half(app: &App, email: &str) -> Client {
    let mut client = app.stranger();
    let answer = client.sign_in(email, PASSWORD).await;
    assert_eq!((answer.status.as_u16(), answer.header("location")), (303, "/login/code"));
    client
}

pub(crate) async fn say_code(client: &mut Client, code: &str) -> Answer {
    send(client, "/login/code", "/login/code", &[("code", code)]).await
}

/// Action and details of what is written down of a person.
async fn log_of(app: &App, person: &Member) -> Vec<String> {
    sqlx::query_scalar("SELECT action || ' ' || details FROM audit_log WHERE object = $1 ORDER BY seq")
        .bind(person.person.id.to_string())
        .fetch_all(app.state.db.reader())
        .await
        .unwrap()
}

/// Everything that was mailed.
async fn letters(app: &App) -> String {
    outbox::work_off_letters(&app.state).await.unwrap();
    let folder = app.folder.path().join("mail");
    let files = std::fs::read_dir(folder).map(|files| files.map(|file| file.unwrap().path()).collect::<Vec<_>>());
    files.unwrap_or_default().iter().map(|file| std::fs::read_to_string(file).unwrap()).collect()
}

#[tokio::test]
async fn a_code_is_asked_for_once_one_was_right() {
    let (app, school) = app().await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    let (mut here, mut elsewhere) = (app.signed_in("ada@example.org").await, app.signed_in("ada@example.org").await);
    let wrong = send(&mut here, PAGE, PAGE, &[("password", "a guess")]).await;
    assert_eq!(wrong.status, 422, "a browser that was left open makes none");
    let secret = begin(&mut here).await;
    let picture = here.get(&format!("{PAGE}/qr.svg")).await;
    assert_eq!((picture.status.as_u16(), picture.header("content-type")), (200, "image/svg+xml"));
    assert_eq!(picture.header("cache-control"), "no-store");
    assert_eq!(app.stranger().sign_in("ada@example.org", PASSWORD).await.header("location"), "/", "not on yet");

    let late = secret.code_at(app.state.clock.now().plus_s(-2 * STEP_S)).unwrap();
    for code in [late.as_str(), "", "000", "x"] {
        let answer = send(&mut here, PAGE, &format!("{PAGE}/confirm"), &[("code", code)]).await;
        assert_eq!(answer.status, 422, "{code}");
    }
    let device = enrol(&app, &mut here).await;
    assert_eq!(here.get("/").await.status, 200, "whoever has made it stays signed in");
    assert_eq!(elsewhere.get("/").await.header("location"), "/login", "everywhere else they are signed out");
    assert_eq!(here.get(&format!("{PAGE}/qr.svg")).await.status, 404, "the secret is shown no more");
    let page = here.get(PAGE).await.text();
    assert!(page.contains("10 recovery codes left") && !page.contains(&device.secret.text()), "{page}");

    let mut ada_again = half(&app, "ada@example.org").await;
    let answer = say_code(&mut ada_again, &device.code(&app)).await;
    assert_eq!((answer.status.as_u16(), answer.header("location")), (303, "/"));
    assert_eq!(ada_again.get("/").await.status, 200);
    let log = log_of(&app, &ada).await;
    for line in ["second_factor.offered {}", "second_factor.refused {}", "second_factor.on {}"] {
        assert!(log.iter().any(|found| found == line), "{line}: {log:#?}");
    }
    assert_eq!(log.last().unwrap(), "person.signed_in {\"second_factor\":\"app\"}");
}

#[tokio::test]
async fn half_signed_in_session_opens_nothing_else_and_expires() {
    let (app, school) = app().await;
    app.member(school, Role::Administrator, "head@example.org").await;
    let device = enrol(&app, &mut app.signed_in("head@example.org").await).await;
    let mut client = half(&app, "head@example.org").await;
    for path in ["/", "/account", PAGE, "/admin", "/people", "/nothing"] {
        for method in [Method::GET, Method::POST] {
            let answer = client.request(method.clone(), path).await;
            assert!(answer.status == 303 && answer.header("location").starts_with("/login"), "{method} {path}");
        }
    }
    client.get("/api/v1/sessions").await.is_problem(401, "token");
    assert_eq!(client.get("/login/code").await.status, 200);
    assert_eq!(app.stranger().get("/login/code").await.header("location"), "/login");

    let before = client.cookie.clone();
    app.state.clock.advance(599);
    assert_eq!(client.get("/login/code").await.status, 200);
    let mut late = client.clone();
    assert_eq!(say_code(&mut client, &device.code(&app)).await.status, 303);
    assert_ne!(client.cookie, before, "the session has another id");
    app.state.clock.advance(1);
    assert_eq!(late.get("/login/code").await.header("location"), "/login", "the old id is worth nothing");

    let mut slow = half(&app, "head@example.org").await;
    let csrf = csrf_in(&slow.get("/login/code").await.text());
    app.state.clock.advance(600);
    let answer = slow.form("/login/code", &[("csrf", &csrf), ("code", &device.code(&app))]).await;
    assert_eq!(answer.header("location"), "/login", "after ten minutes the password is asked for again");
    assert_eq!(slow.get("/").await.header("location"), "/login");
}

#[tokio::test]
async fn a_code_is_good_once_and_for_its_time() {
    let (app, school) = app().await;
    app.member(school, Role::Trainee, "ada@example.org").await;
    let device = enrol(&app, &mut app.signed_in("ada@example.org").await).await;
    let (code, before) = (device.code(&app), device.secret.code_at(app.state.clock.now().plus_s(-STEP_S)).unwrap());
    let (mut first, mut second) = (half(&app, "ada@example.org").await, half(&app, "ada@example.org").await);
    assert_eq!(say_code(&mut first, &before).await.status, 401, "it has confirmed the app");
    let spaced = format!(" {} {} ", &code[..3], &code[3..]);
    assert_eq!(say_code(&mut first, &spaced).await.status, 303, "as apps show it");
    assert_eq!(say_code(&mut second, &code).await.status, 401, "whoever looks over the shoulder is late");
    app.state.clock.advance(STEP_S);
    assert_eq!(say_code(&mut second, &code).await.status, 401);
    assert_eq!(say_code(&mut second, &device.code(&app)).await.status, 303);
    app.state.clock.advance(10 * STEP_S);
    let mut third = half(&app, "ada@example.org").await;
    let (early, too_early) = (app.state.clock.now().plus_s(STEP_S), app.state.clock.now().plus_s(2 * STEP_S));
    assert_eq!(say_code(&mut third, &device.secret.code_at(too_early).unwrap()).await.status, 401);
    assert_eq!(say_code(&mut third, &device.secret.code_at(early).unwrap()).await.status, 303);
}

#[tokio::test]
async fn guessing_codes_is_braked_and_written_down() {
    let (app, school) = app().await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    let device = enrol(&app, &mut app.signed_in("ada@example.org").await).await;
    let mut thief = half(&app, "ada@example.org").await;
    let mut statuses = Vec::new();
    for guess in 0..14 {
        statuses.push(say_code(&mut thief, &format!("{guess:06}")).await.status.as_u16());
    }
    assert_eq!((statuses[0], statuses[13]), (401, 429), "{statuses:?}");
    let right = say_code(&mut thief, &device.code(&app)).await;
    assert_eq!(right.status, 429, "a right one waits its turn");
    assert!(right.header("retry-after").parse::<u64>().unwrap() > 60);
    let mut again = half(&app, "ada@example.org").await;
    assert_eq!(say_code(&mut again, &device.codes[0]).await.status, 429, "another session has no more tries");
    let log = log_of(&app, &ada).await;
    let count = |start: &str| log.iter().filter(|line| line.starts_with(start)).count();
    assert_eq!((count("second_factor.refused"), count("second_factor.blocked")), (9, 1), "{log:#?}");
}

#[tokio::test]
async fn a_recovery_code_is_good_once() {
    let (app, school) = app().await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    let device = enrol(&app, &mut app.signed_in("ada@example.org").await).await;
    let typed = device.codes[0].to_lowercase().replace('-', " ");
    let mut lost = half(&app, "ada@example.org").await;
    assert_eq!(say_code(&mut lost, &typed).await.status, 303);
    assert!(lost.get(PAGE).await.text().contains("9 recovery codes left"));
    assert_eq!(say_code(&mut half(&app, "ada@example.org").await, &typed).await.status, 401);
    let log = log_of(&app, &ada).await;
    assert!(log.contains(&"recovery_code.used {\"left\":9}".to_owned()), "{log:#?}");
    assert!(log.contains(&"person.signed_in {\"second_factor\":\"recovery code\"}".to_owned()), "{log:#?}");

    let action = format!("{PAGE}/recovery-codes");
    assert_eq!(send(&mut lost, PAGE, &action, &[("code", "000000")]).await.status, 422);
    let made = send(&mut lost, PAGE, &action, &[("code", &device.code(&app))]).await;
    assert_eq!(made.status, 200);
    let codes = codes_in(&made.text());
    assert_eq!(say_code(&mut half(&app, "ada@example.org").await, &device.codes[1]).await.status, 401, "of before");
    assert_eq!(say_code(&mut half(&app, "ada@example.org").await, &codes[9]).await.status, 303);
}

#[tokio::test]
async fn a_link_to_another_password_asks_for_the_code_too() {
    let (app, school) = app().await;
    app.member(school, Role::Trainee, "ada@example.org").await;
    let device = enrol(&app, &mut app.signed_in("ada@example.org").await).await;
    let mut waiting = half(&app, "ada@example.org").await;
    let mut mailbox = app.stranger();
    let asked = send(&mut mailbox, "/forgotten", "/forgotten", &[("email", "ada@example.org")]).await;
    assert_eq!(asked.status, 200);
    let letter = letters(&app).await.replace("=\r\n", "");
    let link = format!("/join/{}", between(&letter, "/join/", "\r").trim());
    let set = send(&mut mailbox, &link, &link, &[("password", "vier Käse im Wind"), ("again", "vier Käse im Wind")]);
    let set = set.await;
    assert_eq!((set.status.as_u16(), set.header("location")), (303, "/login/code"), "{}", set.text());
    assert_eq!(mailbox.get("/").await.header("location"), "/login");
    assert_eq!(waiting.get("/login/code").await.header("location"), "/login", "the old password is worth nothing");
    assert_eq!(say_code(&mut mailbox, &device.code(&app)).await.status, 303);
}

#[tokio::test]
async fn it_is_turned_off_by_password_and_code_and_a_mail_says_so() {
    let (app, school) = app().await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    let mut client = app.signed_in("ada@example.org").await;
    let device = enrol(&app, &mut client).await;
    let off = format!("{PAGE}/off");
    let code = device.code(&app);
    for (password, code) in [("a guess", code.as_str()), (PASSWORD, "000000"), (PASSWORD, "")] {
        let answer = send(&mut client, PAGE, &off, &[("password", password), ("code", code)]).await;
        assert_eq!(answer.status, 422, "{password} {code}");
    }
    assert_eq!(half(&app, "ada@example.org").await.get("/login/code").await.status, 200, "still on");
    let answer = send(&mut client, PAGE, &off, &[("password", PASSWORD), ("code", &code)]).await;
    assert_eq!(answer.status, 303, "{}", answer.text());
    assert_eq!(app.stranger().sign_in("ada@example.org", PASSWORD).await.header("location"), "/");
    let letters = letters(&app).await;
    assert!(letters.contains("ada@example.org") && letters.contains(PAGE), "{letters}");
    assert!(log_of(&app, &ada).await.contains(&"second_factor.off {}".to_owned()));
    let again = send(&mut client, PAGE, &off, &[("password", PASSWORD), ("code", &code)]).await;
    assert_eq!(again.status, 409, "there is none any more");
}

#[tokio::test]
async fn an_administrator_takes_it_from_whoever_has_lost_it() {
    let (app, school) = app().await;
    let south = app.school("South").await;
    let ada = app.member(school, Role::Instructor, "ada@example.org").await;
    app.member(school, Role::Instructor, "teacher@example.org").await;
    app.member(school, Role::Administrator, "head@example.org").await;
    app.member(south, Role::Administrator, "abroad@example.org").await;
    enrol(&app, &mut app.signed_in("ada@example.org").await).await;
    let action = format!("/people/{}/second-factor/reset", ada.person.id);
    for (email, status) in [("teacher@example.org", 403), ("abroad@example.org", 404)] {
        let mut client = app.signed_in(email).await;
        assert_eq!(send(&mut client, "/account", &action, &[]).await.status.as_u16(), status, "{email}");
    }
    let mut head = app.signed_in("head@example.org").await;
    let page = format!("/people/{}", ada.person.id);
    assert!(head.get(&page).await.text().contains(&action));
    let done = send(&mut head, &page, &action, &[]).await;
    assert_eq!(done.header("location"), format!("{page}?done=unfactored"));
    assert!(head.get(done.header("location")).await.text().contains("second factor is off"));
    assert_eq!(send(&mut head, &page, &action, &[]).await.status, 409, "there is none any more");
    assert_eq!(app.stranger().sign_in("ada@example.org", PASSWORD).await.header("location"), "/");
    assert!(letters(&app).await.contains("To: Somebody <ada@example.org>"));
    assert!(log_of(&app, &ada).await.contains(&"second_factor.reset {}".to_owned()));
}

#[tokio::test]
async fn nobody_resets_their_own() {
    let (app, school) = app().await;
    let head = app.member(school, Role::Administrator, "head@example.org").await;
    let mut client = app.signed_in("head@example.org").await;
    enrol(&app, &mut client).await;
    let action = format!("/people/{}/second-factor/reset", head.person.id);
    assert_eq!(send(&mut client, "/account", &action, &[]).await.status, 409);
    assert_eq!(half(&app, "head@example.org").await.get("/login/code").await.status, 200);
}

#[tokio::test]
async fn who_must_have_one_makes_it_before_anything_else() {
    let (app, school) = app().await;
    let south = app.school("South").await;
    app.member(school, Role::Trainee, "ada@example.org").await;
    let teacher = app.member(school, Role::Instructor, "teacher@example.org").await;
    app.member(school, Role::Administrator, "head@example.org").await;
    app.member(south, Role::Instructor, "abroad@example.org").await;
    let mut before = app.signed_in("teacher@example.org").await;
    let mut head = app.signed_in("head@example.org").await;
    for (rule, status) in [("whoever", 400), ("teachers", 303)] {
        let set = send(&mut head, "/admin", "/admin/second-factor", &[("rule", rule)]).await;
        assert_eq!(set.status.as_u16(), status, "{}", set.text());
    }
    let after = app.signed_in("teacher@example.org").await;
    for client in [&mut before, &mut after.clone(), &mut head] {
        for path in ["/", "/cohorts", "/account", "/account/export", "/nothing", "/account/second-factors"] {
            for method in [Method::GET, Method::POST] {
                let answer = client.request(method.clone(), path).await;
                assert_eq!((answer.status.as_u16(), answer.header("location")), (303, PAGE), "{method} {path}");
            }
        }
        client.get("/api/v1/sessions").await.is_problem(401, "token");
        assert_eq!(client.get("/login").await.header("location"), "/", "and from there to it");
    }
    let mut client = after;
    let page = client.get(PAGE).await.text();
    assert!(page.contains("before you continue") && !page.contains("href=\"/cohorts\""), "{page}");
    enrol(&app, &mut client).await;
    assert_eq!(client.get("/cohorts").await.status, 200);
    assert_eq!(client.get("/api/v1/sessions").await.status, 200);
    for email in ["ada@example.org", "abroad@example.org"] {
        assert_eq!(app.signed_in(email).await.get("/").await.status, 200, "{email} is not asked");
    }
    assert_eq!(app.with_token(&teacher.token).get("/api/v1/sessions").await.status, 200, "programs go on");
    let rule: Vec<String> =
        sqlx::query_scalar("SELECT details FROM audit_log WHERE action = 'school.second_factor_set'")
            .fetch_all(app.state.db.reader())
            .await
            .unwrap();
    assert_eq!(rule, ["{\"asked_of\":\"teachers\"}"]);
}

#[tokio::test]
async fn who_owes_one_may_sign_out() {
    let (app, school) = app().await;
    app.member(school, Role::Administrator, "head@example.org").await;
    let mut head = app.signed_in("head@example.org").await;
    send(&mut head, "/admin", "/admin/second-factor", &[("rule", "teachers")]).await;
    assert_eq!(send(&mut head, PAGE, "/logout", &[]).await.header("location"), "/login");
    assert_eq!(head.get("/").await.header("location"), "/login");
}

#[tokio::test]
async fn a_copy_of_the_database_makes_no_codes() {
    let (app, school) = app().await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    let device = enrol(&app, &mut app.signed_in("ada@example.org").await).await;
    let (secret, codes): (Vec<u8>, i64) = sqlx::query_as(
        "SELECT sealed_secret, (SELECT count(*) FROM recovery_codes WHERE person_id = $1) FROM second_factors WHERE person_id = $1",
    )
    .bind(ada.person.id)
    .fetch_one(app.state.db.reader())
    .await
    .unwrap();
    assert_eq!(codes, 10);
    assert!(!secret.windows(8).any(|part| device.secret.bytes().windows(8).any(|own| own == part)));
    let key = app.folder.path().join(KEY_FILE);
    assert_eq!(std::fs::metadata(&key).unwrap().permissions().mode() & 0o777, 0o600);
    // A restored database beside another key: recovery codes help, codes of the app are told to be out of reach.
    std::fs::remove_file(&key).unwrap();
    let mut client = half(&app, "ada@example.org").await;
    let answer = say_code(&mut client, &device.code(&app)).await;
    assert!(answer.status == 409 && answer.text().contains("recovery code"), "{}", answer.text());
    assert_eq!(say_code(&mut client, &device.codes[0]).await.status, 303);
}

#[tokio::test]
async fn erasing_somebody_takes_their_second_factor_along() {
    let (app, school) = app().await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    app.member(school, Role::Administrator, "head@example.org").await;
    enrol(&app, &mut app.signed_in("ada@example.org").await).await;
    let mut head = app.signed_in("head@example.org").await;
    let page = format!("/people/{}", ada.person.id);
    let erased = send(&mut head, &page, &format!("{page}/erase"), &[("confirm", "ada@example.org")]).await;
    assert_eq!(erased.status, 303, "{}", erased.text());
    let left: i64 =
        sqlx::query_scalar("SELECT (SELECT count(*) FROM second_factors) + (SELECT count(*) FROM recovery_codes)")
            .fetch_one(app.state.db.reader())
            .await
            .unwrap();
    assert_eq!(left, 0);
}

#[tokio::test]
async fn whoever_runs_the_server_can_let_the_last_administrator_in() {
    // On the machine's clock: the program has no other.
    let app = App::new().await;
    let school = app.school("North").await;
    let head = app.member(school, Role::Administrator, "head@example.org").await;
    enrol(&app, &mut app.signed_in("head@example.org").await).await;
    let run = |email: &str| {
        let mut command = program(app.folder.path());
        command.args(["user", "reset-second-factor", "--email", email]);
        let done = command.output().unwrap();
        (done.status.code(), String::from_utf8(done.stdout).unwrap())
    };
    assert_eq!(run("nobody@example.org").0, Some(2));
    let (status, said) = run("head@example.org");
    assert!(status == Some(0) && said.contains("no longer has a second factor"), "{said}");
    assert!(run("head@example.org").1.contains("had no second factor"));
    assert_eq!(app.stranger().sign_in("head@example.org", PASSWORD).await.header("location"), "/");
    assert!(letters(&app).await.contains("head@example.org"));
    let by: String =
        sqlx::query_scalar("SELECT actor FROM audit_log WHERE action = 'second_factor.reset' AND object = $1")
            .bind(head.person.id.to_string())
            .fetch_one(app.state.db.reader())
            .await
            .unwrap();
    assert_eq!(by, "command line");
}

/// The numbered migrations before one, in a folder.
fn migrations_before(number: u32, folder: &Path) {
    std::fs::create_dir_all(folder).unwrap();
    for file in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../migrations")).unwrap() {
        let file = file.unwrap();
        let name = file.file_name().into_string().unwrap();
        if file.path().is_file() && name[..4].parse::<u32>().unwrap() < number {
            std::fs::copy(file.path(), folder.join(name)).unwrap();
        }
    }
}

#[tokio::test]
async fn what_was_queued_before_is_still_sent() {
    only_on!(Sqlite, "there was no PostgreSQL before");
    let folder = tempfile::tempdir().unwrap();
    migrations_before(180, &folder.path().join("migrations"));
    let file = format!("sqlite://{}", folder.path().join("stylet.db").display());
    let options = SqliteConnectOptions::from_str(&file).unwrap().create_if_missing(true);
    let mut old = SqliteConnection::connect_with(&options).await.unwrap();
    Migrator::new(folder.path().join("migrations")).await.unwrap().run(&mut old).await.unwrap();
    let rows = "INSERT INTO schools (id, name, created_at) VALUES (zeroblob(16), 'North', 0);
        INSERT INTO people (id, school_id, role, email, display_name, pseudonym, password_hash, created_at)
        VALUES (randomblob(16), zeroblob(16), 'trainee', 'ada@example.org', 'Ada', 'p-1', '', 0);
        INSERT INTO mails (id, school_id, person_id, kind, next_run_at)
        SELECT randomblob(16), school_id, id, 'invitation', 1 FROM people;
        INSERT INTO mails (id, school_id, person_id, kind, tries, error)
        SELECT randomblob(16), school_id, id, 'reset', 7, 'gone' FROM people;
        INSERT INTO api_tokens (id, school_id, person_id, token_sha256, created_at)
        SELECT randomblob(16), school_id, id, randomblob(32), 0 FROM people;";
    sqlx::raw_sql(rows).execute(&mut old).await.unwrap();
    old.close().await.unwrap();
    let app = App::in_folder(folder, Clock::system(), |_| {}).await;
    assert!(letters(&app).await.contains("/join/"));
    let kept: Vec<(String, i64, Option<String>)> = sqlx::query_as("SELECT kind, tries, error FROM mails ORDER BY kind")
        .fetch_all(app.state.db.reader())
        .await
        .unwrap();
    let expected = [("invitation".to_owned(), 1, None), ("reset".to_owned(), 7, Some("gone".to_owned()))];
    assert_eq!(kept, expected);
    assert_eq!(app.state.db.integrity().await.unwrap(), Vec::<String>::new());
}

#[tokio::test]
async fn what_was_offered_long_ago_is_turned_on_by_nobody() {
    let (app, school) = app().await;
    app.member(school, Role::Trainee, "ada@example.org").await;
    let mut ada = app.signed_in("ada@example.org").await;
    let device = Device { secret: begin(&mut ada).await, codes: Vec::new() };
    app.state.clock.advance(31 * 60);
    let late = send(&mut ada, PAGE, &format!("{PAGE}/confirm"), &[("code", &device.code(&app))]).await;
    assert!(late.status == 409 && !ada.get(PAGE).await.text().contains("secret="), "{}", late.text());
}
