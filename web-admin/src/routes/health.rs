//! For whoever keeps the service running: is it up, is it ready, how much is there to do.

use acts::error::Error;
use acts::inspection::InspectionState;
use acts::secret;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use store::service::{self, Totals};

use crate::AppState;
use crate::error::ApiError;
use crate::monitoring::write_metric_family;
use crate::routes::Routes;
use crate::routes::api::bearer_token;

/// A figure without labels.
fn write_gauge(name: &str, help: &str, value: f64) -> String {
    write_metric_family(name, "gauge", help, &[(String::new(), value)])
}

/// `/healthz`, `/readyz` and `/metrics`.
#[must_use]
pub fn health_routes() -> Routes {
    Routes::new()
        .route("/healthz", get(async || "ok\n"))
        .route("/readyz", get(answer_readiness))
        .route("/metrics", get(show_metrics))
}

/// Counts an answer by its status and its time.
pub async fn count_requests(State(state): State<AppState>, request: Request, next: Next) -> Response {
    let begun = state.clock.now();
    let response = next.run(request).await;
    let took = state.clock.now().duration_since(begun);
    state.counters.count(response.status(), took.as_micros() as u64);
    response
}

async fn answer_readiness(State(state): State<AppState>) -> Response {
    let unready = |why| (StatusCode::SERVICE_UNAVAILABLE, why).into_response();
    let inspection = state.inspection.state();
    if !inspection.findings.is_empty() {
        return unready("the database is damaged: the log and /admin/service say how\n");
    }
    match state.pulse.is_beating(&state).await {
        true if inspection.going => format!("ready; {}\n", say_progress(&inspection)).into_response(),
        true => "ready\n".into_response(),
        false => unready("the database does not answer, or takes nothing\n"),
    }
}

fn say_progress(inspection: &InspectionState) -> String {
    let InspectionState { tables, tables_read, audit_rows, audit_rows_read, .. } = inspection;
    format!(
        "the database is being checked: {tables_read} of {tables} tables, {audit_rows_read} of {audit_rows} rows of the audit log"
    )
}

/// Figures for whoever keeps the service running: by the token that was set for them; where none was, not to the world.
async fn show_metrics(State(state): State<AppState>, headers: HeaderMap) -> Result<Response, ApiError> {
    match &state.config.metrics_token {
        Some(token) if !bearer_token(&headers).is_some_and(|given| secret::same(given, token)) => {
            return Err(Error::Unauthorized.into());
        }
        None if state.config.behind_tls => return Err(Error::NotFound.into()),
        _ => {}
    }
    let reader = state.db.reader();
    let totals = service::count_totals(reader).await?;
    let waited_us = totals.due_at.map_or(0, |due| state.clock.now().micros().saturating_sub(due.micros()).max(0));
    let text = write_gauges(&totals, waited_us as f64 / 1e6)
        + &write_inspection(&state.inspection.state())
        + &state.counters.lines();
    Ok(([(header::CONTENT_TYPE, "text/plain; version=0.0.4")], text).into_response())
}

fn write_inspection(inspection: &InspectionState) -> String {
    let (done, findings) = (f64::from(u8::from(!inspection.going)), inspection.findings.len() as f64);
    write_gauge(
        "stylet_database_checked",
        "Whether the look through the database that began with the service is over.",
        done,
    ) + &write_gauge("stylet_database_findings", "Damaged places that it found.", findings)
}

fn write_gauges(totals: &Totals, waited_s: f64) -> String {
    let version = format!("{{version=\"{}\"}}", env!("CARGO_PKG_VERSION"));
    let roles =
        [("trainee", totals.trainees), ("instructor", totals.instructors), ("administrator", totals.administrators)];
    let people = roles.map(|(role, n)| (format!("{{role=\"{role}\"}}"), n as f64));
    let states = [("pending", totals.pending), ("scored", totals.scored), ("refused", totals.refused)];
    let sessions = states.map(|(state, n)| (format!("{{state=\"{state}\"}}"), n as f64));
    write_metric_family("stylet_build_info", "gauge", "The program that runs.", &[(version, 1.0)])
        + &write_metric_family("stylet_people", "gauge", "People who may sign in.", &people)
        + &write_gauge("stylet_stations", "Stations whose token is valid.", totals.stations as f64)
        + &write_gauge("stylet_uploads_unfinished", "Uploads in pieces that are not whole.", totals.uploads as f64)
        + &write_gauge("stylet_jobs_waiting", "Recordings that wait to be scored.", totals.waiting as f64)
        + &write_gauge("stylet_jobs_failing", "Of them, those that failed at least once.", totals.failing as f64)
        + &write_gauge(
            "stylet_set_aside",
            "Recordings and uploads that were fatal twice and are tried no more.",
            totals.set_aside as f64,
        )
        + &write_gauge("stylet_jobs_overdue_seconds", "How long the first of the queue is overdue, in s.", waited_s)
        + &write_gauge("stylet_audit_rows", "Rows of the audit log.", totals.audit_rows as f64)
        + &write_metric_family("stylet_sessions", "gauge", "Attempts by state.", &sessions)
        + &write_gauge("stylet_database_bytes", "Size of the database, in bytes.", totals.database_bytes as f64)
}
