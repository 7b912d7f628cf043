//! Signing in.

pub(crate) mod answer_times;
pub(crate) mod federation;
pub(crate) mod initial_passwords;
pub(crate) mod lti;
pub(crate) mod passkeys;
pub(crate) mod school_boundaries;
pub(crate) mod second_factors;
pub(crate) mod shared_addresses;
pub(crate) mod signing_in;
pub(crate) mod tokens;
