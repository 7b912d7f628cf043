//! What the servo shows to picture, field and overlay: the latest tick, without waiting on either side.

use law::puncture::PunctureOutput;
use nalgebra::Vector3;
use triple_buffer::{Input, Output, triple_buffer};

use super::record::Record;
use super::timing::Quantiles;

/// The latest tick.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The tick as it was recorded.
    pub record: Record,
    /// What the law came to.
    pub output: PunctureOutput,
    /// The law's force scaled to the device, in N, patient frame.
    pub owed_n: Vector3<f64>,
    /// The same after the safety chain, in N, patient frame.
    pub device_n: Vector3<f64>,
    /// What the needle does to the tissue, in N: as [`law::puncture::loads`] writes it, for the field to follow.
    pub loads_n: Vec<f64>,
    /// Buttons held down; see [`crate::device::buttons`].
    pub buttons: u32,
    /// The part of the force that hold, gate and watchdog let through, from 0 to 1.
    pub let_through: f64,
    /// Boundaries that gave way since the start: it rises by one at each pop.
    pub ruptures: u64,
    /// Ticks made.
    pub ticks: u64,
    /// Ticks that began more than a period late.
    pub stalls: u64,
    /// Records that the recorder was too slow for.
    pub dropped: u64,
    /// How late ticks begin, as of the last tenth of a second.
    pub lateness: Quantiles,
    /// What ticks take, as of the last tenth of a second.
    pub compute: Quantiles,
}

/// The writing end. In place, so that nothing is allocated.
pub(super) struct Publisher {
    cell: Input<Latest>,
}

/// The cell's content.
#[derive(Clone, Debug)]
struct Latest {
    /// `None` before the first tick.
    snapshot: Option<Snapshot>,
    /// Room for the first tick's loads.
    spare_n: Vec<f64>,
}

impl Publisher {
    /// Publishes a tick, its loads aside; `loads` writes those into a slice of the right length.
    pub fn publish(&mut self, tick: Snapshot, loads: impl FnOnce(&mut [f64])) {
        let latest = self.cell.input_buffer_mut();
        let mut loads_n = match latest.snapshot.take() {
            Some(old) => old.loads_n,
            None => std::mem::take(&mut latest.spare_n),
        };
        loads(&mut loads_n);
        latest.snapshot = Some(Snapshot { loads_n, ..tick });
        self.cell.publish();
    }
}

/// The reading end.
#[derive(Debug)]
pub struct LatestReader {
    cell: Output<Latest>,
}

impl LatestReader {
    /// The latest tick; none before the first.
    pub fn read(&mut self) -> Option<&Snapshot> {
        self.cell.read().snapshot.as_ref()
    }
}

/// A cell for a tissue with a number of loads.
pub(super) fn cell(loads: usize) -> (Publisher, LatestReader) {
    let (input, output) = triple_buffer(&Latest { snapshot: None, spare_n: vec![0.0; loads] });
    (Publisher { cell: input }, LatestReader { cell: output })
}
