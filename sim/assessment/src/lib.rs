//! Metrics, rubrics and scores, computed from the recording alone; the same on the client and the server.

pub mod catalogue;
pub mod score;

pub use catalogue::{Direction, Metric};
pub use score::{Assessment, Deduction, assess};
