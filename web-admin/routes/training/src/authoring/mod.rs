//! Exercises, courses and instruments that are being edited.

use routes_base::{Routes, get, post};

mod draft_pictures;
mod drafts;
mod instrument_drafts;
mod revisions;
mod writing;

/// Returns the routes of these pages.
pub(crate) fn draft_routes() -> Routes {
    Routes::new()
        .route("/curricula/{id}/draft", post(drafts::draft_course))
        .route("/curricula/{id}/revisions", get(revisions::compare_course_revisions))
        .route("/drafts", get(drafts::list_drafts).merge(post(drafts::begin_draft)))
        .route("/drafts/{id}", get(drafts::show_draft).merge(post(drafts::write_draft)))
        .route("/drafts/{id}/discard", post(drafts::discard_draft))
        .route("/drafts/{id}/preview", post(drafts::preview_draft))
        .route("/drafts/{id}/questions", get(instrument_drafts::show_questions))
        .merge(draft_pictures::draft_picture_routes())
        .route("/exercises/{id}/course", post(drafts::add_to_course))
        .route("/exercises/{id}/draft", post(drafts::draft_exercise))
        .route("/exercises/{id}/revisions", get(revisions::compare_exercise_revisions))
        .route("/surveys/instruments/{id}/course", post(instrument_drafts::ask_in_course))
        .route("/surveys/instruments/{id}/draft", post(instrument_drafts::draft_instrument))
}
