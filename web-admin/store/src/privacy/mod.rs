//! Consent, retention and erasure.

pub mod experts;
pub mod exports;
pub mod retention;
pub mod texts;
