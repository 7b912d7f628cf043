//! Signing in.

pub mod account;
pub mod deep_linking;
pub mod deliveries;
pub mod federation;
pub mod login;
pub mod lti;
pub mod passkeys;
pub mod platform_registration;
pub mod reauthentication;
pub mod second_factor;
pub mod tokens;
