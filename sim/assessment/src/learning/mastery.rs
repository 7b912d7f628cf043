//! When an exercise of a course counts as mastered: one rule for the service, which keeps it, and for the simulator, which may have to go
//! by what lies on its own disk.

use std::sync::LazyLock;

use documents::MasteryRule;
use serde::{Deserialize, Serialize};

use super::{CusumParams, LearningCurve, Rule, Standing, learning_curve};
use crate::statistics::NotComputable;

/// The rule by which an exercise of a course counts as mastered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mastery {
    /// Passes among attempts in a row.
    Passes {
        /// How many passes.
        passes: u32,
        /// Among how many attempts.
        of: u32,
    },
    /// A learning curve.
    Curve(CurveRule),
}

/// How far attempts at an exercise have come. Attempts are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// The rule was met.
    Mastered {
        /// By this attempt.
        by: usize,
    },
    /// A learning curve said competent, and says no longer.
    Regressing {
        /// Declared by this attempt.
        by: usize,
        /// Lost by this attempt.
        since: usize,
    },
    /// Not mastered yet.
    Open {
        /// Passes among the attempts that the rule looks at.
        passes: u32,
    },
}

/// A learning curve as a rule: what the course states, and the lines that follow from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurveRule {
    /// Rates and errors as the course states them.
    pub params: CusumParams,
    /// Attempts within which the error of an LC-CUSUM holds; absent for a CUSUM.
    pub within: Option<u32>,
    /// Weights and lines.
    pub rule: Rule,
}

/// What a course with another rule is watched by: 20 % of failures are acceptable and 40 % are not; who still fails at 40 % is called
/// competent within 50 attempts in 5 % of cases at most.
static EXAMPLE: LazyLock<Option<CurveRule>> =
    LazyLock::new(|| CurveRule::new(CusumParams { p0: 0.2, p1: 0.4, alpha: 0.05, beta: 0.1 }, Some(50)).ok());

impl CurveRule {
    /// Rates and errors with the lines that follow from them. The limit of an LC-CUSUM takes its time.
    ///
    /// # Errors
    /// When no limit is rare enough for the stated error, or the parameters have no meaning.
    fn new(params: CusumParams, within: Option<u32>) -> Result<Self, NotComputable> {
        Ok(Self { params, within, rule: Rule::new(&params, within)? })
    }

    /// An example, for a course that states no rates: it tells and decides nothing.
    #[must_use]
    pub fn example() -> Option<Self> {
        *EXAMPLE
    }

    /// The curve over attempts in order of time; `true` is a pass.
    #[must_use]
    pub fn over(&self, passed: &[bool]) -> LearningCurve {
        let failures: Vec<bool> = passed.iter().map(|passed| !passed).collect();
        learning_curve(&self.rule, &failures)
    }
}

impl Mastery {
    /// A course's rule. The limit of an LC-CUSUM takes its time, so this is done once.
    ///
    /// # Errors
    /// When no limit is rare enough for the stated error, or the parameters have no meaning.
    pub fn from_rule(rule: &MasteryRule) -> Result<Self, NotComputable> {
        match *rule {
            MasteryRule::Passes { passes, of } => Ok(Self::Passes { passes, of }),
            MasteryRule::Cusum { within, p0, p1, alpha, beta } => {
                CurveRule::new(CusumParams { p0, p1, alpha, beta }, within).map(Self::Curve)
            }
        }
    }

    /// How far attempts in order of time have come, `true` for a pass, and the curve where the rule is one. Void attempts are none.
    #[must_use]
    pub fn judge(&self, passed: &[bool]) -> (Reached, Option<LearningCurve>) {
        match self {
            Self::Passes { passes, of } => (master_by_passes(passed, *passes, *of), None),
            Self::Curve(rule) => {
                let curve = rule.over(passed);
                (master_by_curve(passed, &curve), Some(curve))
            }
        }
    }
}

/// Mastered while the curve says competent. What a curve has declared opens the next exercise for good, as with passes.
fn master_by_curve(passed: &[bool], curve: &LearningCurve) -> Reached {
    let lost = || curve.points.iter().rposition(|p| p.standing == Standing::Competent).map_or(0, |last| last + 1);
    match (curve.standing, curve.competent_at) {
        (Standing::Competent, Some(by)) => Reached::Mastered { by },
        (Standing::Regressing, Some(by)) => Reached::Regressing { by, since: lost() },
        _ => Reached::Open { passes: count_passes(passed) },
    }
}

fn count_passes(passed: &[bool]) -> u32 {
    passed.iter().map(|passed| u32::from(*passed)).sum()
}

/// Mastered by the first attempt that completes `needed` passes among `of` in a row. Once reached it stays: what comes after shows as a
/// decline, and an exercise that opened another is not closed again under a trainee's hands.
fn master_by_passes(passed: &[bool], needed: u32, of: u32) -> Reached {
    let of = of as usize;
    let completes = |by: &usize| count_passes(&passed[(by + 1).saturating_sub(of)..=*by]) >= needed;
    let open = || Reached::Open { passes: count_passes(&passed[passed.len().saturating_sub(of)..]) };
    (0..passed.len()).find(completes).map_or_else(open, |by| Reached::Mastered { by })
}
