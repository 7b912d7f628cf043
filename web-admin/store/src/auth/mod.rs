//! Signing in.

pub mod account_links;
pub mod client_keys;
pub mod federation;
pub mod lti;
pub mod passkeys;
pub mod rate_limits;
pub mod second_factors;
pub mod tokens;
pub mod web_sessions;
pub mod webauthn_challenges;
