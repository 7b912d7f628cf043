//! Derived topics: minimum, maximum and mean over a window.

use crate::sample::Sample;
use crate::wire::{NeedleSummary, Range};

/// Running minimum, maximum and mean.
#[derive(Clone, Copy, Debug)]
struct RunningRange {
    min: f32,
    max: f32,
    sum: f64,
}

impl RunningRange {
    const EMPTY: Self = Self { min: f32::INFINITY, max: f32::NEG_INFINITY, sum: 0.0 };

    fn add(&mut self, value: f64) {
        self.min = self.min.min(value as f32);
        self.max = self.max.max(value as f32);
        self.sum += value;
    }

    fn range(&self, ticks: u32) -> Range {
        Range { min: self.min, max: self.max, mean: (self.sum / f64::from(ticks)) as f32 }
    }
}

/// Accumulator of the current 10 ms window.
#[derive(Debug)]
pub(crate) struct SummaryWindow {
    start_s: f64,
    ticks: u32,
    axial_n: RunningRange,
    depth_m: RunningRange,
    speed_m_per_s: RunningRange,
}

impl SummaryWindow {
    /// An empty window.
    pub(crate) const EMPTY: Self = Self {
        start_s: 0.0,
        ticks: 0,
        axial_n: RunningRange::EMPTY,
        depth_m: RunningRange::EMPTY,
        speed_m_per_s: RunningRange::EMPTY,
    };

    pub(crate) fn add(&mut self, sample: &Sample) {
        if self.ticks == 0 {
            self.start_s = sample.t_s;
        }
        let [vx, vy, vz] = sample.velocity_m_per_s.map(f64::from);
        self.ticks += 1;
        self.axial_n.add(sample.axial_n());
        self.depth_m.add(f64::from(sample.depth_m));
        self.speed_m_per_s.add((vx * vx + vy * vy + vz * vz).sqrt());
    }

    /// Returns the window's summary and resets the window. `None` if the window is empty.
    pub(crate) fn take(&mut self) -> Option<NeedleSummary> {
        let window = std::mem::replace(self, Self::EMPTY);
        (window.ticks > 0).then(|| NeedleSummary {
            t_s: window.start_s,
            ticks: window.ticks,
            axial_n: Some(window.axial_n.range(window.ticks)),
            depth_m: Some(window.depth_m.range(window.ticks)),
            speed_m_per_s: Some(window.speed_m_per_s.range(window.ticks)),
        })
    }
}
