//! Signing in and out. Fails when guessing is not braked, when a form of another site is taken, when a session keeps
//! its id over a sign-in or outlives a new password, or when an unknown address answers otherwise than a known one.

use std::net::IpAddr;

use acts::auth::rate_limits;
use acts::operations::upkeep;
use axum::body::Body;
use axum::http::{Request, header};
use model::ids::SchoolId;
use model::{Moment, Role};
use platform::clock::Clock;
use platform::secret;
use store::people;

use crate::support::client::{csrf_in, without_csrf};
use crate::support::database::rows_of;
use crate::support::{App, PASSWORD};

async fn app() -> App {
    let app = App::new().await;
    let school = app.school("North").await;
    app.member(school, Role::Trainee, "ada@example.org").await;
    app
}

#[tokio::test]
async fn the_right_password_signs_in_under_a_new_session_id() {
    let app = app().await;
    let mut ada = app.stranger();
    let csrf = ada.csrf().await;
    // An id that somebody has planted: of a session that they have themselves.
    app.member(app.school("North").await, Role::Trainee, "eve@example.org").await;
    let planted = app.signed_in("eve@example.org").await.cookie_named("stylet_session").unwrap();
    ada.cookie = Some(format!("{}; stylet_session={planted}", ada.cookie.unwrap()));
    let hers = csrf_in(&ada.get("/account").await.text());
    let fields = [("email", "Ada@Example.org"), ("password", PASSWORD), ("next", "/cohorts")];
    assert_eq!(ada.form("/login", &[&[("csrf", csrf.as_str())], &fields[..]].concat()).await.status, 403);
    let answer = ada.form("/login", &[&[("csrf", hers.as_str())], &fields[..]].concat()).await;
    assert_eq!((answer.status.as_u16(), answer.header("location")), (303, "/cohorts"));
    assert_ne!(ada.cookie_named("stylet_session").unwrap(), planted, "an id that was planted before is worth nothing");
    let set = answer.header("set-cookie");
    assert!(set.contains("HttpOnly") && set.contains("SameSite=Lax") && !set.contains("Secure"), "{set}");
    let mut stranger = app.stranger();
    stranger.cookie = Some(format!("stylet_session={planted}"));
    assert_eq!(stranger.get("/").await.header("location"), "/login");
    let back = ada.get("/login?next=//evil.example").await;
    assert_eq!((back.status.as_u16(), back.header("location")), (303, "/"));
}

/// Every row of every table, as text, but for the pulse of the service itself.
async fn everything(app: &App) -> Vec<String> {
    let db = &app.state.db;
    let mut tables = db.list_tables().await.unwrap();
    tables.retain(|table| table != "heartbeat" && table != "sqlite_schema");
    let mut found = Vec::new();
    for table in tables {
        found.extend(rows_of(db, &table).await);
    }
    found
}

#[tokio::test]
async fn whoever_only_looks_writes_no_row() {
    let app = app().await;
    let before = everything(&app).await;
    let pages: Vec<&str> = include_str!("../every_route.txt")
        .lines()
        .filter_map(|line| line.strip_prefix("GET")?.split_whitespace().next())
        .filter(|path| *path != "/readyz")
        .collect();
    assert!(pages.len() > 60, "{pages:?}");
    for (n, page) in pages.iter().cycle().take(1000.max(pages.len())).enumerate() {
        let mut stranger = app.stranger();
        // As a browser comes that was here before, with what has ended, or with nonsense.
        stranger.cookie = match n % 4 {
            0 => None,
            1 => Some("stylet_session=AAAAAAAAAAAAAAAAAAAAAA; stylet_form=0".to_owned()),
            2 => Some(format!("stylet_session=nonsense; stylet_form={}", "a".repeat(64))),
            _ => Some("stylet_session=; stylet_language=de".to_owned()),
        };
        let answer = stranger.get(&page.replace(['{', '}'], "")).await;
        assert!(answer.status.as_u16() < 500, "{page}: {}", answer.text());
        assert_eq!(
            stranger
                .cookie_named("stylet_session")
                .filter(|id| !id.is_empty() && !id.contains("AAAA") && id != "nonsense"),
            None,
            "{page}"
        );
    }
    assert_eq!(everything(&app).await, before);
    app.signed_in("ada@example.org").await;
    assert_ne!(everything(&app).await, before, "rows begin with signing in");
}

