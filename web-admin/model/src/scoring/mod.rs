//! Scores and reviews.

pub mod corridor;
pub mod exam;
pub mod exam_file;
pub mod expert_comparison;
pub mod judgement;
pub mod rating;
pub mod regrading;
pub mod review;
pub mod segments;
