//! Competent, not yet, regressing: what a learning curve says after each attempt.

use super::{Crossing, Cusum, CusumParams, LcCusum, LcCusumParams};
use crate::statistics::NotComputable;

/// What a curve says about a trainee.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// Competence has not been shown.
    NotYet,
    /// Competence was shown and nothing speaks against it.
    Competent,
    /// Competence was shown, and failures have become too many since.
    Regressing,
}

/// A rule ready to judge: a CUSUM alone, or an LC-CUSUM that declares competence and a CUSUM that watches it afterwards.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Rule {
    /// Declares competence; absent: the CUSUM's lower line does.
    pub learning: Option<LcCusum>,
    /// Watches it.
    pub monitor: Cusum,
}

impl Rule {
    /// Builds a rule; with `within` attempts it is an LC-CUSUM of δ = p1 − p0 whose stated probability is `alpha`.
    ///
    /// # Errors
    /// When a parameter is out of range, or no limit is rare enough.
    pub fn new(params: &CusumParams, within: Option<u32>) -> Result<Self, NotComputable> {
        let CusumParams { p0, p1, alpha, .. } = *params;
        let learning =
            within.map(|within| LcCusum::new(&LcCusumParams { p0, delta: p1 - p0, within, probability: alpha }));
        Ok(Self { learning: learning.transpose()?, monitor: Cusum::new(params)? })
    }
}

/// A curve after one attempt.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LearningPoint {
    /// S of the LC-CUSUM while `learning`, else the count of the CUSUM.
    pub value: f64,
    /// The LC-CUSUM was in charge.
    pub learning: bool,
    /// This attempt crossed a line; the next one starts from 0.
    pub crossed: Option<Crossing>,
    /// What the curve says after it.
    pub standing: Standing,
}

/// A whole curve and what it says now.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct LearningCurve {
    /// One point an attempt.
    pub points: Vec<LearningPoint>,
    /// What it says now.
    pub standing: Standing,
    /// More straight successes until it says competent; 0 when it does.
    pub successes_needed: u32,
    /// The first attempt after which it said competent, from 0.
    pub competent_at: Option<usize>,
}

/// Where a curve is between two attempts.
struct State {
    value: f64,
    learning: bool,
    standing: Standing,
}

/// The curve of attempts in order of time; `true` is a failure.
///
/// After a regression an LC-CUSUM learns anew from 0: competence has to be shown again.
#[must_use]
pub fn learning_curve(rule: &Rule, failures: &[bool]) -> LearningCurve {
    let mut state = State { value: 0.0, learning: rule.learning.is_some(), standing: Standing::NotYet };
    let points: Vec<LearningPoint> = failures.iter().map(|failed| step_curve(rule, &mut state, *failed)).collect();
    let successes_needed = match (state.standing, rule.learning) {
        (Standing::Competent, _) => 0,
        (_, Some(learning)) => learning.successes_needed(state.value),
        (_, None) => rule.monitor.successes_needed(state.value),
    };
    let competent_at = points.iter().position(|p| p.standing == Standing::Competent);
    LearningCurve { points, standing: state.standing, successes_needed, competent_at }
}

fn step_curve(rule: &Rule, state: &mut State, failed: bool) -> LearningPoint {
    let learning = state.learning;
    let (value, crossed) = match rule.learning {
        Some(lc) if learning => {
            let s = lc.step(state.value, failed);
            (s, lc.competent(s).then_some(Crossing::Acceptable))
        }
        _ => {
            let point = rule.monitor.step(state.value, failed);
            (point.count, point.crossed)
        }
    };
    state.value = if crossed.is_some() { 0.0 } else { value };
    state.standing = match (state.standing, crossed) {
        (_, Some(Crossing::Acceptable)) => Standing::Competent,
        (Standing::Competent, Some(Crossing::Unacceptable)) => Standing::Regressing,
        (before, _) => before,
    };
    state.learning = rule.learning.is_some() && state.standing != Standing::Competent;
    LearningPoint { value, learning, crossed, standing: state.standing }
}
