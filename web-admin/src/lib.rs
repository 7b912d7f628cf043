//! The service of Stylet: takes recordings in, scores them, shows what trainees and instructors need to see.
//!
//! A library with a thin program around it, so that tests run the router in process.
//!
//! Whatever asks the database fails when the database does; a function says only what else it refuses.

pub mod cli;
pub mod research;
pub mod routes;
pub mod serving;
mod telemetry;

pub use demo;
pub use routes_base::AppState;
pub use worker::{self, outbox};
