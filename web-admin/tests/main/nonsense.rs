//! Whatever somebody types into a field of a form, or a program says to the API, is answered: taken or refused, but never with a
//! failure of the service. The forms are those of the pages themselves, for each kind of visitor who sees them; each of their fields
//! in turn holds what nobody should send, the others what the page put there; of the rows of a list, the first is tried. Fails at a
//! panic, at an answer of 500 or more, and where a page's forms are no longer found.

use std::collections::BTreeSet;

use axum::body::Body;
use axum::http::{Method, Request, header};
use model::Role;
use scraper::{ElementRef, Html, Selector};
use serde_json::Value;

use crate::every_route::{Visitor, World, rows};
use crate::support::App;
use crate::support::client::{Client, csrf_in, encoded};

/// What nobody should send: nothing, too much, numbers beyond every type, days that do not exist or are too far away, other alphabets,
/// and what means something to a shell, a database, a header, a path or a browser.
const NONSENSE: [&str; 24] = [
    "",
    " ",
    "\0",
    "-1",
    "0",
    "1e308",
    "-1e-320",
    "NaN",
    "inf",
    "9223372036854775807",
    "-9223372036854775808",
    "99999999999999999999999",
    "2026-13-45T99:99",
    "0000-01-01T00:00",
    "9999-12-31T23:59",
    "-9999-01-01",
    "00000000-0000-0000-0000-000000000000",
    "\u{202e}😀\u{0301}ß\u{feff}",
    "</textarea><script>alert(1)</script>",
    "' OR 1=1; --",
    "=cmd|' /C calc'!A0",
    "a\r\nSet-Cookie: a=b",
    "../../../../etc/passwd",
    "[[[[{{{{\"",
];
/// Characters of a text that is too long: more than any field takes, less than an address may have.
const TOO_LONG: usize = 60_000;

/// Most buttons of a form with each of which every field is spoilt. The form of a document has a hundred, for its rows: there every field is
/// spoilt with the first, and with the others, which have the fields read as the first does, it is sent as it stands.
const FEW_BUTTONS: usize = 4;

/// A form as it stands on a page.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Form {
    post: bool,
    action: String,
    /// Whether its fields are spoilt with the button that is pressed.
    spoilt: bool,
    /// Names, and what the page put there.
    fields: Vec<(String, String)>,
}

impl Form {
    /// The form, once for each button that says something; none for a form that sends a file, whose parser is fuzzed.
    fn read(form: ElementRef<'_>, page: &str) -> Vec<Self> {
        let of = |name| form.value().attr(name);
        if of("enctype").is_some_and(|kind| kind.starts_with("multipart")) {
            return Vec::new();
        }
        let named = Selector::parse("[name]").unwrap();
        let (buttons, others): (Vec<_>, Vec<_>) =
            form.select(&named).partition(|field| field.value().name() == "button");
        let mut fields = Vec::new();
        for field in others {
            let name = field.value().attr("name").unwrap_or_default();
            let again = field.value().attr("type") == Some("radio") && fields.iter().any(|(known, _)| known == name);
            if !again {
                fields.push((name.to_owned(), value(field)));
            }
        }
        let plain = Self {
            post: of("method").is_some_and(|method| method.eq_ignore_ascii_case("post")),
            action: of("action").unwrap_or(page).to_owned(),
            spoilt: true,
            fields,
        };
        let pressed = |(button, element): (usize, &ElementRef<'_>)| {
            let name = element.value().attr("name").unwrap_or_default().to_owned();
            let fields = plain.fields.iter().cloned().chain([(name, value(*element))]).collect();
            Self { spoilt: button == 0 || buttons.len() <= FEW_BUTTONS, fields, ..plain.clone() }
        };
        if buttons.is_empty() { vec![plain] } else { buttons.iter().enumerate().map(pressed).collect() }
    }

