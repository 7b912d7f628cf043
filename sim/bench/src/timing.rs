//! Timing: medians of many repetitions, because machines are noisy.

use tissue::axisymmetric::Superposed;
use tissue::{FieldModel, Problem};

use crate::clock;

/// Number of repetitions and time budget for one figure.
#[derive(Clone, Copy, Debug)]
pub struct TimingEffort {
    /// Minimum number of repetitions.
    pub least: usize,
    /// Maximum number of repetitions.
    pub most: usize,
    /// Time after which no further repetitions are made beyond the minimum, in s.
    pub budget_s: f64,
}

impl TimingEffort {
    /// For a figure that a user waits for.
    pub const SHORT: Self = Self { least: 5, most: 2001, budget_s: 0.05 };

    /// The same for work that may take seconds: a single repetition is sufficient.
    pub const SLOW: Self = Self { least: 1, ..Self::SHORT };
}

/// Runs `work` once; returns its result and the duration, in s.
pub fn once<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = clock::instant();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// Returns the median duration of one call, in s. Calls shorter than reading the clock, tens of
/// nanoseconds, are timed in batches.
pub fn median_s(effort: TimingEffort, mut work: impl FnMut()) -> f64 {
    /// Minimum duration of a batch, in s, so that reading the clock is less than a hundredth of it.
    const BATCH_S: f64 = 5e-6;
    let (_, first_s) = once(&mut work);
    let batch = (BATCH_S / first_s.max(1e-9)).ceil().max(1.0) as usize;
    let start = clock::instant();
    let mut times = Vec::with_capacity(effort.most);
    while times.len() < effort.most && (times.len() < effort.least || start.elapsed().as_secs_f64() < effort.budget_s) {
        let ((), time_s) = once(|| (0..batch).for_each(|_| work()));
        times.push(time_s / batch as f64);
    }
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Returns the time that a tick needs for all samples, in s: responses to unit loads, computed
/// once, multiplied by the load.
pub fn answer_s(field: &mut dyn FieldModel, problem: &Problem, force_n: f64) -> f64 {
    let points: Vec<[f64; 2]> = points(problem).collect();
    let superposed = Superposed::new(&mut [field], &points);
    let mut displacements = vec![[0.0; 2]; points.len()];
    median_s(TimingEffort::SHORT, || {
        superposed.answer(&[std::hint::black_box(force_n)], &mut displacements);
        std::hint::black_box(&displacements);
    })
}

/// Returns radius and depth of every sample, in m, ordered by depth, then radius.
fn points(problem: &Problem) -> impl Iterator<Item = [f64; 2]> {
    problem.sample_depth_m.iter().flat_map(|&depth_m| problem.sample_r_m.iter().map(move |&r_m| [r_m, depth_m]))
}
