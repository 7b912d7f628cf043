//! Metrics, rubrics and scores, computed from the recording alone; the same on the client and the server.
//!
//! [`assess`] is a pure function of a recording and an exercise. [`catalogue::DEFINITIONS`] is what every metric means.

mod attempt;
pub mod catalogue;
mod distance;
mod metrics;
mod motion;
mod rubric;
pub mod score;
mod signal;
mod words;

pub use catalogue::{Definition, Direction, Metric};
pub use score::{AssessError, Assessment, Damage, Deduction, RubricRef, assess, own_exercise};
