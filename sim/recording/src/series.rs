//! Fewer points: every n-th sample, or the least and largest value of each stretch of a chart.

use crate::read::Recording;
use crate::sample::Sample;

/// The same recording with every `factor`-th sample, starting with the first; what a slower servo would have recorded.
/// Events and ledgers stay. A factor of 0 counts as 1.
#[must_use]
pub fn decimate(recording: &Recording, factor: usize) -> Recording {
    let factor = factor.max(1);
    let mut slower = recording.clone();
    slower.samples = recording.samples.iter().step_by(factor).copied().collect();
    slower.session.tick_hz /= factor as f64;
    slower
}

/// What a stretch of samples came to.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Bucket {
    /// Time of its first sample since the start, in s.
    pub t_s: f64,
    /// Least depth, in m.
    pub depth_min_m: f64,
    /// Largest depth, in m.
    pub depth_max_m: f64,
    /// Least axial force, in N.
    pub axial_min_n: f64,
    /// Largest axial force, in N.
    pub axial_max_n: f64,
}

/// At most `points` buckets of equally many samples, in order; no peak is lost.
#[must_use]
pub fn series(samples: &[Sample], points: usize) -> Vec<Bucket> {
    let size = samples.len().div_ceil(points.max(1)).max(1);
    samples.chunks(size).filter_map(bucket).collect()
}

fn bucket(samples: &[Sample]) -> Option<Bucket> {
    let single = |s: &Sample| {
        let (depth_m, axial_n) = (f64::from(s.depth_m), s.axial_n());
        Bucket { t_s: s.t_s, depth_min_m: depth_m, depth_max_m: depth_m, axial_min_n: axial_n, axial_max_n: axial_n }
    };
    samples.iter().map(single).reduce(|a, b| Bucket {
        t_s: a.t_s,
        depth_min_m: a.depth_min_m.min(b.depth_min_m),
        depth_max_m: a.depth_max_m.max(b.depth_max_m),
        axial_min_n: a.axial_min_n.min(b.axial_min_n),
        axial_max_n: a.axial_max_n.max(b.axial_max_n),
    })
}