    /// The places of the fields that are spoilt: of the rows of a list, whose names differ in a number alone, those of the first.
    fn spoilt_fields(&self) -> Vec<usize> {
        let mut known = BTreeSet::from(["csrf".to_owned()]);
        let kind = |name: &str| name.split(|c: char| c.is_ascii_digit()).filter(|part| !part.is_empty()).collect();
        (0..self.fields.len()).filter(|at| known.insert(kind(&self.fields[*at].0))).collect()
    }

    /// The same form with something else in a field.
    fn with(&self, at: usize, nonsense: &str) -> Self {
        let mut other = self.clone();
        nonsense.clone_into(&mut other.fields[at].1);
        other
    }

    /// Whether an answer is a failure. The way to a provider of identities is closed here: it does not answer.
    fn is_broken_by(&self, status: u16) -> bool {
        let ways = ["/sign-in/", "/account/prove/", "/account/identities/join/"];
        let leaves = ways.iter().any(|way| self.action.starts_with(way)) || self.action.ends_with("/try");
        status >= 500 && !(leaves && status == 503)
    }

    async fn send(&self, client: &mut Client) -> u16 {
        let fields: Vec<_> = self.fields.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect();
        let answer = match self.post {
            true => client.form(&self.action, &fields).await,
            false => {
                let path = self.action.split('?').next().unwrap_or_default();
                client.get(&format!("{path}?{}", encoded(&fields))).await
            }
        };
        answer.status.as_u16()
    }

    /// The form without what a page writes into it, but for its button: the same on every page.
    fn shape(&self) -> (String, Vec<String>, Option<String>) {
        let names = self.fields.iter().map(|(name, _)| name.clone()).collect();
        (self.action.clone(), names, self.fields.last().map(|(_, value)| value.clone()))
    }
}

/// What a browser would send of a field that nobody touches; of a choice, the first.
fn value(field: ElementRef<'_>) -> String {
    let chosen = Selector::parse("option").unwrap();
    match field.value().name() {
        "textarea" => field.text().collect(),
        "select" => {
            field.select(&chosen).find_map(|option| option.value().attr("value")).unwrap_or_default().to_owned()
        }
        _ => field.value().attr("value").unwrap_or_default().to_owned(),
    }
}

fn client(app: &App, visitor: &Visitor, api: bool) -> Client {
    let mut client = Client::new(app.router.clone());
    client.cookie = visitor.cookie.clone().filter(|_| !api);
    client.token = visitor.token.clone().filter(|_| api);
    client
}

/// The forms of every page that a visitor is shown.
async fn forms(world: &World, app: &App, visitor: &Visitor) -> Vec<Form> {
    let every = Selector::parse("form").unwrap();
    let mut found = Vec::new();
    for row in rows().iter().filter(|row| row.method == Method::GET && !row.path.starts_with("/api/")) {
        let path = world.filled(row.path);
        let page = client(app, visitor, false).get(&path).await;
        if page.status == 200 && page.header("content-type").starts_with("text/html") {
            let html = Html::parse_document(&page.text());
            found.extend(html.select(&every).flat_map(|form| Form::read(form, &path)));
        }
    }
    found
}

