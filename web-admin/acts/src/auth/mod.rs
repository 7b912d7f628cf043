//! Signing in.

pub mod federation;
pub mod lti;
pub mod passkeys;
pub mod passwords;
pub mod rate_limits;
pub mod second_factor;
pub mod signing_in;
pub mod tokens;
pub mod web_sessions;
pub(crate) mod webauthn_challenges;
