//! Courses, exercises, cohorts, assignments, and the progress of trainees.

use routes_base::authoring::pictures;
use routes_base::{Routes, get, post};

mod assignments;
pub(crate) mod calendar_feed;
mod cohort_people;
pub(crate) mod cohorts;
mod exercise;
pub(crate) mod gradebook;
mod learning_records;
pub(crate) mod news;
mod outcomes;
pub(crate) mod progress;
mod risk;
pub(crate) mod rows;
pub(crate) mod standing;
mod terms;
pub(crate) mod trainees;
mod transcript;

/// Returns the routes of these pages.
pub(crate) fn course_routes() -> Routes {
    Routes::new()
        .route("/curricula", get(exercise::show_curricula))
        .route("/exercises/{id}", get(exercise::show_exercise))
        .route("/exercises/{id}/pictures/{number}", get(pictures::serve_exercise_picture))
        .route("/cohorts", get(cohorts::list_cohorts).merge(post(cohort_people::make_cohort)))
        .route("/cohorts/{id}", get(cohorts::show_cohort))
        .route("/cohorts/{id}/gradebook", get(gradebook::show_gradebook))
        .route("/cohorts/{id}/gradebook.csv", get(gradebook::download_gradebook))
        .route("/cohorts/{id}/people", get(cohort_people::show_cohort_people).merge(post(cohort_people::add_to_cohort)))
        .route("/cohorts/{id}/people/{person}/answer", post(cohort_people::answer_request))
        .route("/cohorts/{id}/people/{person}/remove", post(cohort_people::remove_from_cohort))
        .route("/account/cohorts/{cohort}", post(cohort_people::answer_own_request))
        .route("/trainees/{id}", get(trainees::show_trainee))
        .route("/trainees/{id}/transcript", get(transcript::show_transcript))
        .route("/trainees/{id}/transcript.pdf", get(transcript::export_transcript))
        .route("/news/read", post(news::mark_all_read))
        .route("/account/news", post(news::choose_letters))
        .route("/assignments", get(assignments::list_assignments).merge(post(assignments::make_assignment)))
        .route("/assignments/{id}", get(assignments::show_assignment))
        .route("/assignments/{id}/extend", post(assignments::extend_assignment))
        .route("/at-risk", get(risk::show_at_risk).merge(post(risk::record_support)))
        .route("/admin/at-risk", get(risk::show_rules).merge(post(risk::set_rules)))
        .route("/admin/terms", get(terms::show_terms).merge(post(terms::add_term)))
        .route("/admin/terms/{term}/remove", post(terms::remove_term))
        .route("/cohorts/{id}/programme", get(terms::show_programme))
        .route("/cohorts/{id}/term", post(terms::set_cohort_term))
        .route("/assignments/{id}/withdraw", post(assignments::withdraw_assignment))
        .merge(learning_records::record_routes())
        .merge(outcomes::outcome_routes())
        .merge(calendar_feed::own_calendar_routes())
        .merge(progress::progress_routes())
}
