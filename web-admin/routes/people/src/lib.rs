//! Pages about people and their school: signing in, accounts, lists, consents, settings, the audit log.
//!
//! Whatever asks the database fails when the database does; a function says only what else it refuses.

#[macro_use(tr)]
extern crate words;

use routes_base::Routes;

mod operations;
mod people;
mod signing_in;

pub use signing_in::sign_in_routes;

/// Pages for a person who is signed in.
#[must_use]
pub fn people_routes() -> Routes {
    signing_in::own_routes().merge(people::directory_routes()).merge(operations::operation_routes())
}
