//! Endpoints for operators: liveness, readiness and metrics.

use std::sync::atomic::Ordering;

use acts::SPANS;
use acts::error::Error;
use acts::operations::inspection::InspectionState;
use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use platform::secret;
use routes_api::bearer_token;
use routes_base::error::ApiError;
use routes_base::operations::monitoring::{MetricFamily, MetricFigure};
use routes_base::{AppState, Routes};
use store::operations::service;
use store::operations::service::Totals;
use tracing::field::Empty;
use tracing::{Instrument, Span};

/// Returns the routes `/healthz`, `/readyz` and `/metrics`.
#[must_use]
pub fn health_routes() -> Routes {
    Routes::new()
        .route("/healthz", get(async || "ok\n"))
        .route("/readyz", get(answer_readiness))
        .route("/metrics", get(show_metrics))
}

/// Counts a response by its status and duration, within a span of its own.
pub async fn count_requests(State(state): State<AppState>, request: Request, next: Next) -> Response {
    let begun = state.clock.now();
    let span = begin_span(&request);
    let response = next.run(request).instrument(span.clone()).await;
    span.record("http.response.status_code", response.status().as_u16());
    if response.status().is_server_error() {
        span.record("otel.status_code", "ERROR");
    }
    let took = state.clock.now().duration_since(begun);
    state.counters.count(response.status(), took.as_micros() as u64);
    response
}

/// Starts a span named after the route's pattern, so that it contains no identifiers.
fn begin_span(request: &Request) -> Span {
    let route = request.extensions().get::<MatchedPath>().map_or("", MatchedPath::as_str);
    let method = request.method().as_str();
    tracing::info_span!(
        target: SPANS,
        "request",
        otel.name = format!("{method} {route}"),
        otel.kind = "server",
        otel.status_code = Empty,
        http.request.method = method,
        http.route = route,
        http.response.status_code = Empty,
    )
}

async fn answer_readiness(State(state): State<AppState>) -> Response {
    let unready = |why| (StatusCode::SERVICE_UNAVAILABLE, why).into_response();
    if state.leaving.load(Ordering::Relaxed) {
        return unready("this service is shutting down\n");
    }
    let inspection = state.inspection.state();
    if !inspection.findings.is_empty() {
        return unready("the database is damaged: see the log and /admin/service\n");
    }
    match state.pulse.is_beating(&state).await {
        true if inspection.going => format!("ready; {}\n", say_progress(&inspection)).into_response(),
        true => "ready\n".into_response(),
        false => unready("the database does not respond, or is not writable\n"),
    }
}

fn say_progress(inspection: &InspectionState) -> String {
    let InspectionState { tables, tables_read, audit_rows, audit_rows_read, .. } = inspection;
    format!(
        "the database is being checked: {tables_read} of {tables} tables, {audit_rows_read} of {audit_rows} rows of the audit log"
    )
}

/// Returns the metrics for operators, if the configured token matches. Without a configured token,
/// they are public unless the service runs behind TLS.
async fn show_metrics(State(state): State<AppState>, headers: HeaderMap) -> Result<Response, ApiError> {
    match &state.config.metrics_token {
        Some(token) if !bearer_token(&headers).is_some_and(|given| secret::same(given, token)) => {
            return Err(Error::Unauthorized.into());
        }
        None if state.config.behind_tls => return Err(Error::NotFound.into()),
        _ => {}
    }
    let text: String = list_families(&state).await?.iter().map(MetricFamily::write).collect();
    Ok(([(header::CONTENT_TYPE, "text/plain; version=0.0.4")], text).into_response())
}

/// Returns every metric of the service.
pub(crate) async fn list_families(state: &AppState) -> Result<Vec<MetricFamily>, Error> {
    let totals = service::count_totals(state.db.reader()).await?;
    let waited_us = totals.due_at.map_or(0, |due| state.clock.now().micros().saturating_sub(due.micros()).max(0));
    let mut families = list_gauges(&totals, waited_us as f64 / 1e6);
    families.extend(list_inspection(&state.inspection.state()));
    families.extend(state.counters.list_families());
    Ok(families)
}

fn list_inspection(inspection: &InspectionState) -> [MetricFamily; 2] {
    let (done, findings) = (f64::from(u8::from(!inspection.going)), inspection.findings.len() as f64);
    [
        MetricFamily::gauge("stylet_database_checked", "Whether the database check at startup has finished.", done),
        MetricFamily::gauge("stylet_database_findings", "Errors found by the database check.", findings),
    ]
}

fn list_gauges(totals: &Totals, waited_s: f64) -> Vec<MetricFamily> {
    let version = MetricFigure::labelled("version", env!("CARGO_PKG_VERSION").to_owned(), 1.0);
    let labelled = |label, (named, n): (&str, i64)| MetricFigure::labelled(label, named.to_owned(), n as f64);
    let roles =
        [("trainee", totals.trainees), ("instructor", totals.instructors), ("administrator", totals.administrators)];
    let states = [("pending", totals.pending), ("scored", totals.scored), ("refused", totals.refused)];
    let people = roles.map(|role| labelled("role", role)).to_vec();
    let sessions = states.map(|state| labelled("state", state)).to_vec();
    vec![
        MetricFamily::gauges("stylet_build_info", "Version of the running program.", vec![version]),
        MetricFamily::gauges("stylet_people", "People who may sign in.", people),
        MetricFamily::gauge("stylet_stations", "Stations whose token is valid.", totals.stations as f64),
        MetricFamily::gauge("stylet_uploads_unfinished", "Unfinished resumable uploads.", totals.uploads as f64),
        MetricFamily::gauge("stylet_jobs_waiting", "Recordings waiting to be scored.", totals.waiting as f64),
        MetricFamily::gauge(
            "stylet_jobs_failing",
            "Recordings waiting to be scored that failed at least once.",
            totals.failing as f64,
        ),
        MetricFamily::gauge(
            "stylet_set_aside",
            "Recordings and uploads quarantined after two crashes.",
            totals.set_aside as f64,
        ),
        MetricFamily::gauge(
            "stylet_jobs_overdue_seconds",
            "How long the first job of the queue is overdue, in s.",
            waited_s,
        ),
        MetricFamily::gauge("stylet_audit_rows", "Rows of the audit log.", totals.audit_rows as f64),
        MetricFamily::gauges("stylet_sessions", "Attempts by state.", sessions),
        MetricFamily::gauge("stylet_database_bytes", "Size of the database, in bytes.", totals.database_bytes as f64),
    ]
}
