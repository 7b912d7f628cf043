//! An exercise: what to do in a scene and how it is judged.

use data_encoding::HEXLOWER;
use law::operator::Plan;
use law::{Incidence, Skin};
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::feedback::Feedback;
use crate::planned::PlannedNeedle;
use crate::wording::Wording;

/// One line of a rubric: 100 % at `full`, 0 % at `zero`, linear between, clamped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RubricLine {
    /// Metric id, for example `depth_error_mm`.
    pub metric: String,
    /// Version of the metric's definition; 1 if the document does not give one.
    #[serde(default = "first", skip_serializing_if = "is_first")]
    pub version: u32,
    /// Value that earns full marks, in the metric's unit. For a range metric, the distance from 0.
    pub full: f64,
    /// Value that earns no marks.
    pub zero: f64,
    /// Relative weight, > 0.
    pub weight: f64,
}

/// A limit that fails the attempt regardless of the score.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HardFail {
    /// Metric id, for example `structure_hits.vessel` or `peak_force_n`.
    pub metric: String,
    /// Version of the metric's definition; 1 if the document does not give one.
    #[serde(default = "first", skip_serializing_if = "is_first")]
    pub version: u32,
    /// The attempt fails if the value exceeds this limit.
    pub above: f64,
    /// Message shown to the trainee. Its text in the document's own language is part of the
    /// judgement.
    #[serde(serialize_with = "Wording::serialize_own")]
    pub why: Wording,
}

/// The default version. Documents without a version were written when each metric had only one;
/// their bytes must keep their meaning.
const fn first() -> u32 {
    1
}

/// Takes a reference because serde's `skip_serializing_if` requires one.
const fn is_first(version: &u32) -> bool {
    *version == first()
}

/// Conditions that an attempt must meet to earn any marks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Required {
    /// Layer whose upper boundary the tip must have opened.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reached: Option<String>,
    /// Maximum distance between the depth at confirm and the target depth, in mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within_mm: Option<f64>,
    /// Whether the position must have been confirmed with the tip in the body.
    pub confirmed: bool,
    /// Whether the needle must have left the body by the end.
    pub withdrawn: bool,
}

/// A C-arm, as it stands at the start.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct FluoroscopySettings {
    /// Orbital angle at the start, in degrees; positive turns the detector to the patient's right.
    pub orbital_deg: f64,
    /// Tilt at the start, in degrees; positive turns the detector to the head.
    pub tilt_deg: f64,
    /// Edge of the collimated square field at the detector at the start, in mm.
    pub field_mm: f64,
    /// Pulses per second while the pedal is pressed.
    pub pulses_per_s: f64,
}

/// A declarative coaching rule.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct CoachingRule {
    /// Live quantity: `depth_mm`, `force_n`, `speed_mm_per_s`, `angle_error_deg`, `fluoroscopy_time_s` or `kerma_mgy`.
    pub quantity: String,
    /// The message is triggered when the quantity rises above this value.
    pub above: f64,
    /// The rule is re-armed when the quantity falls below this value.
    pub rearm_below: f64,
    /// The message.
    pub message: Wording,
}

/// A picture that the briefing shows.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct ExercisePicture {
    /// Name of the file next to the document.
    pub file: String,
    /// Alternative text.
    pub alt: Wording,
    /// Caption shown below the picture.
    #[serde(default)]
    pub caption: Option<Wording>,
}

/// A checked exercise.
#[derive(Clone, Debug, PartialEq)]
pub struct Exercise {
    /// Identifier.
    pub id: String,
    /// Title shown to people.
    pub title: Wording,
    /// Briefing shown before the attempt.
    pub briefing: Wording,
    /// Path of the scene document, relative to this document, as written.
    pub scene: String,
    /// Planned entry on the skin, patient frame, in mm.
    pub entry_mm: [f64; 2],
    /// The scene's skin as used by the force law; flat until the scene has been read.
    pub skin_shape: Skin,
    /// Planned angle to the surface normal, in degrees, 0 ≤ θ ≤ 60.
    pub angle_deg: f64,
    /// Direction the needle leans towards, from patient +x to +y, in degrees.
    pub azimuth_deg: f64,
    /// Target depth along the axis, in mm.
    pub target_depth_mm: f64,
    /// Time limit, in s.
    pub time_limit_s: f64,
    /// Feedback given to the trainee.
    pub feedback: Feedback,
    /// The C-arm, if the exercise has one.
    pub fluoroscopy: Option<FluoroscopySettings>,
    /// Conditions for earning any marks; if present, a boundary that was never opened earns
    /// nothing. Absent in documents without the table, which are scored by the rules that applied
    /// before the table existed.
    pub required: Option<Required>,
    /// Rubric; at least one line.
    pub rubric: Vec<RubricLine>,
    /// Hard fails.
    pub hard_fails: Vec<HardFail>,
    /// Score needed to pass, 0–100.
    pub pass_mark: f64,
    /// Coaching rules.
    pub coaching: Vec<CoachingRule>,
    /// Pictures that the briefing shows, in order. They do not affect the score.
    pub pictures: Vec<ExercisePicture>,
    /// Difficulty, 1–5.
    pub difficulty: u8,
    /// Lower-case hexadecimal SHA-256 of the document's bytes.
    pub sha256: String,
}

