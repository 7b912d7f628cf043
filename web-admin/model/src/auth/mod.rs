//! Signing in.

pub mod passkey;
pub mod password_refused;
pub mod second_factor;
