//! The grades of a learning platform in the test process: access tokens, line items and scores, as LTI Assignment and Grade Services 2.0 says.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::body::Bytes;
use axum::extract::{Form, Query, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use platform::clock::Clock;
use serde_json::{Value, json};

use super::assertions::{Assertions, ExpectedAssertion};

const SCOPE: &str = "https://purl.imsglobal.org/spec/lti-ags/scope/";
const ITEM: &str = "application/vnd.ims.lis.v2.lineitem+json";

/// How the platform answers a score.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScoreAnswer {
    /// With a status; one of success takes the score, and 401 ends all tokens.
    Status(u16),
    /// Not at all.
    Stall,
    /// Takes the score, and does not answer.
    TakeAndStall,
}

/// A score that was taken.
#[derive(Clone, Debug, PartialEq)]
pub struct TakenScore {
    /// The query of the line item.
    pub query: String,
    pub message: Value,
}

#[derive(Default)]
struct Book {
    assertions: Assertions,
    client_keys: Value,
    /// Scopes by token.
    tokens: BTreeMap<String, String>,
    tokens_made: usize,
    answers: VecDeque<ScoreAnswer>,
    asked: usize,
    taken: Vec<TakenScore>,
    items: Vec<Value>,
}

/// The grades of a platform.
pub struct GradeBook {
    address: String,
    clock: Clock,
    book: Mutex<Book>,
}

impl GradeBook {
    pub fn new(address: &str, clock: &Clock) -> Self {
        Self { address: address.to_owned(), clock: clock.clone(), book: Mutex::default() }
    }

    fn lock(&self) -> MutexGuard<'_, Book> {
        self.book.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn set_client_keys(&self, keys: Value) {
        self.lock().client_keys = keys;
    }

    /// Answers the next scores so, one after another, and later ones with 200.
    pub fn answer_with(&self, answers: &[ScoreAnswer]) {
        self.lock().answers = answers.iter().copied().collect();
    }

    /// The scores that were taken, in order.
    pub fn taken(&self) -> Vec<TakenScore> {
        self.lock().taken.clone()
    }

    /// Number of requests with a score.
    pub fn asked(&self) -> usize {
        self.lock().asked
    }

    /// Number of access tokens.
    pub fn tokens_made(&self) -> usize {
        self.lock().tokens_made
    }

    pub fn items(&self) -> Vec<Value> {
        self.lock().items.clone()
    }

    /// The claim of a launch: a line item, or the line items of the course.
    pub fn claim(&self, line_item: Option<&str>) -> Value {
        let address = |path: &str| format!("http://{}/{path}", self.address);
        let mut claim = json!({ "scope": [format!("{SCOPE}score")], "lineitems": address("items?course=1") });
        if let Some(line_item) = line_item {
            claim["lineitem"] = json!(address(line_item));
        }
        claim
    }
}

/// The routes of the services.
pub fn routes(grades: &Arc<GradeBook>) -> Router {
    Router::new()
        .route("/token", post(token))
        .route("/items", get(find_items).post(add_item))
        .route("/items/{id}/scores", post(take_score))
        .with_state(Arc::clone(grades))
}

async fn token(State(grades): State<Arc<GradeBook>>, Form(form): Form<BTreeMap<String, String>>) -> Response {
    let (audience, now_s) = (format!("http://{}/token", grades.address), grades.clock.now().micros() / 1_000_000);
    let mut book = grades.lock();
    let keys = book.client_keys.clone();
    let expected = ExpectedAssertion { client_id: "client-1", keys: &keys, audience: &audience, now_s };
    if !book.assertions.take(&form, expected) || form["grant_type"] != "client_credentials" {
        return (StatusCode::UNAUTHORIZED, Json(json!({ "error": "invalid_client" }))).into_response();
    }
    book.tokens_made += 1;
    let token = format!("access-{}", book.tokens_made);
    book.tokens.insert(token.clone(), form["scope"].clone());
    Json(json!({ "access_token": token, "token_type": "Bearer", "expires_in": 3600 })).into_response()
}

fn may(book: &Book, headers: &HeaderMap, scope: &str) -> bool {
    let token = headers.get("authorization").and_then(|value| value.to_str().ok()?.strip_prefix("Bearer "));
    token.and_then(|token| book.tokens.get(token)).is_some_and(|scopes| *scopes == format!("{SCOPE}{scope}"))
}

async fn find_items(
    State(grades): State<Arc<GradeBook>>,
    headers: HeaderMap,
    Query(query): Query<BTreeMap<String, String>>,
) -> Response {
    let book = grades.lock();
    if !may(&book, &headers, "lineitem") || query.get("course").is_none_or(|course| course != "1") {
        return StatusCode::UNAUTHORIZED.into_response();
    }
    // It lists more than was asked for, as some do.
    Json(json!(book.items)).into_response()
}

async fn add_item(State(grades): State<Arc<GradeBook>>, headers: HeaderMap, body: Bytes) -> Response {
    let mut book = grades.lock();
    if !may(&book, &headers, "lineitem") || headers.get("content-type").is_none_or(|kind| kind != ITEM) {
        return StatusCode::UNAUTHORIZED.into_response();
    }
    let mut item: Value = serde_json::from_slice(&body).unwrap();
    item["id"] = json!(format!("http://{}/items/{}?type=lti", grades.address, book.items.len() + 1));
    book.items.push(item.clone());
    (StatusCode::CREATED, Json(item)).into_response()
}

async fn take_score(
    State(grades): State<Arc<GradeBook>>,
    headers: HeaderMap,
    axum::extract::RawQuery(query): axum::extract::RawQuery,
    body: Bytes,
) -> Response {
    let answer = {
        let mut book = grades.lock();
        book.asked += 1;
        let is_score = headers.get("content-type").is_some_and(|kind| kind == "application/vnd.ims.lis.v1.score+json");
        if !may(&book, &headers, "score") || !is_score {
            return StatusCode::UNAUTHORIZED.into_response();
        }
        let answer = book.answers.pop_front().unwrap_or(ScoreAnswer::Status(200));
        if matches!(answer, ScoreAnswer::Status(200..300) | ScoreAnswer::TakeAndStall) {
            let message = serde_json::from_slice(&body).unwrap();
            book.taken.push(TakenScore { query: query.unwrap_or_default(), message });
        }
        if answer == ScoreAnswer::Status(401) {
            book.tokens.clear();
        }
        answer
    };
    match answer {
        ScoreAnswer::Status(status) if status < 400 => StatusCode::from_u16(status).unwrap().into_response(),
        ScoreAnswer::Status(status) => (StatusCode::from_u16(status).unwrap(), "<p>Not\nthis one</p>").into_response(),
        ScoreAnswer::Stall | ScoreAnswer::TakeAndStall => {
            tokio::time::sleep(Duration::from_secs(60)).await;
            StatusCode::OK.into_response()
        }
    }
}