impl Exercise {
    /// Returns the planned direction into the body, unit length, patient frame.
    ///
    /// The tip moves towards the azimuth: at azimuth 0 an oblique needle advances towards +x while
    /// its hub leans to −x.
    #[must_use]
    pub fn axis(&self) -> Vector3<f64> {
        self.planned_needle().axis(&self.skin_shape)
    }

    /// Returns the planned incidence on the layers.
    #[must_use]
    pub fn incidence(&self) -> Incidence {
        self.planned_needle().incidence(&self.skin_shape)
    }

    /// Returns the planned entry, angle and azimuth.
    #[must_use]
    pub fn planned_needle(&self) -> PlannedNeedle {
        let Self { entry_mm, angle_deg, azimuth_deg, .. } = *self;
        PlannedNeedle { entry_mm, angle_deg, azimuth_deg }
    }

    /// Transforms a point to the frame of the planned entry, in m: along the skin in the direction
    /// of the lean, along the skin to the left of it, and out of the body.
    #[must_use]
    pub fn seen_from_entry_m(&self, place_m: &Point3<f64>) -> Point3<f64> {
        self.planned_needle().seen_from_entry_m(&self.skin_shape, place_m)
    }

    /// Returns the planned entry, in m, patient frame.
    #[must_use]
    pub fn entry_m(&self) -> Point3<f64> {
        self.planned_needle().entry_m(&self.skin_shape)
    }

    /// Returns the planned position of the tip at the target, in m, patient frame.
    #[must_use]
    pub fn target_m(&self) -> Point3<f64> {
        self.entry_m() + self.axis() * (self.target_depth_mm * 1e-3)
    }

    /// Returns the plan of a virtual operator: from 10 mm above the skin to the target, a hold of 2
    /// s, and withdrawal.
    #[must_use]
    pub fn plan(&self) -> Plan {
        Plan {
            entry_m: self.entry_m(),
            skin: self.skin_shape,
            axis: self.axis(),
            target_x_m: self.target_depth_mm * 1e-3,
            approach_m: 0.010,
            hold_s: 2.0,
            // The needle's length belongs to the scene; `ExerciseBundle::plan` sets it.
            reach_m: f64::INFINITY,
        }
    }

    /// Takes rubric, hard fails, pass mark and required conditions from another exercise; the task
    /// itself is unchanged.
    pub fn judge_by(&mut self, other: &Self) {
        self.required.clone_from(&other.required);
        self.rubric.clone_from(&other.rubric);
        self.hard_fails.clone_from(&other.hard_fails);
        self.pass_mark = other.pass_mark;
    }

    /// Returns the lower-case hexadecimal SHA-256 of the rubric in canonical form: only lines, hard
    /// fails, pass mark and required conditions.
    ///
    /// Canonical form: compact JSON with its keys in the order of [`Judgement`]'s fields, every
    /// number in the shortest form that parses to the same f64. A version of 1, an absent
    /// `[required]` and the translations of a hard fail's message are omitted. A comment, a
    /// briefing or another order of keys does not change the hash.
    #[must_use]
    pub fn rubric_sha256(&self) -> String {
        let judgement = Judgement {
            rubric: &self.rubric,
            hard_fail: &self.hard_fails,
            pass_mark: self.pass_mark,
            required: self.required.as_ref(),
        };
        // Cannot fail: a judgement holds only text and numbers under text keys.
        HEXLOWER.encode(&Sha256::digest(serde_json::to_vec(&judgement).unwrap_or_default()))
    }
}

/// The fields that decide a score, in canonical order.
#[derive(Serialize)]
struct Judgement<'e> {
    rubric: &'e [RubricLine],
    hard_fail: &'e [HardFail],
    pass_mark: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    required: Option<&'e Required>,
}
