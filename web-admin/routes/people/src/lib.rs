//! Pages about people and their school: signing in, accounts, lists, consents, settings, the audit
//! log.
//!
//! Functions that query the database fail when the database does; `# Errors` sections list only the
//! other causes.

#[macro_use(tr)]
extern crate words;

use routes_base::Routes;

mod audit;
pub(crate) mod auth;
mod operations;
mod people;
mod privacy;

pub use auth::sign_in_routes;

/// Returns the pages for signed-in people.
#[must_use]
pub fn people_routes() -> Routes {
    auth::own_routes()
        .merge(people::directory_routes())
        .merge(privacy::privacy_routes())
        .merge(operations::operation_routes())
        .merge(audit::audit_routes())
}
