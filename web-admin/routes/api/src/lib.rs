//! `/api/v1`: JSON for programs, authenticated by a bearer token.
//!
//! Functions that query the database fail when the database does; `# Errors` sections list only the
//! other causes.

use acts::error::Error;
use axum::Json;
use axum::extract::{FromRequest, FromRequestParts, Path, Request};
use axum::http::request::Parts;
use axum::middleware::from_fn_with_state;
use axum::routing::get;
use routes_base::error::ApiError;
use routes_base::{AppState, Routes};
use serde::de::DeserializeOwned;
use utoipa::openapi::OpenApi as Description;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

mod caller;
mod description;
mod people;
mod recordings;
mod scoring;
pub(crate) mod stations;
pub(crate) mod surveys;
mod training;

pub use caller::bearer_token;
pub use people::scim::scim_routes;
use recordings::{comments, replay, sessions, tus, upload};
use scoring::{ratings, score};
use training::documents;

/// Returns the endpoints that require a token.
fn caller_endpoints() -> OpenApiRouter<AppState> {
    OpenApiRouter::default()
        .routes(routes!(upload::upload_recording, sessions::list_sessions))
        .routes(routes!(sessions::show_session))
        .routes(routes!(score::show_score))
        .routes(routes!(sessions::serve_recording))
        .routes(routes!(replay::show_series))
        .routes(routes!(comments::list_comments, comments::add_comment))
        .routes(routes!(replay::show_stage))
        .routes(routes!(replay::show_frames))
        .routes(routes!(surveys::list_surveys_after))
        .routes(routes!(surveys::take_answers))
        .routes(routes!(ratings::show_rated_series))
        .routes(routes!(ratings::show_rated_stage))
        .routes(routes!(ratings::show_rated_frames))
        .routes(routes!(documents::list_assignments))
        .routes(routes!(documents::list_exercises))
        .routes(routes!(documents::show_exercise))
        .routes(routes!(documents::show_picture))
        .routes(routes!(stations::show_station))
        .routes(routes!(stations::sign_in_at_station))
}

/// Returns the public endpoints. A station that joins has no token yet: its code authenticates it.
fn open_endpoints() -> OpenApiRouter<AppState> {
    OpenApiRouter::default().routes(routes!(stations::pair_station))
}

/// Returns the routes of the API. Callers are authenticated by a layer that also covers addresses
/// that do not exist.
#[must_use]
pub fn api_routes(state: &AppState) -> Routes {
    Routes::described(caller_endpoints())
        .around(|routes| {
            let fallback = async || ApiError(Error::NotFound);
            routes.fallback(fallback).layer(from_fn_with_state(state.clone(), caller::require_caller))
        })
        .merge(tus::upload_routes(state))
        .merge(Routes::described(open_endpoints()))
        // Contains only public information, so no token is needed.
        .route("/openapi.json", get(async || Json(description())))
}

/// Returns the OpenAPI description.
#[must_use]
pub fn description() -> Description {
    let tus = tus::caller_endpoints().merge(tus::open_endpoints());
    description::describe_api(caller_endpoints().merge(tus).merge(open_endpoints()).into_openapi())
}

/// The id in a path. A malformed id is answered like an unknown one, with 404.
struct ApiId<T>(T);

impl<T: DeserializeOwned + Send, S: Send + Sync> FromRequestParts<S> for ApiId<T> {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Self::Rejection> {
        let path = Path::<T>::from_request_parts(parts, state).await;
        path.map(|Path(id)| Self(id)).map_err(|_| ApiError(Error::NotFound))
    }
}

/// A JSON body; a malformed one is answered with a problem document.
struct ApiJson<T>(T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for ApiJson<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request, state: &S) -> Result<Self, Self::Rejection> {
        let body = Json::<T>::from_request(request, state).await;
        body.map(|Json(said)| Self(said)).map_err(|refused| ApiError(Error::BadRequest(refused.body_text())))
    }
}
