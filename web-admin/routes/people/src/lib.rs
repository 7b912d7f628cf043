//! Pages about people and their school: signing in, accounts, lists, consents, settings, the audit
//! log.
//!
//! Functions that query the database fail when the database does; `# Errors` sections list only the
//! other causes.

#[macro_use(tr)]
extern crate words;

use routes_base::Routes;

mod operations;
mod people;
mod signing_in;

pub use signing_in::sign_in_routes;

/// Returns the pages for signed-in people.
#[must_use]
pub fn people_routes() -> Routes {
    signing_in::own_routes().merge(people::directory_routes()).merge(operations::operation_routes())
}
