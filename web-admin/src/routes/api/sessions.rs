//! Attempts and what was made of them.

use std::path::PathBuf;

use assessment::{Assessment, RubricRef};
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, Request, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use tower::ServiceExt;
use tower_http::services::ServeFile;
use utoipa::ToSchema;
use uuid::Uuid;

use super::Id;
use super::caller::Caller;
use crate::AppState;
use crate::domain::Moment;
use crate::error::{ApiError, Error, Problem};
use crate::recordings;
use crate::storage::grades;
use crate::storage::scores::{self, SessionKey};
use crate::storage::sessions::{self, Session, SessionState};

/// An attempt.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct SessionView {
    /// Id, made by the client.
    session_id: Uuid,
    /// Who tried.
    trainee_id: Uuid,
    exercise_id: String,
    exercise_sha256: String,
    /// The school never published the exercise that the recording carries.
    unknown_exercise: bool,
    #[schema(value_type = String, format = DateTime)]
    started_at: Moment,
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
            started_at: session.started_at,
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

/// The newest attempts, at most 100.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct SessionList {
    sessions: Vec<SessionView>,
}

/// The newest attempts that the caller may see, at most 100.
#[utoipa::path(get, path = "/sessions", responses((status = 200, body = SessionList), (status = 401, body = Problem)))]
pub(super) async fn list(State(state): State<AppState>, caller: Caller) -> Result<Json<SessionList>, ApiError> {
    let found = sessions::newest_visible(state.db.reader(), caller.person()?).await?;
    Ok(Json(SessionList { sessions: found.into_iter().map(SessionView::from).collect() }))
}

/// The attempt of an id, if there is one that the caller may see.
pub(super) async fn find(state: &AppState, caller: &Caller, id: Uuid) -> Result<Session, Error> {
    sessions::visible(state.db.reader(), caller.person()?, id).await?.ok_or(Error::NotFound)
}

/// An attempt.
#[utoipa::path(get, path = "/sessions/{id}", params(("id" = Uuid, Path)),
    responses((status = 200, body = SessionView), (status = 404, body = Problem)))]
pub(super) async fn show(
    State(state): State<AppState>,
    caller: Caller,
    Id(id): Id,
) -> Result<Json<SessionView>, ApiError> {
    Ok(Json(find(&state, &caller, id).await?.into()))
}

/// Where the score stands while there is none.
#[derive(Debug, Serialize, ToSchema)]
struct Waiting {
    state: SessionState,
}

/// A computed score, and what somebody has put in its place.
#[derive(Serialize)]
struct Graded {
    #[serde(flatten)]
    computed: Assessment,
    #[serde(rename = "override", skip_serializing_if = "Option::is_none")]
    overridden: Option<OverrideView>,
}

/// What counts in place of the computed score.
#[derive(Serialize)]
struct OverrideView {
    /// 0–100.
    score: f64,
    passed: bool,
    reason: String,
    made_at: Moment,
}

impl OverrideView {
    fn of(made: grades::Override) -> Option<Self> {
        let (score, passed) = made.score.zip(made.passed)?;
        Some(Self { score, passed, reason: made.reason, made_at: made.made_at })
    }
}

/// The newest computed score, in the form of `stylet score --json`; where somebody has put another in its place,
/// `override` holds it: `score`, `passed`, `reason` and `made_at`. 202 while the recording waits to be scored.
#[utoipa::path(get, path = "/sessions/{id}/score", params(("id" = Uuid, Path)),
    responses((status = 200, body = Object), (status = 202, body = Waiting), (status = 404, body = Problem)))]
pub(super) async fn score(State(state): State<AppState>, caller: Caller, Id(id): Id) -> Result<Response, ApiError> {
    let session = find(&state, &caller, id).await?;
    let key = SessionKey { school_id: session.school_id, id };
    let Some(score) = scores::newest(state.db.reader(), key).await? else {
        return match session.state {
            SessionState::Refused => Err(Error::Unscored(session.refusal.unwrap_or_default()).into()),
            waiting => Ok((StatusCode::ACCEPTED, Json(Waiting { state: waiting })).into_response()),
        };
    };
    let metrics = scores::metrics(state.db.reader(), key).await?;
    let computed = Assessment {
        score: score.score,
        passed: score.passed,
        metrics,
        deductions: score.deductions.0,
        hard_fails: score.hard_fails.0,
        rubric: RubricRef { id: score.rubric_id, sha256: score.rubric_sha256 },
        simulator_version: score.simulator_version,
    };
    let overridden = grades::overrides(state.db.reader(), key).await?.pop().and_then(OverrideView::of);
    Ok(Json(Graded { computed, overridden }).into_response())
}

fn recording_path(state: &AppState, session: &Session) -> PathBuf {
    state.config.recordings_dir.join(&session.recording_path)
}

/// What may be asked of a recording.
#[derive(Deserialize)]
pub(super) struct RecordingQuery {
    /// `comments`: a copy with what was said about the attempt.
    with: Option<String>,
}

/// The recording, whole or a range of its bytes. With `with=comments` a copy of it, in which each comment and answer is an
/// event of kind coaching at its moment; the stored bytes never change.
#[utoipa::path(get, path = "/sessions/{id}/recording",
    params(("id" = Uuid, Path), ("with" = Option<String>, Query, description = "comments")),
    responses((status = 200, content_type = "application/octet-stream"), (status = 206), (status = 416),
              (status = 404, body = Problem)))]
pub(super) async fn recording(
    State(state): State<AppState>,
    caller: Caller,
    Id(id): Id,
    query: Result<Query<RecordingQuery>, QueryRejection>,
    request: Request,
) -> Result<Response, ApiError> {
    let session = find(&state, &caller, id).await?;
    let Query(asked) = query.map_err(|refused| Error::BadRequest(refused.body_text()))?;
    let mut response = match asked.with.as_deref() {
        None => {
            let Ok(found) = ServeFile::new(recording_path(&state, &session)).oneshot(request).await;
            found.into_response()
        }
        Some("comments") => recordings::with_comments(&state, &session).await?.into_response(),
        Some(other) => {
            return Err(Error::BadRequest(format!("with: \"{other}\"; allowed is comments")).into());
        }
    };
    let name = HeaderValue::from_str(&format!("attachment; filename=\"{id}.mcap\"")).map_err(anyhow::Error::from)?;
    response.headers_mut().insert(header::CONTENT_DISPOSITION, name);
    response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static("application/octet-stream"));
    Ok(response)
}
