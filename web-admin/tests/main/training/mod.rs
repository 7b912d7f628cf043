//! Courses, assignments and progress.

pub(crate) mod assignments;
pub(crate) mod badges;
pub(crate) mod calendar_feeds;
pub(crate) mod certificates;
pub(crate) mod cohorts;
pub(crate) mod learning_records;
pub(crate) mod membership;
pub(crate) mod outcomes;
pub(crate) mod papers;
pub(crate) mod progress;
pub(crate) mod replaced_exercises;
pub(crate) mod risks;
pub(crate) mod terms;
