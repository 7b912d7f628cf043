//! Attempts and what was made of them.

use acts::error::Error;
use acts::recordings;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, Request, State};
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use model::ids::{PersonId, SessionId};
use model::{AttemptPlace, Moment, Uncounted};
use routes_base::AppState;
use routes_base::error::{ApiError, ProblemDocument};
use routes_base::stored_files::{serve_file, serve_stored};
use serde::{Deserialize, Serialize};
use store::sessions::{self, Session, SessionState};
use utoipa::ToSchema;

use crate::ApiId;
use crate::caller::Caller;

/// An attempt.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct SessionView {
    /// Id, made by the client.
    #[schema(value_type = Uuid)]
    session_id: SessionId,
    /// Who tried.
    #[schema(value_type = Uuid)]
    trainee_id: PersonId,
    exercise_id: String,
    exercise_sha256: String,
    /// The school never published the exercise that the recording carries.
    unknown_exercise: bool,
    /// Why it counts nowhere: its exercise is `unpublished`, or it is a `duplicate`, the same motion as an attempt of before.
    /// Absent where it counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    uncounted: Option<Uncounted>,
    /// A paired station has signed what the hand did, and the signature is right.
    signed_by_station: bool,
    /// When it began, as far as the recording is believed.
    #[schema(value_type = String, format = DateTime)]
    started_at: Moment,
    /// When it began by what the recording says, where that is not believed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime, nullable = false)]
    claimed_started_at: Option<Moment>,
    #[schema(value_type = String, format = DateTime)]
    received_at: Moment,
    /// In s.
    duration_s: f64,
    /// False for a recording that was cut.
    complete: bool,
    device: String,
    simulator_version: String,
    /// Unsigned 64-bit, in decimal.
    seed: String,
    state: SessionState,
    /// Why it was refused.
    refusal: Option<String>,
    recording_sha256: String,
    recording_size_bytes: i64,
    /// The server's own re-simulation; absent until it is made.
    verification: Option<VerificationView>,
}

/// What the server's re-simulation found.
#[derive(Debug, Serialize, ToSchema)]
struct VerificationView {
    /// Largest deviation of any force, in N; absent where it is no number.
    largest_deviation_n: Option<f64>,
    event_differences: i64,
    /// It is not the same to the bit.
    flagged: bool,
}

impl From<Session> for SessionView {
    fn from(session: Session) -> Self {
        let verification = session.verify_flagged.map(|flagged| VerificationView {
            largest_deviation_n: session.verify_deviation_n,
            event_differences: session.verify_event_differences.unwrap_or_default(),
            flagged,
        });
        Self {
            session_id: session.id,
            trainee_id: session.trainee_id,
            exercise_id: session.exercise_id,
            exercise_sha256: session.exercise_sha256,
            unknown_exercise: session.revision_id.is_none(),
            uncounted: session.uncounted,
            signed_by_station: session.signed_by.is_some(),
            started_at: session.started_at,
            claimed_started_at: session.claimed_started_at,
            received_at: session.received_at,
            duration_s: session.duration_s,
            complete: session.complete,
            device: session.device,
            simulator_version: session.simulator_version,
            seed: session.seed,
            state: session.state,
            refusal: session.refusal,
            recording_sha256: session.recording_sha256,
            recording_size_bytes: session.recording_size,
            verification,
        }
    }
}

/// Attempts, newest first.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct SessionList {
    sessions: Vec<SessionView>,
    /// Where the list goes on: to be given as `after`. Absent at its end.
    next: Option<String>,
}

/// Most attempts in one answer, and as many as there are where nobody says how many.
const LONGEST_PAGE: u32 = 100;

/// Which stretch of a list is asked for, as it was typed: each refusal names its field.
#[derive(Debug, Deserialize)]
pub(super) struct SessionListQuery {
    after: Option<String>,
    limit: Option<String>,
}

impl SessionListQuery {
    fn after(&self) -> Result<AttemptPlace, Error> {
        let Some(after) = &self.after else { return Ok(AttemptPlace::START) };
        after.parse().map_err(|refused| Error::BadRequest(format!("after: \"{after}\"; {refused}")))
    }

    fn limit(&self) -> Result<u32, Error> {
        let Some(limit) = &self.limit else { return Ok(LONGEST_PAGE) };
        let parsed = limit.parse().ok().filter(|limit| (1..=LONGEST_PAGE).contains(limit));
        parsed.ok_or_else(|| {
            Error::BadRequest(format!("limit: \"{limit}\"; allowed is a whole number from 1 to {LONGEST_PAGE}"))
        })
    }
}

