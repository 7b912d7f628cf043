//! Recordings of attempts.

pub mod attempt_key;
pub mod cursor;
pub mod proof;
pub mod replay;
pub mod series;
pub mod start_time;
