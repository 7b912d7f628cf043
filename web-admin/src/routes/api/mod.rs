//! `/api/v1`: JSON for programs, by bearer token.

use axum::Json;
use axum::extract::{FromRequest, FromRequestParts, Path, Request};
use axum::http::request::Parts;
use axum::middleware::from_fn_with_state;
use axum::routing::{get, post, put};
pub(crate) use caller::bearer_token;
use serde::de::DeserializeOwned;
use utoipa::OpenApi;
use utoipa::openapi::OpenApi as Description;

use crate::AppState;
use crate::error::ApiError;
use crate::routes::Routes;
use acts::error::Error;

mod caller;
mod comments;
mod cors;
mod description;
mod documents;
mod ratings;
mod replay;
mod score;
mod sessions;
mod stations;
mod surveys;
mod tus;
mod upload;

/// The API. Who is calling is settled by a layer that also covers addresses that do not exist.
#[must_use]
pub fn api_routes(state: &AppState) -> Routes {
    Routes::new()
        .route("/sessions", post(upload::upload_recording).get(sessions::list_sessions))
        .route("/sessions/{id}", get(sessions::show_session))
        .route("/sessions/{id}/score", get(score::show_score))
        .route("/sessions/{id}/recording", get(sessions::serve_recording))
        .route("/sessions/{id}/series", get(replay::show_series))
        .route("/sessions/{id}/comments", get(comments::list_comments).post(comments::add_comment))
        .route("/sessions/{id}/replay", get(replay::show_stage))
        .route("/sessions/{id}/replay/frames", get(replay::show_frames))
        .route("/sessions/{id}/survey", get(surveys::list_surveys_after))
        .route("/sessions/{id}/survey/{survey}", put(surveys::take_answers))
        .route("/ratings/{id}/series", get(ratings::show_rated_series))
        .route("/ratings/{id}/replay", get(ratings::show_rated_stage))
        .route("/ratings/{id}/replay/frames", get(ratings::show_rated_frames))
        .route("/me/assignments", get(documents::list_assignments))
        .route("/exercises", get(documents::list_exercises))
        .route("/exercises/{id}", get(documents::show_exercise))
        .route("/stations/me", get(stations::show_station))
        .route("/stations/sign-in", post(stations::sign_in_at_station))
        .around(|routes| {
            let fallback = async || ApiError(Error::NotFound);
            routes.fallback(fallback).layer(from_fn_with_state(state.clone(), caller::require_caller))
        })
        .merge(tus::upload_routes(state))
        // A station that joins has no token yet: its code lets it in.
        .route("/stations/pair", post(stations::pair_station))
        // Describes what is public knowledge anyway: no token needed.
        .route("/openapi.json", get(async || Json(description())))
}

/// The OpenAPI description.
#[must_use]
pub fn description() -> Description {
    description::ApiDescription::openapi()
}

/// The id in a path. What cannot be an id names nothing: 404, as an id of nothing.
struct ApiId<T>(T);

impl<T: DeserializeOwned + Send, S: Send + Sync> FromRequestParts<S> for ApiId<T> {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Self::Rejection> {
        let path = Path::<T>::from_request_parts(parts, state).await;
        path.map(|Path(id)| Self(id)).map_err(|_| ApiError(Error::NotFound))
    }
}

/// A JSON body, refused as a problem.
struct ApiJson<T>(T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for ApiJson<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request, state: &S) -> Result<Self, Self::Rejection> {
        let body = Json::<T>::from_request(request, state).await;
        body.map(|Json(said)| Self(said)).map_err(|refused| ApiError(Error::BadRequest(refused.body_text())))
    }
}
