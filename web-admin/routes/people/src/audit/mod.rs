//! The audit log.

use routes_base::{Routes, get};

mod log;

/// Returns the routes of these pages.
pub(crate) fn audit_routes() -> Routes {
    Routes::new()
        .route("/admin/audit", get(log::show_audit_log))
        .route("/admin/audit.csv", get(log::download_audit_log))
}
