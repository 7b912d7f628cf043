//! Consent, retention and erasure.

pub(crate) mod erasing;
pub(crate) mod erasures;
pub(crate) mod own_data;
pub(crate) mod retention;
