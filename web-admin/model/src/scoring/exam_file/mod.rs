//! Exam files: an attempt with its documents, scores, proofs and ratings as one signed tar.
//!
//! The manifest lists every other entry with its length and SHA-256; a signature over its text
//! follows it. `docs/certificates.md` specifies the format for other programs.

mod archive;
#[cfg(test)]
mod tests;

pub use archive::{ExamRecording, check, write_head, write_tail};
use serde::{Deserialize, Serialize};

use crate::recordings::proof::Proof;

/// Name of the first entry.
pub const MANIFEST: &str = "manifest.json";
/// Name of the second entry.
pub const SIGNATURE: &str = "signature.json";
/// Name of the last entry.
pub const RECORDING: &str = "recording.mcap";

/// The signed statement of an exam file. All of it is data or English, because programs read it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExamManifest {
    /// [`ExamManifest::KIND`].
    pub kind: String,
    /// Version of the format.
    pub format: u32,
    /// Id of the exam file.
    pub id: String,
    /// Name of the school.
    pub school: String,
    /// The person who made the attempt.
    pub person: ExaminedPerson,
    /// The attempt.
    pub attempt: ExaminedAttempt,
    /// The grade that counted.
    pub grade: ExamGrade,
    /// Proofs of the attempt.
    pub proof: ExamProof,
    /// Courses that contain the exercise, and whether they were mastered.
    pub courses: Vec<ExamCourse>,
    /// Name of the person who froze the attempt.
    pub frozen_by: String,
    /// Time of freezing, RFC 3339.
    pub frozen_at: String,
    /// Limits of the statement.
    pub scope: String,
    /// All entries after the signature, in order.
    pub entries: Vec<ExamEntry>,
}

impl ExamManifest {
    /// Marks a manifest.
    pub const KIND: &str = "stylet-exam-file";
    /// The version that is written today.
    pub const FORMAT: u32 = 1;
}

/// The person who made an attempt.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExaminedPerson {
    /// Name.
    pub name: String,
    /// Number at the school's registrar, if known.
    pub registrar_id: Option<String>,
    /// Pseudonym, which the recording contains.
    pub pseudonym: String,
}

/// An attempt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExaminedAttempt {
    /// Id.
    pub id: String,
    /// Id of the exercise.
    pub exercise_id: String,
    /// Title of the exercise.
    pub exercise: String,
    /// SHA-256 of the exercise document: its revision.
    pub exercise_sha256: String,
    /// SHA-256 of the scene document.
    pub scene_sha256: String,
    /// Whether the school published this revision.
    pub published: bool,
    /// Start, RFC 3339.
    pub started_at: String,
    /// Time at which the service received it, RFC 3339.
    pub received_at: String,
    /// Duration, in s.
    pub duration_s: f64,
}

/// A grade.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExamGrade {
    /// Score, 0–100.
    pub score: f64,
    /// Whether the attempt is passed.
    pub passed: bool,
    /// Whether a person has overridden the computed score.
    pub overridden: bool,
    /// SHA-256 of the rubric of the computed score.
    pub rubric_sha256: String,
}

/// Proofs of an attempt, and whether it counts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExamProof {
    /// A paired station has signed the recording, and its re-simulation is identical.
    pub signed: bool,
    /// The re-simulation is identical.
    pub resimulated: bool,
    /// A person has confirmed supervision.
    pub supervised: bool,
    /// The attempts that the school accepts for certificates, as text.
    pub needed: String,
    /// Whether this attempt counts for mastery: it has the proofs that the school needs, and no
    /// reason speaks against it.
    pub counts: bool,
    /// Reason why it does not count, as the API names it.
    pub uncounted: Option<String>,
}

impl ExamProof {
    /// Describes the proofs of an attempt.
    #[must_use]
    pub fn new(proof: Proof, needed: &str, uncounted: Option<&str>, is_sufficient: bool) -> Self {
        let Proof { signed, resimulated, supervised } = proof;
        Self {
            signed,
            resimulated,
            supervised,
            needed: needed.to_owned(),
            counts: is_sufficient && uncounted.is_none(),
            uncounted: uncounted.map(str::to_owned),
        }
    }
}

/// A course that contains the exercise. Mastery refers to this revision.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExamCourse {
    /// Id.
    pub id: String,
    /// Title.
    pub title: String,
    /// SHA-256 of the course's document: the mastered revision, or else the current one.
    pub sha256: String,
    /// Mastery rule of this revision, as text.
    pub rule: String,
    /// Time since which the exercise is mastered by this rule, RFC 3339.
    pub exercise_mastered_at: Option<String>,
    /// Time since which the course is mastered, RFC 3339.
    pub course_mastered_at: Option<String>,
}

/// An entry of an exam file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExamEntry {
    /// Path.
    pub name: String,
    /// Length, in bytes.
    pub bytes: u64,
    /// SHA-256 of the content.
    pub sha256: String,
}
