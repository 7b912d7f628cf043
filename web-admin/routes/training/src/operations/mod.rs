//! The home page of each role, and the administrator's pages about the service.

use routes_base::{Routes, get, post};

mod admin;
mod service;
mod start;

/// Returns the routes of these pages.
pub(crate) fn home_routes() -> Routes {
    Routes::new()
        .route("/", get(start::show_home))
        .route("/admin", get(admin::show_administration))
        .route("/admin/service", get(service::show_service_log))
        .route("/admin/pairing-codes", post(admin::make_pairing_code))
        .route("/admin/stations/{id}/revoke", post(admin::revoke_station))
}
