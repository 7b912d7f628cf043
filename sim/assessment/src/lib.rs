//! Metrics, rubrics and scores, computed from the recording alone; the same on the client and the server.
//!
//! [`assess`] is a pure function of a recording and an exercise. [`catalogue::DEFINITIONS`] is what every metric means.
//!
//! # What is not applicable
//!
//! Outside its domain a metric has no value, and says why. On a rubric line
//! - an attempt that never reached the skin earns nothing on any line, not even for its time; nor does one that lacks what the
//!   exercise requires (`[required]`: reached, within, confirmed, withdrawn), which also fails;
//! - where the exercise has that table, a layer that was not reached and a boundary that was not opened earn nothing;
//! - where it has none, as none had once, a layer that was not reached, or a boundary that was not opened by a needle that did go through the skin, costs
//!   nothing: there was no force, no rupture, no advance to mark down. Whether the needle should have gone there is for
//!   the depth to judge;
//! - whatever else cannot be told (no ledger, too short a recording, a needle that never stopped) earns nothing.
//!
//! A hard fail needs a value above its limit, so a metric without one breaks none.
//!
//! # Versions
//!
//! A changed definition is a second version beside the first. Every version of every metric is computed for every attempt, so that
//! a rubric of before is judged as before: a line without a version means the first. Another rubric decides only when somebody
//! grades again.
//!
//! # Rates
//!
//! Whatever is derived from speed is computed on an even 250 Hz grid from the first sample on, low-passed at 20 Hz
//! forwards and backwards; what was meant rather than trembled, in the second versions, at 4 Hz. Lengths, forces and times without a derivative are read from the samples as they are; a peak
//! before a rupture takes its force from the rupture's own event. Recordings at 1 kHz and 250 Hz so agree within 1 %,
//! times within a tick. Where the slower samples fall between the grid's points, the peak force rate agrees within 2.5 %
//! and the number of translational actions within a tenth.

mod absent;
pub mod attached;
mod attempt;
pub mod catalogue;
mod cause;
mod coach;
mod distance;
mod error;
pub mod learning;
mod metrics;
mod motion;
pub mod questionnaire;
mod required;
mod review;
mod rubric;
pub mod score;
mod signal;
mod sparc;
pub mod staging;
pub mod statistics;
mod tryout;
pub mod void;
mod worth;

pub use absent::Absent;
pub use attached::{attachments, find_needless_attachment, own_exercise, verify_own};
pub use catalogue::{Definition, Direction, Metric};
pub use cause::{Deduction, DeductionCause, FailureCause, HardFailure, words};
pub use coach::Coach;
pub use error::AssessError;
pub use required::UnmetRequirement;
pub use review::review_rubric;
pub use rubric::suffices;
pub use score::{Assessment, Damage, RubricRef, assess, judge};
pub use staging::Staging;
pub use tryout::Tryout;
pub use void::{Void, VoidAnswer};
pub use worth::appraise_rubric;
