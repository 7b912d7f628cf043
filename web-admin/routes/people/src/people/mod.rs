//! The people of a school: the list, accounts, consents.

use axum::extract::DefaultBodyLimit;
use routes_base::{Routes, get, post};

mod account;
mod bulk;
pub(crate) mod directory;
mod provisioning;
mod roster;

/// Returns the routes of these pages.
pub(crate) fn directory_routes() -> Routes {
    Routes::new()
        .route("/people", get(directory::list_people).merge(post(directory::add_person)))
        .route(
            "/people/roster",
            get(roster::show_new_roster)
                .merge(post(roster::send_roster))
                .layer(DefaultBodyLimit::max(roster::MAX_BYTES)),
        )
        .route("/people/rosters/{id}", get(roster::show_roster).merge(post(roster::confirm_roster)))
        .route(
            "/people/rosters/{id}/columns",
            get(roster::show_roster_columns).merge(post(roster::assign_roster_columns)),
        )
        .route("/people/bulk", post(bulk::show_bulk_act))
        .route("/people/bulk/do", post(bulk::do_bulk_act))
        .route("/people/{id}", get(directory::show_person))
        .route("/people/{id}/change", post(directory::change_person))
        .route("/people/{id}/mail-link", post(directory::mail_link))
        .route("/people/{id}/link", post(directory::show_link))
        .route("/people/{id}/disable", post(directory::disable_person))
        .route("/people/{id}/enable", post(directory::enable_person))
        .route("/admin/provisioning", get(provisioning::show_provisioning).merge(post(provisioning::make_token)))
        .route("/admin/provisioning/{id}/revoke", post(provisioning::revoke_token))
        .route("/account", get(account::show_account))
        .route("/account/password", post(account::set_own_password))
        .route("/account/language", post(account::set_own_language))
        .route("/account/export", get(account::export_own_data))
}