#[tokio::test]
async fn no_field_of_any_form_breaks_the_service() {
    let world = World::new().await;
    let too_long = "x".repeat(TOO_LONG);
    let (mut seen, mut broken) = (BTreeSet::new(), Vec::new());
    for visitor in world.visitors.iter().filter(|visitor| visitor.column != "station") {
        let fresh = world.open().await;
        for form in forms(&world, &fresh, visitor).await {
            if !seen.insert(form.shape()) {
                continue;
            }
            if !form.spoilt {
                let status = form.send(&mut client(&fresh, visitor, false)).await;
                if form.is_broken_by(status) {
                    broken.push(format!("{} {}: {:?}: {status}", visitor.column, form.action, form.fields.last()));
                }
                continue;
            }
            let app = world.open().await;
            let mut client = client(&app, visitor, false);
            for at in form.spoilt_fields() {
                for nonsense in NONSENSE.into_iter().chain([too_long.as_str()]) {
                    let status = form.with(at, nonsense).send(&mut client).await;
                    if form.is_broken_by(status) {
                        let start: String = nonsense.chars().take(40).collect();
                        broken.push(format!(
                            "{} {}: {} = {start:?}: {status}",
                            visitor.column, form.action, form.fields[at].0
                        ));
                    }
                }
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    assert!(seen.len() > 60, "forms: {}", seen.len());
}

/// Bodies that the API takes, whole and valid but for ids that nobody has.
const SAID: [(&str, &str, &str); 4] = [
    ("POST", "/api/v1/sessions/{session}/comments", r#"{"kind":"question","from_s":0.1,"to_s":0.2,"body":"Why?"}"#),
    (
        "PUT",
        "/api/v1/sessions/{session}/survey/{survey}",
        r#"{"secret":"0123456789abcdef0123456789abcdef","language":"en","consent":true,"answers":{"q1":["3"]},"sent":true}"#,
    ),
    ("POST", "/api/v1/stations/sign-in", r#"{"code":"WRONG2"}"#),
    ("POST", "/api/v1/stations/pair", r#"{"code":"WRONG2","name":"Room 1"}"#),
];

/// A body with something else in each of its places in turn, and what is no such body at all.
fn spoilt(body: &str) -> Vec<String> {
    let whole: Value = serde_json::from_str(body).unwrap();
    let others = NONSENSE.into_iter().map(Value::from).chain(
        ["null", "[]", "{}", "-1", "1e308", "18446744073709551616", "true", "[[[[null]]]]"]
            .map(|json| serde_json::from_str(json).unwrap()),
    );
    let others: Vec<Value> = others.chain([Value::from("x".repeat(TOO_LONG))]).collect();
    let mut all: Vec<String> = (0..body.len()).map(|end| body[..end].to_owned()).collect();
    all.push("[".repeat(TOO_LONG));
    for name in whole.as_object().unwrap().keys() {
        for other in &others {
            let mut spoilt = whole.clone();
            spoilt[name] = other.clone();
            all.push(spoilt.to_string());
        }
    }
    all
}

#[tokio::test]
async fn no_body_said_to_the_api_breaks_the_service() {
    let world = World::new().await;
    let app = world.open().await;
    let mut broken = Vec::new();
    for visitor in world.visitors.iter().filter(|visitor| ["own", "teacher", "station"].contains(&visitor.column)) {
        let mut client = client(&app, visitor, true);
        for (method, path, body) in SAID {
            for said in spoilt(body) {
                let request = Request::builder().method(method).uri(world.filled(path));
                let request = request.header(header::CONTENT_TYPE, "application/json");
                let status = client.send(request.body(Body::from(said.clone())).unwrap()).await.status.as_u16();
                if status >= 500 {
                    let start: String = said.chars().take(120).collect();
                    broken.push(format!("{} {path}: {start}: {status}", visitor.column));
                }
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[tokio::test]
async fn an_address_with_a_nul_in_it_is_refused() {
    let app = App::new().await;
    let school = app.school("North").await;
    app.member(school, Role::Administrator, "admin@example.org").await;
    let mut admin = app.signed_in("admin@example.org").await;
    for (address, status) in [("/people?q=a%00b", 400), ("/exercises/%00", 404), ("/cohorts/a%00b?x=%00", 404)] {
        assert_eq!(admin.get(address).await.status, status, "{address}");
    }
    assert_eq!(admin.get("/people?q=%2500").await.status, 200, "that is a percent sign and two digits");
}

/// Paths, queries and headers as the API describes them.
#[tokio::test]
async fn no_parameter_of_the_api_breaks_the_service() {
    let world = World::new().await;
    let app = world.open().await;
    let described = Client::new(app.router.clone()).get("/api/v1/openapi.json").await.json();
    let mut broken = Vec::new();
    let mut tried = 0;
    for visitor in world.visitors.iter().filter(|visitor| ["own", "teacher", "station"].contains(&visitor.column)) {
        let mut client = client(&app, visitor, true);
        for (path, methods) in described["paths"].as_object().unwrap() {
            for (method, operation) in methods.as_object().unwrap() {
                for parameter in operation["parameters"].as_array().into_iter().flatten() {
                    for nonsense in NONSENSE {
                        tried += 1;
                        let status =
                            client.send(with_parameter((&world, path, method), parameter, nonsense)).await.status;
                        if status.as_u16() >= 500 {
                            broken.push(format!("{method} {path}: {} = {nonsense:?}: {status}", parameter["name"]));
                        }
                    }
                }
            }
        }
    }
    assert!(tried > 500, "{tried} parameters were tried");
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// A request with nonsense in one parameter, and what exists in the others.
fn with_parameter((world, path, method): (&World, &str, &str), parameter: &Value, nonsense: &str) -> Request<Body> {
    let (name, place) = (parameter["name"].as_str().unwrap(), parameter["in"].as_str().unwrap());
    let value = encoded(&[("", nonsense)]).split_off(1);
    let path = match place {
        "path" => path.replace(&format!("{{{name}}}"), &value),
        _ => path.to_owned(),
    };
    let path = world.filled(&path.replace("{id}", "{session}"));
    let path = if place == "query" { format!("{path}?{name}={value}") } else { path };
    let request = Request::builder().method(method.to_uppercase().as_str()).uri(path).header("tus-resumable", "1.0.0");
    let request = match place {
        "header" if nonsense.is_ascii() && !nonsense.contains(char::is_control) => request.header(name, nonsense),
        _ => request,
    };
    request.body(Body::empty()).unwrap()
}

#[tokio::test]
async fn a_form_of_very_many_fields_is_refused_before_it_is_read() {
    let app = App::new().await;
    let mut stranger = app.stranger();
    let csrf = stranger.csrf().await;
    let body = format!("csrf={csrf}{}", "&email=a".repeat(150_000));
    // A sign-in has a token, a survey's form the secret in its address alone.
    for path in ["/login", "/survey/guessed"] {
        let request = Request::post(path).header(header::CONTENT_TYPE, "application/x-www-form-urlencoded");
        let answer = stranger.send(request.body(Body::from(body.clone())).unwrap()).await;
        assert_eq!(answer.status, 400, "{path}: {}", answer.text());
        assert!(answer.text().contains("5000 fields"), "{path}: {}", answer.text());
    }
}

/// Bytes of a text that no form takes: more than two megabytes.
const TOO_MUCH: usize = 2_100_000;

/// A form with a picture, whose fields beside it hold too much.
fn long_upload(path: &str, csrf: &str) -> Request<Body> {
    let text = "a".repeat(TOO_MUCH);
    let part =
        |name: &str, value: &str| format!("--x\r\nContent-Disposition: form-data; name=\"{name}\"\r\n\r\n{value}\r\n");
    let body = format!("{}{}--x--\r\n", part("csrf", csrf), part("document", &text));
    let request = Request::post(path).header(header::CONTENT_TYPE, "multipart/form-data; boundary=x");
    request.body(Body::from(body)).unwrap()
}

#[tokio::test]
async fn no_form_takes_more_than_two_megabytes_of_text() {
    let world = World::new().await;
    let app = world.open().await;
    let visitor = world.visitors.iter().find(|visitor| visitor.column == "admin").unwrap();
    let mut admin = client(&app, visitor, false);
    let csrf = csrf_in(&admin.get("/account").await.text());
    let text = "a".repeat(TOO_MUCH);
    for row in rows().into_iter().filter(|row| row.method == Method::POST && !row.path.starts_with("/api/")) {
        let path = world.filled(row.path);
        let plain = admin.form(&path, &[("csrf", &csrf), ("document", &text)]).await;
        let upload = admin.send(long_upload(&path, &csrf)).await;
        for answer in [plain.status.as_u16(), upload.status.as_u16()] {
            assert!((400..500).contains(&answer), "{path}: {answer}");
        }
    }
}
