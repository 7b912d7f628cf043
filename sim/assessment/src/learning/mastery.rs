//! Mastery of a course's exercise: one rule for the service, which stores it, and for the
//! simulator, which may have to use the attempts on its own disk.

use std::sync::LazyLock;

use documents::MasteryRule;
use serde::{Deserialize, Serialize};

use super::{CusumParams, LearningCurve, Rule, Standing, learning_curve};
use crate::statistics::NotComputable;

/// The mastery rule of an exercise in a course.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mastery {
    /// A number of passes among consecutive attempts.
    Passes {
        /// Required number of passes.
        passes: u32,
        /// Number of consecutive attempts considered.
        of: u32,
    },
    /// A learning curve.
    Curve(CurveRule),
}

/// Progress towards mastery. Attempts are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// The rule is met.
    Mastered {
        /// The attempt that met it.
        by: usize,
    },
    /// The learning curve declared competence, and has revoked it.
    Regressing {
        /// The attempt after which competence was declared.
        by: usize,
        /// The attempt after which it was revoked.
        since: usize,
    },
    /// Not mastered yet.
    Open {
        /// Number of passes among the attempts considered by the rule.
        passes: u32,
    },
}

/// A learning curve as a rule: the parameters of the course, and the limits derived from them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurveRule {
    /// Rates and error probabilities of the course.
    pub params: CusumParams,
    /// Number of attempts for which the error of an LC-CUSUM holds; absent for a CUSUM.
    pub within: Option<u32>,
    /// Weights and limits.
    pub rule: Rule,
}

/// The curve shown for courses with another rule: 20 % of failures are acceptable and 40 % are not;
/// a trainee who still fails at 40 % is declared competent within 50 attempts in at most 5 % of
/// cases.
static EXAMPLE: LazyLock<Option<CurveRule>> =
    LazyLock::new(|| CurveRule::new(CusumParams { p0: 0.2, p1: 0.4, alpha: 0.05, beta: 0.1 }, Some(50)).ok());

impl CurveRule {
    /// Derives the limits from rates and error probabilities. Computing the limit of an LC-CUSUM is
    /// slow.
    ///
    /// # Errors
    /// If no limit is rare enough for the error probability, or if the parameters are out of range.
    fn new(params: CusumParams, within: Option<u32>) -> Result<Self, NotComputable> {
        Ok(Self { params, within, rule: Rule::new(&params, within)? })
    }

    /// Returns an example curve for a course that gives no rates; it is shown for information and
    /// decides nothing.
    #[must_use]
    pub fn example() -> Option<Self> {
        *EXAMPLE
    }

    /// Computes the curve of attempts in order of time; `true` is a pass.
    #[must_use]
    pub fn over(&self, passed: &[bool]) -> LearningCurve {
        let failures: Vec<bool> = passed.iter().map(|passed| !passed).collect();
        learning_curve(&self.rule, &failures)
    }
}

impl Mastery {
    /// Builds a course's rule. Computing the limit of an LC-CUSUM is slow, so build it once.
    ///
    /// # Errors
    /// If no limit is rare enough for the error probability, or if the parameters are out of range.
    pub fn from_rule(rule: &MasteryRule) -> Result<Self, NotComputable> {
        match *rule {
            MasteryRule::Passes { passes, of } => Ok(Self::Passes { passes, of }),
            MasteryRule::Cusum { within, p0, p1, alpha, beta } => {
                CurveRule::new(CusumParams { p0, p1, alpha, beta }, within).map(Self::Curve)
            }
        }
    }

    /// Evaluates attempts in order of time, `true` for a pass; returns the progress and, if the
    /// rule is a curve, the curve. Void attempts must be left out.
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

/// Evaluates a curve: mastered while it declares competence. Once declared, the next exercise stays
/// unlocked, as with passes.
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

/// Evaluates passes: mastered by the first attempt that completes `needed` passes among `of`
/// consecutive ones. Mastery is never revoked: later failures are shown as a decline, and an
/// unlocked exercise stays unlocked.
fn master_by_passes(passed: &[bool], needed: u32, of: u32) -> Reached {
    let of = of as usize;
    let completes = |by: &usize| count_passes(&passed[(by + 1).saturating_sub(of)..=*by]) >= needed;
    let open = || Reached::Open { passes: count_passes(&passed[passed.len().saturating_sub(of)..]) };
    (0..passed.len()).find(completes).map_or_else(open, |by| Reached::Mastered { by })
}
