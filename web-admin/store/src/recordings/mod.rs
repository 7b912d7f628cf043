//! Recordings of attempts.

pub mod duplicate_backfill;
pub mod links;
pub mod parse_attempts;
pub mod proofs;
pub mod sessions;
pub mod uploads;
