//! Publishes the latest tick to the display, the field and the overlay; neither side waits.

use law::puncture::PunctureOutput;
use nalgebra::Vector3;
use triple_buffer::{Input, Output, triple_buffer};

use super::record::Record;
use super::timing::Quantiles;

/// The latest tick.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The tick's record.
    pub record: Record,
    /// Output of the force law.
    pub output: PunctureOutput,
    /// The law's force scaled to the device, in N, patient frame.
    pub owed_n: Vector3<f64>,
    /// The same after the safety chain, in N, patient frame.
    pub device_n: Vector3<f64>,
    /// Loads of the needle on the tissue, in N, in the layout of [`law::puncture::write_loads`];
    /// the field follows them.
    pub loads_n: Vec<f64>,
    /// Buttons held down; see [`crate::device::buttons`].
    pub buttons: u32,
    /// Fraction of the force that hold, gate and watchdog let through, from 0 to 1.
    pub let_through: f64,
    /// Boundaries that ruptured since the start: it increases by one at each pop.
    pub ruptures: u64,
    /// Ticks made.
    pub ticks: u64,
    /// Ticks that began more than a period late.
    pub stalls: u64,
    /// Records dropped because the recorder was too slow.
    pub dropped: u64,
    /// Lateness of the ticks, updated every 50 ticks.
    pub lateness: Quantiles,
    /// Compute time of the ticks, updated every 50 ticks.
    pub compute: Quantiles,
}

/// The writing end. It writes in place, so that nothing is allocated.
pub(super) struct Publisher {
    cell: Input<Latest>,
}

/// The content of the cell.
#[derive(Clone, Debug)]
struct Latest {
    /// `None` before the first tick.
    snapshot: Option<Snapshot>,
    /// Buffer for the first tick's loads.
    spare_n: Vec<f64>,
}

impl Publisher {
    /// Publishes a tick without its loads; `loads` writes those into a slice of the right length.
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
    /// Returns the latest tick; `None` before the first.
    pub fn read(&mut self) -> Option<&Snapshot> {
        self.cell.read().snapshot.as_ref()
    }
}

/// Creates a cell for a tissue with the given number of loads.
pub(super) fn cell(loads: usize) -> (Publisher, LatestReader) {
    let (input, output) = triple_buffer(&Latest { snapshot: None, spare_n: vec![0.0; loads] });
    (Publisher { cell: input }, LatestReader { cell: output })
}
