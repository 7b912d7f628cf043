//! When an exercise counts as mastered.

use std::sync::LazyLock;

use assessment::learning::{self, Curve, CusumParams, Standing};
use assessment::statistics::NotComputable;
use scene::MasteryRule;
use serde::{Deserialize, Serialize};

use super::{Attempt, StepState};

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

/// A learning curve as a rule: what the course states, and the lines that follow from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurveRule {
    /// Rates and errors as the course states them.
    pub params: CusumParams,
    /// Attempts within which the error of an LC-CUSUM holds; absent for a CUSUM.
    pub within: Option<u32>,
    /// Weights and lines.
    pub rule: learning::Rule,
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
        Ok(Self { params, within, rule: learning::Rule::new(&params, within)? })
    }

    /// An example, for a course that states no rates: it tells and decides nothing.
    #[must_use]
    pub fn example() -> Option<Self> {
        *EXAMPLE
    }

    /// The curve over attempts in order of time.
    #[must_use]
    pub fn over(&self, attempts: &[Attempt]) -> Curve {
        let failures: Vec<bool> = attempts.iter().map(|a| !a.passed).collect();
        learning::curve(&self.rule, &failures)
    }
}

impl Mastery {
    /// A course's rule. The limit of an LC-CUSUM takes its time, so this is done once, when the course is published.
    ///
    /// # Errors
    /// When no limit is rare enough for the stated error, or the parameters have no meaning.
    pub fn of(rule: &MasteryRule) -> Result<Self, NotComputable> {
        match *rule {
            MasteryRule::Passes { passes, of } => Ok(Self::Passes { passes, of }),
            MasteryRule::Cusum { within, p0, p1, alpha, beta } => {
                CurveRule::new(CusumParams { p0, p1, alpha, beta }, within).map(Self::Curve)
            }
        }
    }

    /// How far attempts in order of time have come, and the curve where the rule is one.
    pub(super) fn judge(&self, attempts: &[Attempt]) -> (StepState, Option<Curve>) {
        match self {
            Self::Passes { passes, of } => (by_passes(attempts, *passes, *of), None),
            Self::Curve(curve) => by_curve(attempts, curve),
        }
    }
}

/// Mastered while the curve says competent. What a curve has declared opens the next exercise for good, as with passes.
fn by_curve(attempts: &[Attempt], rule: &CurveRule) -> (StepState, Option<Curve>) {
    let curve = rule.over(attempts);
    let lost = || curve.points.iter().rposition(|p| p.standing == Standing::Competent).map_or(0, |last| last + 1);
    let state = match (curve.standing, curve.competent_at) {
        (Standing::Competent, Some(at)) => StepState::Mastered { on: attempts[at].at },
        (Standing::Regressing, Some(at)) => StepState::Regressing { on: attempts[at].at, since: attempts[lost()].at },
        _ => StepState::Open { passes: passes(attempts) },
    };
    (state, Some(curve))
}

fn passes(attempts: &[Attempt]) -> u32 {
    u32::try_from(attempts.iter().filter(|a| a.passed).count()).unwrap_or(u32::MAX)
}

/// Mastered by the first attempt that completes `passes` among `of` in a row. Once reached it stays: what comes after
/// shows as a decline, and an exercise that opened another is not closed again under a trainee's hands.
fn by_passes(attempts: &[Attempt], needed: u32, of: u32) -> StepState {
    let of = usize::try_from(of).unwrap_or(usize::MAX);
    for end in 1..=attempts.len() {
        if passes(&attempts[end.saturating_sub(of)..end]) >= needed {
            return StepState::Mastered { on: attempts[end - 1].at };
        }
    }
    StepState::Open { passes: passes(&attempts[attempts.len().saturating_sub(of)..]) }
}
