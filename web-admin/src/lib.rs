//! The service of Stylet: receives recordings, scores them, and shows the results to trainees and
//! instructors.
//!
//! A library with a thin program around it, so that tests run the router in process.
//!
//! Functions that query the database fail when the database does; `# Errors` sections list only the
//! other causes.

pub mod cli;
pub mod research;
pub mod routes;
pub mod serving;
mod telemetry;

pub use demo;
pub use routes_base::AppState;
pub use worker::{self, outbox};
