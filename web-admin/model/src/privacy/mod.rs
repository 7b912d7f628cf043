//! Consent, retention and erasure.

pub mod recipient;
pub mod retention;
pub mod texts;
