//! Scores and reviews.

pub mod exam_files;
pub mod exams;
pub mod grades;
pub mod jobs;
pub mod ratings;
pub mod regradings;
pub mod reviews;
pub mod scores;
pub mod segments;
pub mod supervisions;
