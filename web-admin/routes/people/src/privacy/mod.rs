//! Consent, retention and erasure.

use routes_base::{Routes, get, post};

mod consents;
mod erasing;
mod retention;

/// Returns the routes of these pages.
pub(crate) fn privacy_routes() -> Routes {
    Routes::new()
        .route("/people/{id}/erase", get(erasing::show_erasing).merge(post(erasing::erase_person)))
        .route("/admin/retention", get(retention::show_retention).merge(post(retention::set_retention)))
        .route("/people/{id}/hold", post(retention::hold_person))
        .merge(consents::consent_routes())
}
