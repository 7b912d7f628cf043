//! Progress pages and their exports: each table is the result of one query, both on the page and in
//! the file.

mod attempts;
mod badge;
pub(super) mod certificate;
mod cohort;
mod metrics;
mod school;
mod trainee;

use routes_base::{Routes, get, post};

/// Returns the routes of these pages.
pub(super) fn progress_routes() -> Routes {
    Routes::new()
        .route("/trainees/{id}/exercises/{exercise}", get(trainee::show_trainee_step))
        .route("/trainees/{id}/exercises/{exercise}/attempts.csv", get(trainee::export_trainee_step))
        .route("/trainees/{id}/certificates/{curriculum}", post(certificate::issue_certificate))
        .route("/trainees/{id}/certificates/{curriculum}/badge.json", get(badge::export_badge))
        .route("/trainees/{id}/certificates/{curriculum}/badge.svg", get(badge::draw_badge))
        .route("/cohorts/{id}/progress", get(cohort::show_cohort_progress))
        .route("/cohorts/{id}/progress.csv", get(cohort::export_cohort_progress))
        .route("/cohorts/{id}/exercises/{exercise}", get(metrics::show_cohort_metrics))
        .route("/cohorts/{id}/exercises/{exercise}/metrics.csv", get(metrics::export_cohort_metrics))
        .route("/progress", get(school::show_school_progress))
        .route("/progress.csv", get(school::export_school_progress))
        .route("/progress/attempts.csv", get(attempts::export_attempts))
}
