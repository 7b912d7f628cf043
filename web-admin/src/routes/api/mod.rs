//! `/api/v1`: JSON for programs.

use axum::Router;

use crate::AppState;

/// The API.
pub fn router(_: &AppState) -> Router<AppState> {
    Router::new()
}
