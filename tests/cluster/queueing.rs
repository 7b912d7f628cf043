//! What several workers come to where one of them at a time writes to the database: a closed network of a station at which nobody waits
//! (scoring) and one at which everybody does (the writer's lock), by exact mean value analysis. Reiser and Lavenberg, Journal of the ACM
//! 27 (1980) 313.

/// What one attempt takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttemptTimes {
    /// Time beside the lock, in s.
    pub beside_s: f64,
    /// Time within it, in s.
    pub within_s: f64,
}

/// What so many workers come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Throughput {
    /// How many.
    pub workers: u32,
    /// Attempts per s.
    pub rate: f64,
    /// Of what as many would do that never wait for each other.
    pub efficiency: f64,
    /// Share of the time that somebody holds the lock.
    pub busy: f64,
}

impl AttemptTimes {
    /// For 1 worker, 2, 4 and so on, each on a core of its own, up to a number.
    pub fn throughputs(self, most: u32) -> Vec<Throughput> {
        let Self { beside_s, within_s } = self;
        let (mut found, mut waiting) = (Vec::new(), 0.0);
        for workers in 1..=most {
            // Who comes finds those who would wait if they were not there.
            let response_s = within_s * (1.0 + waiting);
            let rate = f64::from(workers) / (beside_s + response_s);
            waiting = rate * response_s;
            if workers.is_power_of_two() {
                let efficiency = rate * (beside_s + within_s) / f64::from(workers);
                found.push(Throughput { workers, rate, efficiency, busy: rate * within_s });
            }
        }
        found
    }

    /// How many workers it takes until the lock is the limit: where both asymptotes meet.
    pub fn limit(self) -> f64 {
        (self.beside_s + self.within_s) / self.within_s
    }
}

#[cfg(test)]
mod tests {
    //! Fails when workers who never meet are slowed, or when those who only write do not stand in line.

    use super::*;

    #[test]
    fn attempts_that_never_write_never_wait_and_writers_queue() {
        for found in (AttemptTimes { beside_s: 2.0, within_s: 0.0 }).throughputs(256) {
            assert!((found.efficiency - 1.0).abs() < 1e-12 && found.busy == 0.0, "{found:?}");
        }
        for found in (AttemptTimes { beside_s: 0.0, within_s: 0.5 }).throughputs(256) {
            assert!((found.rate - 2.0).abs() < 1e-9 && (found.busy - 1.0).abs() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn two_who_meet_by_chance_wait_as_the_formula_says() {
        // One in two halves: the second finds the first at the lock half of the time.
        let found = AttemptTimes { beside_s: 1.0, within_s: 1.0 }.throughputs(2);
        assert!((found[1].rate - 2.0 / 2.5).abs() < 1e-12, "{found:?}");
    }
}
