//! Sign-in with accounts of other systems, by OpenID Connect.

pub mod client_keys;
pub(super) mod documents;
pub mod flows;
pub mod identities;
pub mod providers;
pub mod sources;
mod tokens;
