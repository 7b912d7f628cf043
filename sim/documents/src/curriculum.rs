//! A curriculum: a course of exercises with prerequisites and a mastery rule.

use crate::wording::Wording;

/// When an exercise counts as mastered.
#[derive(Clone, Debug, PartialEq)]
pub enum MasteryRule {
    /// `passes` of the last `of` attempts.
    Passes {
        /// Required number of passes.
        passes: u32,
        /// Number of recent attempts considered.
        of: u32,
    },
    /// CUSUM or LC-CUSUM with its parameters.
    Cusum {
        /// LC-CUSUM: number of attempts within which `alpha` holds; absent for a CUSUM.
        within: Option<u32>,
        /// Acceptable failure rate.
        p0: f64,
        /// Unacceptable failure rate.
        p1: f64,
        /// Type I error.
        alpha: f64,
        /// Type II error.
        beta: f64,
    },
}

/// One exercise of a curriculum.
#[derive(Clone, Debug, PartialEq)]
pub struct CurriculumEntry {
    /// Path of the exercise document, relative to the course document.
    pub file: String,
    /// Exercise id.
    pub exercise: String,
    /// Ids of the exercises to master first.
    pub prerequisites: Vec<String>,
    /// Instrument shown after each attempt.
    pub survey: Option<String>,
}

/// A checked curriculum.
#[derive(Clone, Debug, PartialEq)]
pub struct Curriculum {
    /// Identifier.
    pub id: String,
    /// Title.
    pub title: Wording,
    /// Description of the course.
    pub description: Wording,
    /// Exercises in order.
    pub entries: Vec<CurriculumEntry>,
    /// Mastery rule.
    pub mastery: MasteryRule,
    /// Lower-case hexadecimal SHA-256 of the document's bytes.
    pub sha256: String,
}