#[tokio::test]
async fn behind_tls_the_cookie_is_secure_and_browsers_are_told_so() {
    let app = App::with(Clock::system(), |config| config.behind_tls = true).await;
    let page = app.stranger().get("/login").await;
    let set = page.header("set-cookie");
    let of_host = set.starts_with("__Host-") && set.contains("Path=/") && !set.contains("Domain");
    assert!(of_host && set.contains("Secure"), "{set}");
    assert!(page.header("strict-transport-security").contains("max-age"));
}

#[tokio::test]
async fn twelve_hours_are_twelve_hours_whatever_is_done_meanwhile() {
    let app = App::with(Clock::fixed(Moment::from_micros(1_700_000_000_000_000)), |_| {}).await;
    let school = app.school("North").await;
    app.member(school, Role::Trainee, "ada@example.org").await;
    let mut ada = app.signed_in("ada@example.org").await;
    let hour = 3600;
    for _ in 0..11 {
        app.state.clock.advance(hour);
        // A form is written into the session.
        let page = ada.get("/account").await;
        assert!(!csrf_in(&page.text()).is_empty());
    }
    app.state.clock.advance(hour - 1);
    assert_eq!(ada.get("/").await.status, 200);
    app.state.clock.advance(1);
    assert_eq!(ada.get("/").await.header("location"), "/login");
}

#[tokio::test]
async fn a_wrong_password_and_an_unknown_address_look_the_same() {
    let app = app().await;
    let mut stranger = app.stranger();
    let wrong = stranger.sign_in("ada@example.org", "wrong").await;
    let unknown = stranger.sign_in("eve@example.org", "wrong").await;
    assert_eq!((wrong.status.as_u16(), unknown.status.as_u16()), (401, 401));
    // The token is masked anew on each page.
    let [wrong, unknown] = [wrong, unknown].map(|page| page.text().replace(&csrf_in(&page.text()), ""));
    assert_eq!(wrong.replace("ada@", "eve@"), unknown, "the pages differ in the address typed only");
    assert_eq!(stranger.get("/").await.header("location"), "/login");
}

#[tokio::test]
async fn twenty_wrong_passwords_make_even_the_right_one_wait() {
    let app = app().await;
    let mut eve = app.stranger();
    let mut statuses = Vec::new();
    for _ in 0..20 {
        statuses.push(eve.sign_in("ada@example.org", "wrong").await.status.as_u16());
    }
    assert_eq!((statuses[0], statuses[19]), (401, 429), "{statuses:?}");
    let right = app.stranger().sign_in("ada@example.org", PASSWORD).await;
    assert_eq!(right.status, 429);
    assert!(right.header("retry-after").parse::<u64>().unwrap() > 0);
}

/// Whether somebody may try to sign in; the try is counted.
async fn may_try(app: &App, address: IpAddr, email: &str) -> bool {
    let accounts = people::list_people_by_email(app.state.db.reader(), email).await.unwrap();
    let accounts = accounts.iter().map(|account| account.id).collect();
    rate_limits::take_sign_in(&app.state, address, email, accounts).await.is_ok()
}

#[tokio::test]
async fn guessing_many_accounts_from_one_address_is_braked_too() {
    let app = app().await;
    let address = IpAddr::from([192, 0, 2, 1]);
    let mut taken = 0;
    for n in 0..200 {
        taken += u32::from(may_try(&app, address, &format!("{n}@example.org")).await);
    }
    assert!((50..150).contains(&taken), "{taken} accounts could be tried at once");
    assert!(may_try(&app, [192, 0, 2, 2].into(), "0@example.net").await, "others may go on");
    upkeep::forget_expired(&app.state).await.unwrap();
    assert!(!may_try(&app, address, "1@example.net").await, "tidying forgets no recent guess");
}

#[tokio::test]
async fn a_stranger_uses_up_nobody_elses_tries() {
    let app = app().await;
    let home = IpAddr::from([192, 0, 2, 200]);
    assert!(may_try(&app, home, "ada@example.org").await);
    let ada = people::find_person_by_email(app.state.db.reader(), "ada@example.org").await.unwrap().unwrap();
    rate_limits::welcome(&app.state, home, ada.id).await.unwrap();
    let mut one = 0;
    for _ in 0..50 {
        one += u32::from(may_try(&app, [192, 0, 2, 1].into(), "ada@example.org").await);
    }
    assert!(one <= 12, "{one} tries for one account from one address");
    assert!(may_try(&app, [192, 0, 2, 2].into(), "ADA@example.org").await, "somewhere else she may");
    let mut many = 0;
    for host in (3..100).flat_map(|host| [host; 10]) {
        many += u32::from(may_try(&app, [192, 0, 2, host].into(), "ada@example.org").await);
    }
    assert!(many < 150, "{many} tries for one account from a hundred addresses");
    assert!(may_try(&app, home, "ada@example.org").await, "where she has signed in before, she still may");
}

