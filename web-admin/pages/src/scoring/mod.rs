//! Scores and reviews.

pub mod exam_files;
pub mod exams;
pub mod experts;
pub mod judgement;
pub mod moments;
pub mod rating;
pub mod regrading;
pub mod replay_events;
pub mod review;
pub mod segments;
