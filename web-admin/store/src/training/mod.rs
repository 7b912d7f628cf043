//! Courses, assignments and progress.

pub mod assignments;
pub mod badges;
pub mod calendar_feeds;
pub mod cohorts;
pub mod comments;
pub mod curricula;
pub mod deadlines;
pub mod learning_records;
pub mod outcomes;
pub mod practice;
pub mod reports;
pub mod risks;
pub mod support_notes;
pub mod tallies;
pub mod terms;
