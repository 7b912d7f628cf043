//! Scores and reviews.

pub(crate) mod ratings;
pub(crate) mod score;
