//! Parallel execution of independent work on all cores.

use std::num::NonZero;
use std::ops::Range;

use crate::error::BenchError;

/// Returns the result for each seed, in the order of the seeds; thread i takes every n-th seed,
/// starting with the i-th.
///
/// # Errors
/// If a thread panicked.
pub fn each_seed<T: Send>(seeds: Range<u64>, of: impl Fn(u64) -> T + Sync) -> Result<Vec<T>, BenchError> {
    let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
    let some = &|first: usize| -> Vec<(u64, T)> {
        seeds.clone().skip(first).step_by(threads).map(|seed| (seed, of(seed))).collect()
    };
    let mut found = std::thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|first| scope.spawn(move || some(first))).collect();
        let found = running.into_iter().map(|thread| thread.join().map_err(|_| BenchError::work("a thread stopped")));
        Ok::<_, BenchError>(found.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect::<Vec<_>>())
    })?;
    found.sort_by_key(|(seed, _)| *seed);
    Ok(found.into_iter().map(|(_, of)| of).collect())
}
