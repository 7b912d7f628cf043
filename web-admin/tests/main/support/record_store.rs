//! A learning record store in the test process: it keeps statements by id, and answers as the test says.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::routing::post;
use axum::{Json, Router};
use serde_json::Value;
use tokio::net::TcpListener;
use tokio::task::JoinHandle;

/// `stylet:a secret`, in Base64.
const AUTHORIZATION: &str = "Basic c3R5bGV0OmEgc2VjcmV0";

#[derive(Default)]
struct Inner {
    statements: BTreeMap<String, Value>,
    /// Statuses of the next answers; then statements are taken.
    answers: VecDeque<u16>,
    /// Verbs that are refused.
    refused_verb: Option<String>,
    requests: usize,
}

/// A store; it ends when dropped.
pub struct TestRecordStore {
    /// Host and port.
    pub address: String,
    inner: Arc<Mutex<Inner>>,
    server: JoinHandle<()>,
}

impl TestRecordStore {
    pub async fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let inner = Arc::<Mutex<Inner>>::default();
        let router = Router::new().route("/xapi/statements", post(take)).with_state(Arc::clone(&inner));
        let server = tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
        Self { address, inner, server }
    }

    pub fn endpoint(&self) -> String {
        format!("http://{}/xapi", self.address)
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Answers the next requests by these statuses.
    pub fn answer(&self, statuses: &[u16]) {
        self.lock().answers.extend(statuses);
    }

    /// Refuses statements with a verb.
    pub fn refuse(&self, verb: Option<&str>) {
        self.lock().refused_verb = verb.map(str::to_owned);
    }

    /// Number of requests since the last call.
    pub fn count_requests(&self) -> usize {
        std::mem::take(&mut self.lock().requests)
    }

    /// The statements, by time.
    pub fn statements(&self) -> Vec<Value> {
        let mut all: Vec<Value> = self.lock().statements.values().cloned().collect();
        all.sort_by_key(|statement| (statement["timestamp"].to_string(), verb_of(statement)));
        all
    }

    /// The verbs of the statements, sorted.
    pub fn verbs(&self) -> Vec<String> {
        let mut verbs: Vec<String> = self.statements().iter().map(verb_of).collect();
        verbs.sort();
        verbs
    }
}

impl Drop for TestRecordStore {
    fn drop(&mut self) {
        self.server.abort();
    }
}

fn verb_of(statement: &Value) -> String {
    statement["verb"]["id"].as_str().unwrap().rsplit('/').next().unwrap().to_owned()
}

/// Takes all statements of a request or none (xAPI 1.0.3, part 3, 2.1.2).
async fn take(State(inner): State<Arc<Mutex<Inner>>>, headers: HeaderMap, Json(sent): Json<Vec<Value>>) -> StatusCode {
    let mut inner = inner.lock().unwrap_or_else(PoisonError::into_inner);
    inner.requests += 1;
    assert!(sent.len() <= 50, "{} statements in one request", sent.len());
    assert_eq!(headers.get("x-experience-api-version").unwrap(), "2.0.0");
    if let Some(status) = inner.answers.pop_front() {
        return StatusCode::from_u16(status).unwrap();
    }
    if headers.get("authorization").unwrap() != AUTHORIZATION {
        return StatusCode::UNAUTHORIZED;
    }
    if inner.refused_verb.as_ref().is_some_and(|verb| sent.iter().any(|one| verb_of(one) == *verb)) {
        return StatusCode::BAD_REQUEST;
    }
    for statement in sent {
        let id = statement["id"].as_str().unwrap().to_owned();
        match inner.statements.get(&id) {
            Some(known) if *known != statement => return StatusCode::CONFLICT,
            _ => inner.statements.insert(id, statement),
        };
    }
    StatusCode::OK
}
