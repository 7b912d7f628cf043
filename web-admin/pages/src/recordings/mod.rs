//! Recordings of attempts.

pub mod links;
pub mod replay;
pub mod session;