#[tokio::test]
async fn a_stolen_session_guesses_no_password() {
    let app = app().await;
    let mut thief = app.signed_in("ada@example.org").await;
    let mut statuses = Vec::new();
    for _ in 0..12 {
        let csrf = csrf_in(&thief.get("/account").await.text());
        let fields = [
            ("csrf", csrf.as_str()),
            ("old", "a guess"),
            ("password", "vier Käse im Wind"),
            ("again", "vier Käse im Wind"),
        ];
        statuses.push(thief.form("/account/password", &fields).await.status.as_u16());
    }
    assert_eq!((statuses[0], statuses[11]), (422, 429), "{statuses:?}");
    let refused = log(&app).await.into_iter().filter(|line| line.starts_with("person.password_refused")).count();
    assert!((1..12).contains(&refused), "{refused}");
}

/// Action, actor and object of every entry of the audit log.
async fn log(app: &App) -> Vec<String> {
    let lines = sqlx::query_scalar(
        "SELECT action || ' ' || actor || ' ' || object || ' ' || details FROM audit_log ORDER BY seq",
    );
    lines.fetch_all(app.state.db.reader()).await.unwrap()
}

#[tokio::test]
async fn failed_sign_in_is_audited_without_the_typed_text() {
    let app = app().await;
    let ada = people::find_person_by_email(app.state.db.reader(), "ada@example.org").await.unwrap().unwrap();
    let mut eve = app.stranger();
    eve.sign_in("my-secret-in-the-wrong-field", "typed").await;
    for _ in 0..20 {
        eve.sign_in("ada@example.org", "wrong-guess").await;
    }
    let log = log(&app).await;
    let count = |start: &str| log.iter().filter(|line| line.starts_with(start)).count();
    assert_eq!(count(&format!("sign_in.failed stranger {}", ada.id)), 10, "{log:#?}");
    assert_eq!(count(&format!("sign_in.blocked stranger {}", ada.id)), 1, "a flood is one line: {log:#?}");
    let unknown = "SELECT CAST(coalesce(sum(tries), 0) AS BIGINT) FROM unknown_sign_ins";
    let unknown: i64 = sqlx::query_scalar(unknown).fetch_one(app.state.db.reader()).await.unwrap();
    assert_eq!(unknown, 1, "an address that nobody has is counted alone");
    assert!(
        !log.iter().any(|line| line.contains("secret") || line.contains("guess") || line.contains("ada@")),
        "{log:#?}"
    );
    let of_school: Vec<Option<SchoolId>> =
        sqlx::query_scalar("SELECT school_id FROM audit_log WHERE action = 'sign_in.failed' AND school_id IS NOT NULL")
            .fetch_all(app.state.db.reader())
            .await
            .unwrap();
    assert_eq!(of_school.len(), 10, "her school's administrators see them");
}

#[tokio::test]
async fn a_forgotten_password_costs_the_same_whoever_asks() {
    let app = app().await;
    let before = log(&app).await;
    let mut stranger = app.stranger();
    for email in ["ada@example.org", "nobody@example.org", &"x".repeat(100_000)] {
        let csrf = csrf_in(&stranger.get("/forgotten").await.text());
        assert_eq!(stranger.form("/forgotten", &[("csrf", &csrf), ("email", email)]).await.status, 200);
    }
    let count = async |table| {
        let query = format!("SELECT count(*) FROM {table}");
        sqlx::query_scalar::<_, i64>(sqlx::AssertSqlSafe(query)).fetch_one(app.state.db.reader()).await.unwrap()
    };
    assert_eq!((count("asked_links").await, count("mails").await), (3, 0), "nobody was looked up");
    assert_eq!(log(&app).await, before);
    web_admin::outbox::work_off_letters(&app.state).await.unwrap();
    assert_eq!((count("asked_links").await, count("mails").await), (0, 1));
    assert!(log(&app).await.last().unwrap().starts_with("person.link_asked_for"));
}

