//! Signing in and out, second factors, passkeys.

use routes_base::{Routes, get, post};

mod federation;
mod half;
mod join;
mod language;
mod login;
mod lti;
mod passkeys;
pub(crate) mod proving;
mod second_factor;
mod sign_in_code;
pub(crate) mod tokens;

/// Returns the routes for anonymous visitors.
#[must_use]
pub fn sign_in_routes() -> Routes {
    login::sign_in_routes()
        .merge(federation::public_routes())
        .merge(lti::public_routes())
        .route("/language", post(language::choose_language))
}

/// Returns the routes for signed-in people.
pub(crate) fn own_routes() -> Routes {
    login::signed_in_routes()
        .route("/sign-in-code", get(sign_in_code::show_sign_in_code).merge(post(sign_in_code::make_sign_in_code)))
        .merge(second_factor::second_factor_routes())
        .merge(passkeys::passkey_routes())
        .merge(tokens::token_routes())
        .merge(federation::own_routes())
        .merge(lti::own_routes())
}
