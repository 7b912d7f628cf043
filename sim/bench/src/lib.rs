//! Measurements: description of the machine, timing, and, with the feature `reports`, the reports
//! of `stylet bench`.

mod clock;
#[cfg(feature = "reports")]
pub mod error;
pub mod machine;
#[cfg(feature = "reports")]
mod progress;
#[cfg(feature = "reports")]
pub mod report;
pub mod timing;
