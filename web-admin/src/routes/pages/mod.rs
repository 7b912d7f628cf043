//! Pages: HTML for the signed-in person.

use axum::Router;

use crate::AppState;

/// Pages for whoever is signed in; the layer around them has settled who that is.
pub fn router() -> Router<AppState> {
    Router::new()
}

/// Style sheets and scripts: for anybody.
pub fn assets() -> Router<AppState> {
    Router::new()
}
