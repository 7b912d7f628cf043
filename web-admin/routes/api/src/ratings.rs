//! The replay of an attempt that somebody is asked to rate, by the id of the rating: without the attempt's own.

use acts::error::Error;
use acts::ratings::attempt;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, Request, State};
use axum::http::header::{
    ETAG, IF_MATCH, IF_MODIFIED_SINCE, IF_NONE_MATCH, IF_RANGE, IF_UNMODIFIED_SINCE, LAST_MODIFIED,
};
use axum::response::Response;
use model::ids::RatingId;
use model::replay::ReplayStage;
use routes_base::AppState;
use routes_base::error::{ApiError, ProblemDocument};
use store::sessions::Session;

use crate::caller::Caller;
use crate::replay::{Series, SeriesQuery};
use crate::{ApiId, replay};

async fn find_rated_attempt(state: &AppState, caller: &Caller, id: RatingId) -> Result<Session, Error> {
    attempt(state, caller.person()?, id).await
}

/// When a file was written is when the attempt was scored: neither is it told, nor can it be found out by asking on condition.
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

/// An attempt to be rated over time, as `/sessions/{id}/series`.
#[utoipa::path(get, path = "/ratings/{id}/series", tag = "ratings", operation_id = "show_rated_series",
    params(("id" = Uuid, Path, description = "a rating of the caller"), ("points" = Option<usize>, Query),
           ("from_s" = Option<f64>, Query), ("to_s" = Option<f64>, Query)),
    responses((status = 200, body = Series), (status = 400, body = ProblemDocument), (status = 404, body = ProblemDocument)))]
pub(super) async fn show_rated_series(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<RatingId>,
    query: Result<Query<SeriesQuery>, QueryRejection>,
) -> Result<Json<Series>, ApiError> {
    replay::series_of_spans(&state, &find_rated_attempt(&state, &caller, id).await?, query).await
}

/// What does not move in the replay of an attempt to be rated, as `/sessions/{id}/replay`.
#[utoipa::path(get, path = "/ratings/{id}/replay", tag = "ratings", operation_id = "show_rated_replay_stage",
    params(("id" = Uuid, Path, description = "a rating of the caller")),
    responses((status = 200, body = ReplayStage), (status = 404, body = ProblemDocument)))]
pub(super) async fn show_rated_stage(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<RatingId>,
    request: Request,
) -> Result<Response, ApiError> {
    show_blindly(&state, &find_rated_attempt(&state, &caller, id).await?, request, replay::STAGE).await
}

/// What moves in the replay of an attempt to be rated, as `/sessions/{id}/replay/frames`.
#[utoipa::path(get, path = "/ratings/{id}/replay/frames", tag = "ratings", operation_id = "download_rated_replay_frames",
    params(("id" = Uuid, Path, description = "a rating of the caller")),
    responses((status = 200, content_type = "application/octet-stream"),
              (status = 206, content_type = "application/octet-stream"), (status = 416),
              (status = 404, body = ProblemDocument)))]
pub(super) async fn show_rated_frames(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<RatingId>,
    request: Request,
) -> Result<Response, ApiError> {
    show_blindly(&state, &find_rated_attempt(&state, &caller, id).await?, request, replay::FRAMES).await
}
