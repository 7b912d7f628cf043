//! Operation of a school by its administrators: settings, origins, backups, retention, the audit
//! log.

use axum::extract::DefaultBodyLimit;
use routes_base::{Routes, get, post};

mod backups;
mod logo;
mod origins;
mod papers;
pub(crate) mod settings;

/// Returns the routes of these pages.
pub(crate) fn operation_routes() -> Routes {
    Routes::new()
        .route("/admin/certificate-needs", post(settings::set_certificate_needs))
        .route("/admin/origins", get(origins::show_origins).merge(post(origins::set_origins)))
        .route("/admin/papers", get(papers::show_papers))
        .route("/admin/settings", get(settings::show_settings).merge(post(settings::put_settings)))
        .route("/school/logo", get(logo::serve_logo))
        .route("/admin/settings/logo", post(logo::put_logo).layer(DefaultBodyLimit::max(2 * logo::MOST_LOGO_BYTES)))
        .route("/admin/settings/logo/remove", post(logo::remove_logo))
        .route("/admin/settings/test-letter", post(settings::send_test_letter))
        .route("/admin/backups", get(backups::show_backups))
}
