//! Courses, assignments and progress.

pub mod assignments;
pub mod badges;
pub mod calendar_feeds;
pub mod certificates;
pub mod cohorts;
pub mod comments;
pub mod course_changes;
pub mod deadlines;
pub mod grade_delivery;
pub mod learning_records;
pub mod outcomes;
pub mod risks;
pub mod terms;
