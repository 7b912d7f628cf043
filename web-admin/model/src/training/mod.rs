//! Courses, assignments and progress.

pub mod assignment;
pub mod badge;
pub mod calendar;
pub mod certificate;
pub mod certificate_note;
pub mod cohort;
pub mod comment;
pub mod due;
pub mod learning_records;
pub mod membership;
pub mod outcome;
pub mod progress;
#[cfg(test)]
mod random_numbers;
pub mod risk;
pub mod signatory;
pub mod support_note;
pub mod term;
pub mod xapi;
