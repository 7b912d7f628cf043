//! The absorbing Markov chain of an LC-CUSUM: its states are the values that S can reach.

use std::collections::BTreeMap;

use super::REACHED;

/// The values that S can reach within a number of attempts, in order, and the successor states
/// after a success and a failure.
pub(super) struct Chain {
    values: Vec<f64>,
    after_success: Vec<usize>,
    after_failure: Vec<usize>,
    attempts: u32,
}

impl Chain {
    /// Builds the chain for the gain of a success and the loss of a failure, both above 0. Since S
    /// restarts at exactly 0, the number of successes and failures since then determines the value;
    /// the same pair is the same state, bit for bit.
    pub(super) fn new(gain: f64, loss: f64, attempts: u32) -> Self {
        let value = |(successes, failures): (u32, u32)| f64::from(successes) * gain - f64::from(failures) * loss;
        let mut pairs = vec![(0, 0)];
        for successes in 1..=attempts {
            let within = (0..=attempts - successes).map(|failures| (successes, failures));
            pairs.extend(within.take_while(|&pair| value(pair) > REACHED));
        }
        pairs.sort_by(|a, b| value(*a).total_cmp(&value(*b)));
        let at: BTreeMap<(u32, u32), usize> = pairs.iter().enumerate().map(|(i, pair)| (*pair, i)).collect();
        // A pair beyond the last attempt is never reached in time, so its successor is irrelevant.
        let state = |pair: (u32, u32)| if value(pair) > REACHED { at.get(&pair).copied().unwrap_or(0) } else { 0 };
        Self {
            values: pairs.iter().map(|&pair| value(pair)).collect(),
            after_success: pairs.iter().map(|&(s, f)| state((s + 1, f))).collect(),
            after_failure: pairs.iter().map(|&(s, f)| state((s, f + 1))).collect(),
            attempts,
        }
    }

    /// Returns the smallest value with P(max S ≥ value within the attempts | failure rate) ≤
    /// `probability`.
    pub(super) fn limit(&self, failure_rate: f64, probability: f64) -> Option<f64> {
        // The probability decreases with the limit, so binary search applies.
        let states: Vec<usize> = (1..self.values.len()).collect();
        let at = states.partition_point(|&state| self.reached(state, failure_rate) > probability);
        states.get(at).map(|&state| self.values[state])
    }

    /// Returns the probability that S reaches the value of a state within the attempts.
    fn reached(&self, limit: usize, failure_rate: f64) -> f64 {
        // Values that differ only by rounding are equal.
        let limit = self.values.partition_point(|v| *v < self.values[limit] - REACHED);
        let mut now = vec![0.0; limit];
        now[0] = 1.0;
        let mut reached = 0.0;
        for _ in 0..self.attempts {
            let mut next = vec![0.0; limit];
            for (state, p) in now.iter().enumerate().filter(|(_, p)| **p > 0.0) {
                let (up, down) = (self.after_success[state], self.after_failure[state]);
                if up >= limit {
                    reached += p * (1.0 - failure_rate)
                } else {
                    next[up] += p * (1.0 - failure_rate)
                }
                next[down] += p * failure_rate;
            }
            now = next;
        }
        reached
    }
}
