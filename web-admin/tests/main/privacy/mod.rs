//! Consent, retention and erasure.

pub(crate) mod erasing;
pub(crate) mod erasures;
pub(crate) mod own_data;
mod processing_record;
pub(crate) mod retention;
