//! Consent, retention and erasure.

pub mod consent;
pub mod erasing;
pub mod retention;
