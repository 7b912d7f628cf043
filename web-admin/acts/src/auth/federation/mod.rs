//! Sign-in with accounts of other systems, by OpenID Connect.

mod documents;
pub mod flows;
pub mod identities;
pub mod providers;
mod tokens;
