//! Fair scheduling of scoring between schools: first the school with the fewest running jobs, then
//! the one that has used the least time. Idle schools accumulate no credit.

use std::collections::BTreeMap;
use std::time::Duration;

use model::ids::SchoolId;

/// Usage of the workers by the schools.
#[derive(Debug, Default)]
pub struct FairScheduler {
    schools: BTreeMap<SchoolId, SchoolShare>,
    /// Time used by the school that was scheduled last. A newly active school starts from it.
    floor: Duration,
}

#[derive(Clone, Copy, Debug, Default)]
struct SchoolShare {
    used: Duration,
    running: usize,
}

/// Number of workers, and whether several schools share them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScorerPool {
    /// Total number of workers.
    pub judges: usize,
    /// Whether there is more than one school.
    pub several: bool,
}

impl ScorerPool {
    /// Returns the maximum number of workers for one school: all but one if there are other
    /// schools.
    const fn most(self) -> usize {
        if self.several && self.judges > 1 { self.judges - 1 } else { self.judges }
    }
}

impl FairScheduler {
    /// Returns the schools that may be scheduled, by priority.
    #[must_use]
    pub fn order(&self, mut waiting: Vec<SchoolId>, bench: ScorerPool) -> Vec<SchoolId> {
        waiting.retain(|school| self.of(*school).running < bench.most());
        waiting.sort_by_key(|school| {
            let share = self.of(*school);
            (share.running, share.used.max(self.floor), *school)
        });
        waiting
    }

    /// Records that a job of a school has started.
    pub fn begin(&mut self, school: SchoolId) {
        let mut share = self.of(school);
        share.used = share.used.max(self.floor);
        share.running += 1;
        self.floor = share.used;
        self.schools.insert(school, share);
    }

    /// Records that a job of a school has ended, and its duration.
    pub fn end(&mut self, school: SchoolId, took: Duration) {
        let mut share = self.of(school);
        share.used += took;
        share.running = share.running.saturating_sub(1);
        self.schools.insert(school, share);
    }

    fn of(&self, school: SchoolId) -> SchoolShare {
        self.schools.get(&school).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    //! No school may wait for the many jobs of another, nor for its long ones.

    use super::*;

    const S: Duration = Duration::from_secs(1);

    fn schools() -> [SchoolId; 3] {
        [1, 2, 3].map(SchoolId::from_u128)
    }

    fn turns(
        shares: &mut FairScheduler,
        waiting: &[SchoolId],
        took: impl Fn(SchoolId) -> Duration,
        count: usize,
    ) -> Vec<SchoolId> {
        let bench = ScorerPool { judges: 1, several: true };
        let turn = |_| {
            let next = shares.order(waiting.to_vec(), bench)[0];
            shares.begin(next);
            shares.end(next, took(next));
            next
        };
        (0..count).map(turn).collect()
    }

    #[test]
    fn equal_jobs_go_round() {
        let [a, b, c] = schools();
        assert_eq!(turns(&mut FairScheduler::default(), &[a, b, c], |_| S, 6), [a, b, c, a, b, c]);
    }

    #[test]
    fn school_of_long_jobs_waits_until_others_had_equal_time() {
        let [a, b, _] = schools();
        let took = |school| if school == a { 10 * S } else { S };
        assert_eq!(turns(&mut FairScheduler::default(), &[a, b], took, 12)[1..11], [b; 10]);
    }

    #[test]
    fn who_comes_late_has_saved_nothing_up() {
        let [a, b, _] = schools();
        let mut shares = FairScheduler::default();
        turns(&mut shares, &[a], |_| S, 100);
        let next = turns(&mut shares, &[a, b], |_| S, 6);
        assert_eq!(next.iter().filter(|school| **school == a).count(), 3, "{next:?}");
    }

    #[test]
    fn one_judge_of_several_stays_free_for_others() {
        let [a, b, _] = schools();
        let mut shares = FairScheduler::default();
        shares.begin(a);
        let (two, alone) = (ScorerPool { judges: 2, several: true }, ScorerPool { judges: 2, several: false });
        assert_eq!(shares.order(vec![a, b], two), [b]);
        assert_eq!(shares.order(vec![a], alone), [a], "where there is no other, none is kept");
    }
}
