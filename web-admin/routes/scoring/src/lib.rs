//! Pages about attempts: their scores, replays, grades and reviews, ratings, marked pops.
//!
//! Functions that query the database fail when the database does; `# Errors` sections list only the
//! other causes.

#[macro_use(tr)]
extern crate words;

use routes_base::{Routes, get, post};

mod links;
mod others;
mod ratings;
mod regrading;
mod replay;
mod review;
mod segments;
mod sessions;
mod supervision;

/// Returns the pages for signed-in people.
#[must_use]
pub fn scoring_routes() -> Routes {
    Routes::new()
        .route("/sessions/{id}", get(sessions::show_session))
        .route("/sessions/{id}/replay", get(replay::show_replay))
        .route("/sessions/{id}/comments", post(replay::add_comment))
        .route("/sessions/{id}/comments/{comment}/answers", post(replay::answer_comment))
        .route("/sessions/{id}/comments/{comment}/withdraw", post(replay::withdraw_comment))
        .route("/expert-consent", post(replay::change_own_consent))
        .route("/sessions/{id}/links", post(links::make_link))
        .route("/sessions/{id}/grade", get(review::show_grade))
        .route("/sessions/{id}/override", post(review::put_override))
        .route("/sessions/{id}/override/withdraw", post(review::withdraw_override))
        .route("/sessions/{id}/review", post(review::mark_reviewed))
        .route("/sessions/{id}/supervision", post(supervision::confirm_supervision))
        .route("/sessions/{id}/regrade", get(review::preview_regrade).merge(post(review::regrade_attempt)))
        .route("/review", get(review::show_queue))
        .merge(ratings::rating_routes())
        .merge(segments::segment_routes())
        .merge(regrading::regrading_routes())
}

/// Returns the public route of shared recordings, which requires the token in their address.
#[must_use]
pub fn linked_routes() -> Routes {
    Routes::new().route("/recordings/{token}/{file}", get(links::open_link).options(links::open_link))
}