#[tokio::test]
async fn nobody_fills_the_box_of_somebody_by_asking_for_their_link() {
    let app = App::with(Clock::fixed(Moment::from_micros(1_700_000_000_000_000)), |_| {}).await;
    let school = app.school("North").await;
    app.member(school, Role::Trainee, "ada@example.org").await;
    let ask = async || {
        let mut stranger = app.stranger();
        let csrf = csrf_in(&stranger.get("/forgotten").await.text());
        assert_eq!(stranger.form("/forgotten", &[("csrf", &csrf), ("email", "ada@example.org")]).await.status, 200);
        web_admin::outbox::work_off_letters(&app.state).await.unwrap();
        log(&app).await.iter().filter(|line| line.starts_with("person.link_asked_for")).count()
    };
    assert_eq!([ask().await, ask().await, ask().await], [1, 1, 1]);
    app.state.clock.advance(601);
    assert_eq!(ask().await, 2, "who has lost the letter asks again");
}

#[tokio::test]
async fn a_form_without_its_token_is_refused() {
    let app = app().await;
    let mut ada = app.stranger();
    let csrf = ada.csrf().await;
    for fields in [
        vec![("email", "ada@example.org"), ("password", PASSWORD)],
        vec![("csrf", "0"), ("email", "ada@example.org"), ("password", PASSWORD)],
    ] {
        assert_eq!(ada.form("/login", &fields).await.status, 403);
    }
    let fields = [("csrf", csrf.as_str()), ("email", "ada@example.org"), ("password", PASSWORD)];
    assert_eq!(app.stranger().form("/login", &fields).await.status, 403, "another session's token");
    let mut ada = app.signed_in("ada@example.org").await;
    assert_eq!(ada.form("/logout", &[]).await.status, 403);
    assert_ne!(ada.get("/").await.header("location"), "/login", "still signed in");
    let not_a_form = Request::post("/logout").header(header::CONTENT_TYPE, "application/json").body(Body::from("{}"));
    assert_eq!(ada.send(not_a_form.unwrap()).await.status, 415);
}

#[tokio::test]
async fn signing_out_ends_the_session_everywhere() {
    let app = app().await;
    let mut ada = app.signed_in("ada@example.org").await;
    let kept = ada.clone();
    let csrf = csrf_in(&ada.get("/").await.text());
    assert_eq!(ada.form("/logout", &[("csrf", &csrf)]).await.header("location"), "/login");
    for mut client in [ada, kept] {
        assert_eq!(client.get("/").await.header("location"), "/login");
    }
}

#[tokio::test]
async fn a_new_password_and_being_disabled_end_every_sign_in() {
    let app = app().await;
    let mut ada = app.signed_in("ada@example.org").await;
    let person = people::find_person_by_email(app.state.db.reader(), "ada@example.org").await.unwrap().unwrap();
    let hash = secret::hash_password("another password", app.state.config.password_cost).unwrap();
    assert!(app.write(async |tx| people::set_password(tx, person.id, &hash).await.unwrap()).await);
    assert_eq!(ada.get("/").await.header("location"), "/login");
    assert_eq!(ada.sign_in("ada@example.org", PASSWORD).await.status, 401);
    assert_eq!(ada.sign_in("ada@example.org", "another password").await.status, 303);
    let now = app.state.clock.now();
    assert!(app.write(async |tx| people::disable_person(tx, person.id, now).await.unwrap()).await);
    assert!(!app.write(async |tx| people::disable_person(tx, person.id, now).await.unwrap()).await, "once is enough");
    assert_eq!(ada.get("/").await.header("location"), "/login");
    assert_eq!(ada.sign_in("ada@example.org", "another password").await.status, 401);
}

#[tokio::test]
async fn who_signed_in_before_does_not_wait_for_strangers() {
    let app = app().await;
    assert_eq!(app.stranger().sign_in("ada@example.org", PASSWORD).await.status, 303);
    let _taken = app.state.hashing_strangers.clone().acquire_owned().await.unwrap();
    let crowded = app.stranger().sign_in("nobody@example.org", "a wrong password").await;
    assert_eq!((crowded.status.as_u16(), crowded.header("retry-after")), (503, "2"), "{}", crowded.text());
    assert!(crowded.text().contains("too many people are signing in right now"), "{}", crowded.text());
    assert_eq!(app.stranger().sign_in("ada@example.org", PASSWORD).await.status, 303, "from the same address");
}

