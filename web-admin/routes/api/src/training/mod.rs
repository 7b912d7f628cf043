//! Courses, assignments and progress.

pub(crate) mod documents;
