//! The learning status after each attempt: not yet competent, competent, or regressing.

use super::{Crossing, Cusum, CusumParams, LcCusum, LcCusumParams};
use crate::statistics::NotComputable;

/// The learning status of a trainee.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// Competence has not been demonstrated.
    NotYet,
    /// Competence was demonstrated, and no decline was detected since.
    Competent,
    /// Competence was demonstrated, but there were too many failures since.
    Regressing,
}

/// A rule with its limits: a CUSUM alone, or an LC-CUSUM that declares competence and a CUSUM that
/// monitors it afterwards.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Rule {
    /// Declares competence; if absent, the CUSUM's lower limit does.
    pub learning: Option<LcCusum>,
    /// Monitors competence.
    pub monitor: Cusum,
}

impl Rule {
    /// Builds a rule; with `within` attempts it uses an LC-CUSUM with δ = p1 − p0 and the
    /// probability `alpha`.
    ///
    /// # Errors
    /// If a parameter is out of range, or if no limit is rare enough.
    pub fn new(params: &CusumParams, within: Option<u32>) -> Result<Self, NotComputable> {
        let CusumParams { p0, p1, alpha, .. } = *params;
        let learning =
            within.map(|within| LcCusum::new(&LcCusumParams { p0, delta: p1 - p0, within, probability: alpha }));
        Ok(Self { learning: learning.transpose()?, monitor: Cusum::new(params)? })
    }
}

/// A curve after an attempt.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LearningPoint {
    /// S of the LC-CUSUM while `learning`, else the count of the CUSUM.
    pub value: f64,
    /// Whether the LC-CUSUM was active.
    pub learning: bool,
    /// The limit that this attempt crossed; the next attempt starts from 0.
    pub crossed: Option<Crossing>,
    /// Status after the attempt.
    pub standing: Standing,
}

/// A curve and the current status.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct LearningCurve {
    /// One point for each attempt.
    pub points: Vec<LearningPoint>,
    /// Current status.
    pub standing: Standing,
    /// Number of consecutive successes until competence is declared; 0 if it is declared already.
    pub successes_needed: u32,
    /// The first attempt after which competence was declared, from 0.
    pub competent_at: Option<usize>,
}

/// State of a curve between two attempts.
struct State {
    value: f64,
    learning: bool,
    standing: Standing,
}

/// Computes the curve of attempts in order of time; `true` is a failure.
///
/// After a regression an LC-CUSUM restarts at 0: competence must be demonstrated again.
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
