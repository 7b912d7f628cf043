//! Judges metrics: score, deductions and failures.

use documents::{Exercise, ExerciseBundle, Required};
use recording::Recording;
use serde::{Deserialize, Serialize};

use crate::attempt::Attempt;
use crate::catalogue::{Metric, first_version};
use crate::cause::{Deduction, FailureCause, HardFailure};
use crate::error::AssessError;
use crate::void::{self};
use crate::{metrics, rubric};

/// The rubric used.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RubricRef {
    /// Exercise id.
    pub id: String,
    /// SHA-256 of the rubric.
    pub sha256: String,
}

/// The judgement of one attempt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Assessment {
    /// Score, 0–100.
    pub score: f64,
    /// Whether the score is at or above the pass mark without a hard fail.
    pub passed: bool,
    /// Every version of every metric of the catalogue.
    pub metrics: Vec<Metric>,
    /// Points lost per rubric line.
    pub deductions: Vec<Deduction>,
    /// Reasons for failing regardless of the score: requirements that were not met, and limits that
    /// were exceeded.
    pub hard_fails: Vec<HardFailure>,
    /// The rubric.
    pub rubric: RubricRef,
    /// Version of the simulator that recorded the attempt.
    pub simulator_version: String,
}

/// Damage to tissue, by part. A part that does not apply to the attempt is absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Damage {
    /// Energy dissipated by ruptures, in mJ.
    pub rupture_mj: Option<f64>,
    /// Energy spent on cutting, in mJ.
    pub cutting_mj: Option<f64>,
    /// Lateral work, in mJ.
    pub lateral_mj: Option<f64>,
    /// Area swept sideways inside tissue, in mm².
    pub sweep_mm2: Option<f64>,
    /// Puncture tracks: number of times the tip went through intact skin.
    pub tracks: Option<f64>,
    /// Number of hits of structures other than targets.
    pub structures_hit: Option<f64>,
}

impl Assessment {
    /// Returns the value of a metric by its first definition, in its unit; `None` if it does not
    /// apply or does not exist in this attempt.
    #[must_use]
    pub fn value(&self, metric_id: &str) -> Option<f64> {
        self.value_of(metric_id, first_version())
    }

    /// Returns the value of a metric by a version of its definition, as [`Self::value`].
    #[must_use]
    pub fn value_of(&self, metric_id: &str, version: u32) -> Option<f64> {
        self.metrics.iter().find(|m| m.id == metric_id && m.version == version).and_then(|m| m.value)
    }

    /// Returns the damage to tissue, by part and never as a single index.
    #[must_use]
    pub fn damage(&self) -> Damage {
        Damage {
            rupture_mj: self.value("rupture_energy_mj"),
            cutting_mj: self.value("cutting_energy_mj"),
            lateral_mj: self.value("lateral_work_mj"),
            sweep_mm2: self.value("sweep_area_mm2"),
            tracks: self.value("skin_entries"),
            structures_hit: self.value("structure_hits"),
        }
    }
}

/// Judges an attempt by an exercise, either the recording's own or another. The same recording and
/// exercise always yield the same assessment.
///
/// # Errors
/// If the attempt is void, or if recording or exercise cannot be used.
pub fn assess(recording: &Recording, bundle: &ExerciseBundle) -> Result<Assessment, AssessError> {
    if let Some(why) = void::find_void_reason(recording) {
        return Err(AssessError::Void(why));
    }
    let metrics = metrics::measure_attempt(&Attempt::new(recording, bundle)?);
    judge(metrics, &bundle.exercise, &recording.session.simulator_version)
}

/// Judges a failed attempt again as if nothing were required. `None` if it meets every requirement,
/// or the rubric cannot be used.
#[must_use]
pub fn judge_without_requirements(
    metrics: &[Metric],
    hard_fails: &[HardFailure],
    exercise: &Exercise,
) -> Option<Assessment> {
    let is_requirement = |failure: &HardFailure| matches!(failure.cause, FailureCause::Required { .. });
    let ungated = || Exercise { required: Some(Required::default()), ..exercise.clone() };
    let lacks = hard_fails.iter().any(is_requirement);
    lacks.then(|| judge(metrics.to_vec(), &ungated(), "").ok()).flatten()
}

/// Judges the metrics of an attempt by the rubric of an exercise. A metric that the rubric uses and
/// `metrics` lacks is treated as missing in the scene; check with [`suffices`](crate::suffices)
/// first.
///
/// # Errors
/// If the rubric cannot be used.
pub fn judge(metrics: Vec<Metric>, exercise: &Exercise, simulator_version: &str) -> Result<Assessment, AssessError> {
    let deductions = rubric::find_deductions(exercise, &metrics)?;
    let hard_fails = rubric::find_failures(exercise, &metrics);
    let score = (100.0 - deductions.iter().map(|d| d.points).sum::<f64>()).clamp(0.0, 100.0);
    Ok(Assessment {
        score,
        // Tolerance for rounding: a score equal to the pass mark passes.
        passed: hard_fails.is_empty() && score >= exercise.pass_mark - 1e-9,
        metrics,
        deductions,
        hard_fails,
        rubric: RubricRef { id: exercise.id.clone(), sha256: exercise.rubric_sha256() },
        simulator_version: simulator_version.to_owned(),
    })
}
