//! Measurements: this machine, the time that a calculation takes, and the reports of `stylet bench` ([`report`]).

mod clock;
pub mod error;
pub mod machine;
mod progress;
pub mod report;
pub mod timing;
