//! Metrics, rubrics and scores, computed from the recording alone; identical on the client and the
//! server.
//!
//! [`assess`] is a pure function of a recording and an exercise. [`catalogue::DEFINITIONS`] defines
//! every metric.
//!
//! # Metrics without a value
//!
//! Outside its domain a metric has no value but a reason. On a rubric line
//! - an attempt that never touched the skin earns nothing on any line, not even for its time;
//!   neither does one that does not meet the exercise's requirements (`[required]`: reached,
//!   within, confirmed, withdrawn), which also fails;
//! - if the exercise has that table, a layer that was not reached and a boundary that was not
//!   opened earn nothing;
//! - if it has no such table, as in older documents, a layer that was not reached, or a boundary
//!   that was not opened by a needle that did enter the body, costs nothing: there was no force, no
//!   rupture and no advance to penalise. Insufficient depth is penalised by the depth metrics;
//! - every other missing value (no ledger, too short a recording, a needle that never stopped)
//!   earns nothing.
//!
//! A hard fail requires a value above its limit, so a metric without a value triggers none.
//!
//! # Versions
//!
//! A changed definition is added as a second version. Every version of every metric is computed for
//! every attempt, so that an old rubric is evaluated as before: a line without a version uses the
//! first. Another rubric applies only if the attempt is graded again.
//!
//! # Rates
//!
//! Values derived from speed are computed on a uniform 250 Hz grid starting at the first sample,
//! low-passed forwards and backwards: at 20 Hz, and in the second versions, which measure the
//! intended motion without tremor, at 4 Hz. Lengths, forces and times without a derivative are
//! computed from the samples directly; a peak before a rupture takes its force from the rupture's
//! event. Recordings at 1 kHz and 250 Hz therefore agree within 1 %, times within a tick. If the
//! slower samples fall between the grid's points, the peak force rate agrees within 2.5 % and the
//! number of translational actions within a tenth.

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
pub use required::{DepthMiss, UnmetRequirement};
pub use review::review_rubric;
pub use rubric::suffices;
pub use score::{Assessment, Damage, RubricRef, assess, judge, judge_without_requirements};
pub use staging::Staging;
pub use tryout::Tryout;
pub use void::{Void, VoidAnswer};
pub use worth::appraise_rubric;