#[tokio::test]
async fn tries_with_unknown_addresses_are_counted_by_the_hour() {
    let app = App::with(Clock::fixed(Moment::from_micros(1_700_000_000_000_000)), |_| {}).await;
    let rows = "SELECT count(*) FROM audit_log WHERE action LIKE 'sign_in.%'";
    let count =
        async |sql: &'static str| sqlx::query_scalar::<_, i64>(sql).fetch_one(app.state.db.reader()).await.unwrap();
    for name in ["one", "two", "three"] {
        let answer = app.stranger().sign_in(&format!("{name}@example.org"), "a wrong password").await;
        assert_eq!(answer.status, 401);
    }
    upkeep::forget_expired(&app.state).await.unwrap();
    assert_eq!(count(rows).await, 0, "the hour is not over");
    app.state.clock.advance(3600);
    upkeep::forget_expired(&app.state).await.unwrap();
    upkeep::forget_expired(&app.state).await.unwrap();
    assert_eq!(count(rows).await, 1, "one row for three tries");
    let told = "SELECT CAST(details ->> 'tries' AS BIGINT) FROM audit_log WHERE action = 'sign_in.unknown_failed'";
    assert_eq!(count(told).await, 3);
}

#[tokio::test]
async fn a_second_tab_with_the_form_leads_where_it_would_have() {
    let app = app().await;
    let mut ada = app.stranger();
    let stale = ada.csrf().await;
    assert_eq!(ada.sign_in("ada@example.org", PASSWORD).await.status, 303);
    let fields = |email, next| [("csrf", stale.as_str()), ("email", email), ("password", PASSWORD), ("next", next)];
    for (email, next, to) in [("ADA@example.org", "/account", "/account"), ("ada@example.org", "//evil.example", "/")] {
        let second = ada.form("/login", &fields(email, next)).await;
        assert_eq!((second.status.as_u16(), second.header("location")), (303, to));
    }
    let other = ada.form("/login", &fields("eve@example.org", "/")).await;
    assert_eq!(other.status, 403, "somebody else is signed in here");
    let again = app.stranger().form("/login", &fields("ada@example.org", "/account")).await;
    assert_eq!(again.status, 403);
    let page = again.text();
    assert!(page.contains("out of date") && page.contains("value=\"ada@example.org\""), "the form again: {page}");
}

#[tokio::test]
async fn a_password_is_the_same_however_a_keyboard_composes_it() {
    let (composed, apart) = ("Übergrößenträger 27", "U\u{308}bergro\u{308}ßentra\u{308}ger 27");
    for kept in [composed, apart] {
        let app = app().await;
        let person = people::find_person_by_email(app.state.db.reader(), "ada@example.org").await.unwrap().unwrap();
        let hash = secret::hash_password(kept, app.state.config.password_cost).unwrap();
        assert!(app.write(async |tx| people::set_password(tx, person.id, &hash).await.unwrap()).await);
        for typed in [composed, apart] {
            assert_eq!(app.stranger().sign_in("ada@example.org", typed).await.status, 303, "{kept:?} {typed:?}");
        }
        assert_eq!(app.stranger().sign_in("ada@example.org", "Ubergroßentrager 27").await.status, 401);
    }
}

/// Headers by which an authenticating proxy names a user to a service that trusts it.
const HEADERS_OF_PROXIES: [&str; 12] = [
    "remote-user",
    "remote_user",
    "x-remote-user",
    "x-remote-email",
    "x-remote-name",
    "x-forwarded-user",
    "x-forwarded-email",
    "x-forwarded-preferred-username",
    "x-auth-request-user",
    "x-auth-request-email",
    "x-webauth-user",
    "eppn",
];

#[tokio::test]
async fn headers_of_proxies_change_nothing() {
    let app = app().await;
    let school = app.school("North").await;
    app.member(school, Role::Administrator, "head@example.org").await;
    for mut browser in [app.stranger(), app.signed_in("ada@example.org").await] {
        for path in
            ["/", "/login", "/account", "/people", "/admin", "/sign-in/join", "/api/v1/sessions", "/scim/v2/Users"]
        {
            let plain = browser.get(path).await;
            let mut request = Request::get(path).body(Body::empty()).unwrap();
            for name in HEADERS_OF_PROXIES {
                request.headers_mut().append(name, "head@example.org".parse().unwrap());
            }
            let named = browser.send(request).await;
            assert_eq!((named.status, named.header("location")), (plain.status, plain.header("location")), "{path}");
            if plain.text().contains("name=\"csrf\"") {
                assert_eq!(without_csrf(&named.text()), without_csrf(&plain.text()), "{path}");
            } else {
                assert_eq!(named.text(), plain.text(), "{path}");
            }
        }
    }
}
