//! The replay of an attempt for its raters, addressed by the rating's id so that the attempt's id
//! is not disclosed.

use acts::error::Error;
use acts::scoring::ratings::attempt;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, Request, State};
use axum::http::header::{
    ETAG, IF_MATCH, IF_MODIFIED_SINCE, IF_NONE_MATCH, IF_RANGE, IF_UNMODIFIED_SINCE, LAST_MODIFIED,
};
use axum::response::Response;
use model::ids::RatingId;
use model::recordings::replay::ReplayStage;
use routes_base::AppState;
use routes_base::error::{ApiError, ProblemDocument};
use store::recordings::sessions::Session;

use crate::ApiId;
use crate::caller::Caller;
use crate::recordings::replay;
use crate::recordings::replay::{Series, SeriesQuery};

async fn find_rated_attempt(state: &AppState, caller: &Caller, id: RatingId) -> Result<Session, Error> {
    attempt(state, caller.person()?, id).await
}

/// Serves a part of the replay without its modification time, which is the time of scoring: neither
/// a header nor a conditional request may disclose it.
async fn show_blindly(
    state: &AppState,
    session: &Session,
    mut request: Request,
    part: replay::SeriesPart,
) -> Result<Response, ApiError> {
    for conditional in [IF_MODIFIED_SINCE, IF_UNMODIFIED_SINCE, IF_MATCH, IF_NONE_MATCH, IF_RANGE] {
        request.headers_mut().remove(conditional);
    }
    let mut response = replay::serve_part(state, session, request, part).await?;
    for telling in [LAST_MODIFIED, ETAG] {
        response.headers_mut().remove(telling);
    }
    Ok(response)
}

/// Returns an attempt to be rated over time, as `/sessions/{id}/series` does.
#[utoipa::path(get, path = "/ratings/{id}/series", tag = "ratings", operation_id = "show_rated_series",
    params(("id" = Uuid, Path, description = "a rating of the caller"), ("points" = Option<usize>, Query),
           ("from_s" = Option<f64>, Query), ("to_s" = Option<f64>, Query)),
    responses((status = 200, body = Series), (status = 400, body = ProblemDocument), (status = 404, body = ProblemDocument)))]
pub(crate) async fn show_rated_series(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<RatingId>,
    query: Result<Query<SeriesQuery>, QueryRejection>,
) -> Result<Json<Series>, ApiError> {
    replay::series_of_spans(&state, &find_rated_attempt(&state, &caller, id).await?, query).await
}

/// Returns the static part of the replay of an attempt to be rated, as `/sessions/{id}/replay`
/// does.
#[utoipa::path(get, path = "/ratings/{id}/replay", tag = "ratings", operation_id = "show_rated_replay_stage",
    params(("id" = Uuid, Path, description = "a rating of the caller")),
    responses((status = 200, body = ReplayStage), (status = 404, body = ProblemDocument)))]
pub(crate) async fn show_rated_stage(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<RatingId>,
    request: Request,
) -> Result<Response, ApiError> {
    show_blindly(&state, &find_rated_attempt(&state, &caller, id).await?, request, replay::STAGE).await
}

/// Returns the moving part of the replay of an attempt to be rated, as
/// `/sessions/{id}/replay/frames` does.
#[utoipa::path(get, path = "/ratings/{id}/replay/frames", tag = "ratings", operation_id = "download_rated_replay_frames",
    params(("id" = Uuid, Path, description = "a rating of the caller")),
    responses((status = 200, content_type = "application/octet-stream"),
              (status = 206, content_type = "application/octet-stream"), (status = 416),
              (status = 404, body = ProblemDocument)))]
pub(crate) async fn show_rated_frames(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<RatingId>,
    request: Request,
) -> Result<Response, ApiError> {
    show_blindly(&state, &find_rated_attempt(&state, &caller, id).await?, request, replay::FRAMES).await
}
