//! For whoever keeps the service running: is it up, is it ready, how much is there to do.

use std::sync::atomic::{AtomicU64, Ordering};

use axum::extract::{Request, State};
use axum::http::{StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use axum::routing::get;

use crate::AppState;
use crate::error::ApiError;
use crate::routes::Routes;
use crate::storage::sessions::SessionState;
use crate::storage::{jobs, sessions};

/// Requests answered since the start, by the first digit of their status.
#[derive(Debug, Default)]
pub struct Counters {
    by_class: [AtomicU64; 5],
}

impl Counters {
    fn count(&self, status: StatusCode) {
        let class = usize::from(status.as_u16() / 100).saturating_sub(1);
        if let Some(counter) = self.by_class.get(class) {
            counter.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn lines(&self) -> String {
        let line = |(class, n): (usize, &AtomicU64)| {
            format!("stylet_http_requests_total{{status=\"{}xx\"}} {}\n", class + 1, n.load(Ordering::Relaxed))
        };
        self.by_class.iter().enumerate().map(line).collect()
    }
}

/// `/healthz`, `/readyz` and `/metrics`.
#[must_use]
pub fn router() -> Routes {
    Routes::new().route("/healthz", get(async || "ok\n")).route("/readyz", get(ready)).route("/metrics", get(metrics))
}

/// Counts an answer by its status.
pub async fn count_requests(State(state): State<AppState>, request: Request, next: Next) -> Response {
    let response = next.run(request).await;
    state.counters.count(response.status());
    response
}

async fn ready(State(state): State<AppState>) -> Response {
    match state.db.ping().await {
        Ok(()) => "ready\n".into_response(),
        Err(_) => (StatusCode::SERVICE_UNAVAILABLE, "the database does not answer\n").into_response(),
    }
}

async fn metrics(State(state): State<AppState>) -> Result<Response, ApiError> {
    let reader = state.db.reader();
    let mut text = String::from("# HELP stylet_jobs_waiting Recordings that wait to be scored.\n");
    text += &format!("# TYPE stylet_jobs_waiting gauge\nstylet_jobs_waiting {}\n", jobs::count(reader).await?);
    text += "# HELP stylet_sessions Attempts by state.\n# TYPE stylet_sessions gauge\n";
    for (word, kind) in
        [("pending", SessionState::Pending), ("scored", SessionState::Scored), ("refused", SessionState::Refused)]
    {
        text += &format!("stylet_sessions{{state=\"{word}\"}} {}\n", sessions::count(reader, kind).await?);
    }
    text += "# HELP stylet_http_requests_total Requests answered.\n# TYPE stylet_http_requests_total counter\n";
    text += &state.counters.lines();
    Ok(([(header::CONTENT_TYPE, "text/plain; version=0.0.4")], text).into_response())
}
