//! Recordings of attempts.

use routes_base::{Routes, get, post};

mod links;
mod others;
mod replay;
pub(crate) mod sessions;

/// Returns the routes of these pages.
pub(crate) fn attempt_routes() -> Routes {
    Routes::new()
        .route("/sessions/{id}", get(sessions::show_session))
        .route("/sessions/{id}/replay", get(replay::show_replay))
        .route("/sessions/{id}/comments", post(replay::add_comment))
        .route("/sessions/{id}/comments/{comment}/answers", post(replay::answer_comment))
        .route("/sessions/{id}/comments/{comment}/withdraw", post(replay::withdraw_comment))
        .route("/expert-consent", post(replay::change_own_consent))
        .route("/sessions/{id}/links", post(links::make_link))
}

/// Returns the public route of shared recordings, which requires the token in their address.
#[must_use]
pub fn linked_routes() -> Routes {
    Routes::new().route("/recordings/{token}/{file}", get(links::open_link).options(links::open_link))
}
