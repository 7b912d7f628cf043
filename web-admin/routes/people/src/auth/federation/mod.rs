//! Sign-in with accounts of other systems.

use routes_base::{Routes, get, post};

mod entering;
mod identities;
mod joining;
mod providers;

pub(super) use entering::{Buttons, answer_refused, leave_for, list_buttons};
pub(super) use joining::{HELD_LINK, hold_identity};

/// Returns the routes for anonymous visitors.
pub(super) fn public_routes() -> Routes {
    Routes::new()
        .route("/sign-in/{id}", post(entering::begin_sign_in))
        .route("/sign-in/callback", get(entering::finish_sign_in))
        .route("/sign-in/join", get(joining::show_unknown_person).merge(post(joining::join_by_password)))
        .route("/sign-in/begin", post(joining::begin_account))
}

/// Returns the routes for signed-in people.
pub(super) fn own_routes() -> Routes {
    Routes::new()
        .route("/account/identities", get(identities::show_identities))
        .route("/account/identities/join/{id}", post(identities::begin_joining))
        .route("/account/identities/{id}/remove", post(identities::remove_identity))
        .route("/account/prove/{id}", post(identities::begin_proof))
        .route("/admin/sign-in", get(providers::show_providers).merge(post(providers::add_provider)))
        .route("/admin/sign-in/local", post(providers::set_local_passwords))
        .route("/admin/sign-in/{id}", get(providers::show_provider).merge(post(providers::change_provider)))
        .route("/admin/sign-in/{id}/try", post(providers::try_provider))
        .route("/admin/sign-in/{id}/disable", post(providers::disable_provider))
        .route("/admin/sign-in/{id}/enable", post(providers::enable_provider))
}