/// The attempts that the caller may see, newest first, as many as `limit` says. Where there are more, `next` says where the list goes
/// on, and so does a `Link` header.
#[utoipa::path(get, path = "/sessions", tag = "sessions", operation_id = "list_sessions",
    params(("after" = Option<String>, Query, description = "what `next` of the list before said; the newest by default"),
           ("limit" = Option<u32>, Query, minimum = 1, maximum = 100, description = "1 to 100; 100 by default")),
    responses((status = 200, body = SessionList,
               headers(("Link" = String, description = "the address of what comes next, rel=\"next\" (RFC 8288)"))),
              (status = 400, body = ProblemDocument)))]
pub(super) async fn list_sessions(
    State(state): State<AppState>,
    caller: Caller,
    query: Result<Query<SessionListQuery>, QueryRejection>,
) -> Result<Response, ApiError> {
    let person = caller.person()?;
    let Query(asked) = query.map_err(|refused| Error::BadRequest(refused.body_text()))?;
    let (after, limit) = (asked.after()?, asked.limit()?);
    // One more tells whether there are more.
    let mut found = sessions::visible_after(state.db.reader(), person, after, limit + 1).await?;
    let more = found.len() > limit as usize;
    found.truncate(limit as usize);
    let last = found.last().filter(|_| more).map(|last| AttemptPlace { started_at: last.started_at, id: last.id });
    let next = last.map(|last| last.to_string());
    let link = next.as_ref().map(|next| format!("</api/v1/sessions?after={next}&limit={limit}>; rel=\"next\""));
    let sessions = found.into_iter().map(SessionView::from).collect();
    let mut response = Json(SessionList { sessions, next }).into_response();
    if let Some(link) = link {
        response.headers_mut().insert(header::LINK, HeaderValue::from_str(&link).map_err(anyhow::Error::from)?);
    }
    Ok(response)
}

/// The attempt of an id, if there is one that the caller may see.
pub(super) async fn find_session(state: &AppState, caller: &Caller, id: SessionId) -> Result<Session, Error> {
    sessions::find_visible_session(state.db.reader(), caller.person()?, id).await?.ok_or(Error::NotFound)
}

/// An attempt.
#[utoipa::path(get, path = "/sessions/{id}", tag = "sessions", operation_id = "show_session", params(("id" = Uuid, Path)),
    responses((status = 200, body = SessionView), (status = 404, body = ProblemDocument)))]
pub(super) async fn show_session(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<SessionId>,
) -> Result<Json<SessionView>, ApiError> {
    Ok(Json(find_session(&state, &caller, id).await?.into()))
}

/// What may be asked of a recording.
#[derive(Deserialize)]
pub(super) struct RecordingQuery {
    /// `comments`: a copy with what was said about the attempt.
    with: Option<String>,
}

/// The recording, whole or a range of its bytes. With `with=comments` a copy of it, in which each comment and answer is an
/// event of kind coaching at its moment; the stored bytes never change.
#[utoipa::path(get, path = "/sessions/{id}/recording", tag = "sessions", operation_id = "download_recording",
    params(("id" = Uuid, Path), ("with" = Option<String>, Query, description = "comments")),
    responses((status = 200, content_type = "application/octet-stream"),
              (status = 206, content_type = "application/octet-stream"), (status = 400, body = ProblemDocument), (status = 416),
              (status = 404, body = ProblemDocument), (status = 410, body = ProblemDocument),
              (status = 503, body = ProblemDocument, description = "The store of the recordings does not answer")))]
pub(super) async fn serve_recording(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<SessionId>,
    query: Result<Query<RecordingQuery>, QueryRejection>,
    request: Request,
) -> Result<Response, ApiError> {
    let session = find_session(&state, &caller, id).await?;
    let Query(asked) = query.map_err(|refused| Error::BadRequest(refused.body_text()))?;
    let mut response = match asked.with.as_deref() {
        None => serve_stored(recordings::find(&state, &session).await?, request).await?,
        Some("comments") => serve_file(recordings::with_comments(&state, &session).await?.path(), request).await,
        Some(other) => {
            return Err(Error::BadRequest(format!("with: \"{other}\"; allowed is comments")).into());
        }
    };
    let name = HeaderValue::from_str(&format!("attachment; filename=\"{id}.mcap\"")).map_err(anyhow::Error::from)?;
    response.headers_mut().insert(header::CONTENT_DISPOSITION, name);
    response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static("application/octet-stream"));
    Ok(response)
}
