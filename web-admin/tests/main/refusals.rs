//! Who asks for what is not theirs is written down. Fails when a refusal leaves no entry in the service's log, or one that does not say who
//! asked for what from where; when what everybody may ask for leaves one; and when somebody fills the log.

use std::path::Path;

use model::Role;
use model::ids::{PersonId, SessionId};
use serde_json::Value;
use tempfile::TempDir;
use uuid::Uuid;

use crate::support::App;
use crate::support::service::{Service, answer};

/// Two schools, with somebody of the first who is signed in.
struct World {
    folder: TempDir,
    cookie: String,
    trainee: (PersonId, String),
    abroad: PersonId,
    station: String,
}

impl World {
    async fn new() -> Self {
        let app = App::new().await;
        let (north, south) = (app.school("North").await, app.school("South").await);
        let trainee = app.member(north, Role::Trainee, "ada@example.org").await;
        let abroad = app.member(south, Role::Trainee, "eve@example.org").await;
        let cookie = app.signed_in("ada@example.org").await.cookie.unwrap();
        let station = app.station(north).await;
        app.state.db.close().await;
        let trainee = (trainee.person.id, trainee.token);
        Self { folder: app.folder, cookie, trainee, abroad: abroad.person.id, station }
    }
}

/// What the log says of refusals, an object an entry.
fn refusals(log: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(log).unwrap();
    let entries = text.lines().map(|line| serde_json::from_str::<Value>(line).expect(line));
    entries.filter(|entry| entry["message"].as_str().unwrap().starts_with("request refused")).collect()
}

#[tokio::test]
async fn a_refusal_says_who_asked_for_what_from_where() {
    let world = World::new().await;
    let log = world.folder.path().join("log");
    let options = ["--log-format", "json", "--behind-tls"];
    let service = Service::start_logging(world.folder.path(), &options, &log);
    let (id, token) = &world.trainee;
    // The cookie of before has another name behind TLS.
    let cookie = world.cookie.replace("stylet_", "__Host-stylet_");
    let line = |request: &str| format!("{request} HTTP/1.1\r\nX-Forwarded-For: 2001:db8::7\r\nCookie: {cookie}");
    let ask = |request: &str, token: &str| answer(service.begin(&line(request), token, &[])).0;
    let attempt = SessionId::from_u128(7);

    assert_eq!(ask("GET /people", ""), 403, "the page of administrators");
    assert_eq!(ask(&format!("GET /trainees/{}", world.abroad), ""), 404, "somebody of another school");
    assert_eq!(ask(&format!("GET /api/v1/sessions/{attempt}/score"), token), 404);
    assert_eq!(ask("GET /api/v1/sessions", &world.station), 403, "a station's token reads no attempts");
    assert_eq!(ask("GET /api/v1/sessions", "0123"), 401, "nobody's token");
    for fine in ["GET /account", "GET /nothing/here", "GET /assets/nothing", "GET /"] {
        ask(fine, "");
    }
    assert_eq!(ask("GET /api/v1/sessions", token), 200);

    let told = refusals(&log);
    let told: Vec<_> = told
        .iter()
        .map(|entry| {
            let text = |name: &str| entry[name].as_str().unwrap_or_default().to_owned();
            assert_eq!(
                (text("level"), text("from"), text("method")),
                ("WARN".into(), "2001:db8::".into(), "GET".into())
            );
            (text("who"), text("role"), text("route"), text("object"), entry["status"].as_u64().unwrap())
        })
        .collect();
    let entry = |who: &str, role: &str, route: &str, object: &str, status: u64| {
        (who.to_owned(), role.to_owned(), route.to_owned(), object.to_owned(), status)
    };
    let ada = id.to_string();
    assert_eq!(
        told[..3],
        [
            entry(&ada, "trainee", "/people", "", 403),
            entry(&ada, "trainee", "/trainees/{id}", &world.abroad.to_string(), 404),
            entry(&ada, "trainee", "/api/v1/sessions/{id}/score", &attempt.to_string(), 404),
        ]
    );
    assert_eq!((told[3].1.as_str(), told[3].2.as_str(), told[3].4), ("station", "/api/v1/sessions", 403));
    assert_eq!(told[4], entry("stranger", "none", "/api/v1/sessions", "", 401));
    assert_eq!(told.len(), 5, "{told:?}");
}

#[tokio::test]
async fn nobody_fills_the_log() {
    let world = World::new().await;
    let log = world.folder.path().join("log");
    let service = Service::start_logging(world.folder.path(), &["--log-format", "json"], &log);
    for _ in 0..60 {
        let head = format!("GET /api/v1/exercises/{} HTTP/1.1", Uuid::from_u128(7));
        assert_eq!(answer(service.begin(&head, &world.trainee.1, &[])).0, 404);
    }
    let told = refusals(&log).len();
    assert!((20..25).contains(&told), "{told} entries");
    // Somebody else is still seen.
    assert_eq!(answer(service.begin("GET /api/v1/sessions HTTP/1.1", &world.station, &[])).0, 403);
    assert_eq!(refusals(&log).last().unwrap()["role"], "station");
}
