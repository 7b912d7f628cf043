//! Re-simulates the recorded input and compares every recorded force.

use mechanics::puncture::PunctureParams;

use crate::read::Recording;

/// The largest deviation found.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Verification {
    /// Ticks compared.
    pub ticks: u64,
    /// Largest deviation of any force channel, in N, after rounding to f32.
    pub largest_deviation_n: f64,
    /// Time of it, in s.
    pub at_s: f64,
    /// Channel of it, for example `friction_n`; empty when there is none.
    pub channel: String,
    /// Events of the re-simulation that the recording lacks, or the other way round.
    pub event_differences: u64,
}

/// Compares a recording with its own re-simulation.
#[must_use]
pub fn verify(_recording: &Recording, _params: &PunctureParams) -> Verification {
    unimplemented!()
}
