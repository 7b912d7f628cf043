//! The data of a replay: the stage, the frames, and the series plotted over time.

use acts::error::Error;
use acts::recordings::replays;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, Request, State};
use axum::http::{HeaderValue, header};
use axum::response::Response;
use model::ids::SessionId;
use model::recordings::replay::ReplayStage;
use model::recordings::series;
use model::recordings::series::{AttemptStretch, TimeSpan};
use platform::replay_files;
use routes_base::AppState;
use routes_base::error::{ApiError, ProblemDocument};
use routes_base::recordings::stored_files::serve_stored;
use serde::{Deserialize, Serialize};
use store::recordings::sessions::Session;
use utoipa::ToSchema;

use crate::ApiId;
use crate::caller::Caller;
use crate::recordings::sessions::find_session;

/// Raw query parameters, so that each refusal names its field.
#[derive(Deserialize)]
pub(crate) struct SeriesQuery {
    points: Option<String>,
    from_s: Option<String>,
    to_s: Option<String>,
}

/// An attempt over time.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Series {
    /// Spans of time in order.
    spans: Vec<TimeSpan>,
}

/// Returns the minima and maxima over `points` spans of time, of the whole attempt or of a part of
/// it.
#[utoipa::path(get, path = "/sessions/{id}/series", tag = "replay", operation_id = "show_series",
    params(("id" = Uuid, Path), ("points" = Option<usize>, Query, description = "1 to 10000; 1000 by default"),
           ("from_s" = Option<f64>, Query, description = "start of the interval, in s; the start of the attempt by default"),
           ("to_s" = Option<f64>, Query, description = "end of the interval, in s; the end of the attempt by default")),
    responses((status = 200, body = Series), (status = 400, body = ProblemDocument), (status = 404, body = ProblemDocument),
              (status = 410, body = ProblemDocument), (status = 503, body = ProblemDocument)))]
pub(crate) async fn show_series(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<SessionId>,
    query: Result<Query<SeriesQuery>, QueryRejection>,
) -> Result<Json<Series>, ApiError> {
    let session = find_session(&state, &caller, id).await?;
    series_of_spans(&state, &session, query).await
}

/// Returns the spans of a session that the caller may see.
pub(crate) async fn series_of_spans(
    state: &AppState,
    session: &Session,
    query: Result<Query<SeriesQuery>, QueryRejection>,
) -> Result<Json<Series>, ApiError> {
    let Query(asked) = query.map_err(|refused| Error::BadRequest(refused.body_text()))?;
    let points = series_of_points(asked.points.as_deref())?;
    let (from_s, to_s) =
        (round_seconds("from_s", asked.from_s.as_deref())?, round_seconds("to_s", asked.to_s.as_deref())?);
    if from_s.zip(to_s).is_some_and(|(from_s, to_s)| from_s > to_s) {
        return Err(Error::BadRequest("to_s: before from_s; allowed: a later moment".to_owned()).into());
    }
    let pyramid = replays::pyramid(state, session).await?;
    Ok(Json(Series { spans: pyramid.spans(points, AttemptStretch { from_s, to_s }) }))
}

fn series_of_points(asked: Option<&str>) -> Result<usize, Error> {
    let Some(asked) = asked else { return Ok(1000) };
    let points = asked.parse().ok().filter(|points| (1..=series::MAX_POINTS).contains(points));
    points.ok_or_else(|| {
        let most = series::MAX_POINTS;
        Error::BadRequest(format!("points: \"{asked}\"; allowed: a whole number from 1 to {most}"))
    })
}

fn round_seconds(field: &str, asked: Option<&str>) -> Result<Option<f64>, Error> {
    let Some(asked) = asked else { return Ok(None) };
    match asked.parse::<f64>() {
        Ok(seconds) if seconds.is_finite() => Ok(Some(seconds)),
        _ => Err(Error::BadRequest(format!("{field}: \"{asked}\"; allowed: a number of seconds"))),
    }
}

/// Returns the static part of a replay: layers, needle, structures, events.
#[utoipa::path(get, path = "/sessions/{id}/replay", tag = "replay", operation_id = "show_replay_stage", params(("id" = Uuid, Path)),
    responses((status = 200, body = ReplayStage), (status = 404, body = ProblemDocument),
              (status = 410, body = ProblemDocument), (status = 503, body = ProblemDocument)))]
pub(crate) async fn show_stage(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<SessionId>,
    request: Request,
) -> Result<Response, ApiError> {
    serve_part(&state, &find_session(&state, &caller, id).await?, request, STAGE).await
}

/// Returns the moving part of a replay: rows of little-endian 32-bit floats, whole or as a byte
/// range. The stage names the columns.
#[utoipa::path(get, path = "/sessions/{id}/replay/frames", tag = "replay", operation_id = "download_replay_frames", params(("id" = Uuid, Path)),
    responses((status = 200, content_type = "application/octet-stream"),
              (status = 206, content_type = "application/octet-stream"), (status = 416),
              (status = 404, body = ProblemDocument),
              (status = 410, body = ProblemDocument), (status = 503, body = ProblemDocument)))]
pub(crate) async fn show_frames(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<SessionId>,
    request: Request,
) -> Result<Response, ApiError> {
    serve_part(&state, &find_session(&state, &caller, id).await?, request, FRAMES).await
}

/// File name and media type of a part of a replay.
pub(crate) type SeriesPart = (&'static str, &'static str);
/// The static part.
pub(crate) const STAGE: SeriesPart = (replay_files::STAGE, "application/json");
/// The moving part.
pub(crate) const FRAMES: SeriesPart = (replay_files::FRAMES, "application/octet-stream");

/// Serves a part of the replay of a session that the caller may see.
pub(crate) async fn serve_part(
    state: &AppState,
    session: &Session,
    request: Request,
    (name, media_type): SeriesPart,
) -> Result<Response, ApiError> {
    let mut response = serve_stored(replays::file(state, session, name).await?, request).await?;
    response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static(media_type));
    Ok(response)
}
