//! The service of a learning platform that lists the members of a course, in the test process. It answers in pages, and does one thing wrong at
//! a time.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use axum::extract::{Query, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Form, Json, Router};
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio::task::JoinHandle;

/// Members on a page.
const PAGE: usize = 50;
const MEDIA_TYPE: &str = "application/vnd.ims.lti-nrps.v2.membershipcontainer+json";
const TOKEN: &str = "members-token";
const LEARNER: &str = "http://purl.imsglobal.org/vocab/lis/v2/membership#Learner";

/// One thing that the service does wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MembersFault {
    /// The last page leads to the first.
    Circle,
    /// A page has more than 1 MiB.
    TooLarge,
    /// The next page is on another host.
    AnotherHost,
    /// The service refuses.
    Forbidden,
    /// The page is not JSON.
    Html,
    /// A member has no id.
    Nobody,
}

#[derive(Default)]
struct Course {
    members: Vec<Value>,
    fault: Option<MembersFault>,
    requests: usize,
}

/// The service; it ends when dropped.
pub struct MemberService {
    /// Host and port.
    pub address: String,
    course: Arc<Mutex<Course>>,
    server: JoinHandle<()>,
}

impl MemberService {
    pub async fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let course = Arc::<Mutex<Course>>::default();
        let routes = Router::new().route("/token", post(issue_token)).route("/members", get(list_members));
        let router = routes.with_state(Arc::clone(&course));
        let server = tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
        Self { address, course, server }
    }

    pub fn token_url(&self) -> String {
        format!("http://{}/token", self.address)
    }

    pub fn members_url(&self) -> String {
        format!("http://{}/members?course=5", self.address)
    }

    /// Replaces the members.
    pub fn set_members(&self, members: Vec<Value>) {
        self.course.lock().unwrap_or_else(PoisonError::into_inner).members = members;
    }

    pub fn set_fault(&self, fault: Option<MembersFault>) {
        self.course.lock().unwrap_or_else(PoisonError::into_inner).fault = fault;
    }

    /// Number of pages that were asked for.
    pub fn requests(&self) -> usize {
        self.course.lock().unwrap_or_else(PoisonError::into_inner).requests
    }
}

impl Drop for MemberService {
    fn drop(&mut self) {
        self.server.abort();
    }
}

/// A member who learns, with changes to what is sent of them; null leaves a thing out.
pub fn learner(subject: &str, changes: Value) -> Value {
    let mut member =
        json!({ "user_id": subject, "name": format!("Name of {subject}"), "roles": [LEARNER], "status": "Active" });
    for (name, value) in changes.as_object().unwrap() {
        member[name] = value.clone();
    }
    member
}

async fn issue_token(Form(form): Form<BTreeMap<String, String>>) -> Response {
    let is = |name: &str, value: &str| form.get(name).is_some_and(|sent| sent == value);
    let scope = "https://purl.imsglobal.org/spec/lti-nrps/scope/contextmembership.readonly";
    match is("grant_type", "client_credentials") && is("scope", scope) && form.contains_key("client_assertion") {
        true => Json(json!({ "access_token": TOKEN, "token_type": "Bearer", "expires_in": 3600 })).into_response(),
        false => (StatusCode::BAD_REQUEST, Json(json!({ "error": "invalid_scope" }))).into_response(),
    }
}

async fn list_members(
    State(course): State<Arc<Mutex<Course>>>,
    headers: HeaderMap,
    Query(query): Query<BTreeMap<String, String>>,
) -> Response {
    let mut course = course.lock().unwrap_or_else(PoisonError::into_inner);
    course.requests += 1;
    let sent = |name| headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default();
    assert_eq!((sent(header::AUTHORIZATION), sent(header::ACCEPT)), (format!("Bearer {TOKEN}").as_str(), MEDIA_TYPE));
    assert_eq!(query.get("course").map(String::as_str), Some("5"), "the address of the launch");
    let from: usize = query.get("from").map_or(0, |from| from.parse().unwrap());
    let mut members: Vec<Value> = course.members.iter().skip(from).take(PAGE).cloned().collect();
    let is_last = from + PAGE >= course.members.len();
    let host = sent(header::HOST);
    let page =
        |host: &str, from: usize| format!("<http://{host}/members?course=5&limit=200&from={from}>; rel=\"next\"");
    let next = match course.fault {
        Some(MembersFault::Circle) => Some(page(host, if is_last { 0 } else { from + PAGE })),
        Some(MembersFault::AnotherHost) => Some(page("127.0.0.1:9", 0)),
        _ => (!is_last).then(|| page(host, from + PAGE)),
    };
    match course.fault {
        Some(MembersFault::Forbidden) => return StatusCode::FORBIDDEN.into_response(),
        Some(MembersFault::Html) => return "<p>Sign in".into_response(),
        Some(MembersFault::TooLarge) => members.push(json!({ "user_id": "x".repeat(1024 * 1024) })),
        Some(MembersFault::Nobody) => members.push(json!({ "name": "Nobody" })),
        _ => {}
    }
    let body = json!({ "id": "https://lms", "context": { "id": "course-1" }, "members": members }).to_string();
    let mut answer = ([(header::CONTENT_TYPE, MEDIA_TYPE)], body).into_response();
    if let Some(next) = next {
        answer.headers_mut().insert(header::LINK, next.parse().unwrap());
    }
    answer
}
