//! Consent, retention and erasure.

pub mod retention;
pub mod texts;
