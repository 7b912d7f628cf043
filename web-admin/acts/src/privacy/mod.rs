//! Consent, retention and erasure.

pub mod consents;
pub mod erasing;
pub mod erasure_store;
pub mod erasures;
pub mod retention;
pub mod study_consents;
pub mod study_retention;
