//! The service of Stylet: takes recordings in, scores them, shows what trainees and instructors need to see.
//!
//! A library with a thin program around it, so that tests run the router in process.
//!
//! Whatever asks the database fails when the database does; a function says only what else it refuses.

#[macro_use(sentence, tr, trn)]
extern crate words;

pub mod cli;
pub mod demo;
pub mod error;
mod examining;
pub mod export;
pub mod monitoring;
pub mod outbox;
mod refusals;
pub mod research;
pub mod routes;
pub mod serving;
pub mod startup;
mod telemetry;
pub mod worker;

pub use startup::AppState;
