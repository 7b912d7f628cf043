//! All operations that change data: one function per operation, which opens the transaction,
//! checks, writes, and appends to the audit log. Nothing else opens a write transaction.
//!
//! Every function that uses the database can fail with a database error; `# Errors` sections list
//! the other errors.

#[macro_use(tr)]
extern crate words;

pub mod audit;
pub mod auth;
pub mod authoring;
pub mod error;
mod leases;
pub mod letters;
pub mod operations;
pub mod people;
pub mod privacy;
pub mod recordings;
pub mod replicas;
pub mod sandbox;
pub mod sandbox_jobs;
pub mod scoring;
pub mod service;
pub mod stations;
pub mod studies;
pub mod surveys;
pub mod training;

pub use error::Error;
pub use service::Service;

/// Target of the spans exported to a collector; the log omits them.
pub const SPANS: &str = "spans";
