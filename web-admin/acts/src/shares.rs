//! Which school is next: the one with the least of the judges, then the one that has cost them the least time. A school that has waited
//! for nothing has saved nothing up.

use std::collections::BTreeMap;
use std::time::Duration;

use model::ids::SchoolId;

/// What schools have of the judges.
#[derive(Debug, Default)]
pub struct Shares {
    schools: BTreeMap<SchoolId, WorkerShare>,
    /// What whoever was begun last had used: a school that comes anew begins there.
    floor: Duration,
}

#[derive(Clone, Copy, Debug, Default)]
struct WorkerShare {
    used: Duration,
    running: usize,
}

/// How many judges there are, and who else is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bench {
    /// Judges in all.
    pub judges: usize,
    /// There is more than one school.
    pub several: bool,
}

impl Bench {
    /// How many of the judges one school may have: one stays free for the others, where there are others.
    const fn most(self) -> usize {
        if self.several && self.judges > 1 { self.judges - 1 } else { self.judges }
    }
}

impl Shares {
    /// Those schools whose turn it may be, in the order of their turns.
    #[must_use]
    pub fn order(&self, mut waiting: Vec<SchoolId>, bench: Bench) -> Vec<SchoolId> {
        waiting.retain(|school| self.of(*school).running < bench.most());
        waiting.sort_by_key(|school| {
            let share = self.of(*school);
            (share.running, share.used.max(self.floor), *school)
        });
        waiting
    }

    /// Notes that a school is given a judge.
    pub fn begin(&mut self, school: SchoolId) {
        let mut share = self.of(school);
        share.used = share.used.max(self.floor);
        share.running += 1;
        self.floor = share.used;
        self.schools.insert(school, share);
    }

    /// Notes that a judge was given back, and after how long.
    pub fn end(&mut self, school: SchoolId, took: Duration) {
        let mut share = self.of(school);
        share.used += took;
        share.running = share.running.saturating_sub(1);
        self.schools.insert(school, share);
    }

    fn of(&self, school: SchoolId) -> WorkerShare {
        self.schools.get(&school).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    //! No school may wait for the many jobs of another, nor for the long ones.

    use super::*;

    const S: Duration = Duration::from_secs(1);

    fn schools() -> [SchoolId; 3] {
        [1, 2, 3].map(SchoolId::from_u128)
    }

    fn turns(
        shares: &mut Shares,
        waiting: &[SchoolId],
        took: impl Fn(SchoolId) -> Duration,
        count: usize,
    ) -> Vec<SchoolId> {
        let bench = Bench { judges: 1, several: true };
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
        assert_eq!(turns(&mut Shares::default(), &[a, b, c], |_| S, 6), [a, b, c, a, b, c]);
    }

    #[test]
    fn a_school_of_long_jobs_waits_until_the_others_have_had_as_much() {
        let [a, b, _] = schools();
        let took = |school| if school == a { 10 * S } else { S };
        assert_eq!(turns(&mut Shares::default(), &[a, b], took, 12)[1..11], [b; 10]);
    }

    #[test]
    fn who_comes_late_has_saved_nothing_up() {
        let [a, b, _] = schools();
        let mut shares = Shares::default();
        turns(&mut shares, &[a], |_| S, 100);
        let next = turns(&mut shares, &[a, b], |_| S, 6);
        assert_eq!(next.iter().filter(|school| **school == a).count(), 3, "{next:?}");
    }

    #[test]
    fn one_judge_of_several_stays_free_for_others() {
        let [a, b, _] = schools();
        let mut shares = Shares::default();
        shares.begin(a);
        let (two, alone) = (Bench { judges: 2, several: true }, Bench { judges: 2, several: false });
        assert_eq!(shares.order(vec![a, b], two), [b]);
        assert_eq!(shares.order(vec![a], alone), [a], "where there is no other, none is kept");
    }
}
