//! Recordings of attempts.

pub mod stored_files;
