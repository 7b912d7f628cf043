//! Learning records: statements about attempts (xAPI), sent to the learning record store of a school.

pub mod queueing;
pub mod sending;
pub mod stores;
