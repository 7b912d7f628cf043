//! Scores and reviews.

use routes_base::{Routes, get, post};

mod exam_files;
mod exams;
mod ratings;
mod regrading;
mod review;
mod segments;
mod supervision;

/// Returns the routes of these pages.
pub(crate) fn grading_routes() -> Routes {
    Routes::new()
        .route("/sessions/{id}/grade", get(review::show_grade))
        .route("/sessions/{id}/exam-files", post(exam_files::freeze))
        .route("/sessions/{id}/exam-files/{file}", get(exam_files::download))
        .route("/sessions/{id}/override", post(review::put_override))
        .route("/sessions/{id}/override/withdraw", post(review::withdraw_override))
        .route("/sessions/{id}/review", post(review::mark_reviewed))
        .route("/sessions/{id}/supervision", post(supervision::confirm_supervision))
        .route("/sessions/{id}/regrade", get(review::preview_regrade).merge(post(review::regrade_attempt)))
        .route("/review", get(review::show_queue))
        .merge(exams::exam_routes())
        .merge(ratings::rating_routes())
        .merge(segments::segment_routes())
        .merge(regrading::regrading_routes())
}
