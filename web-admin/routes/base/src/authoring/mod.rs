//! Writing and publishing documents.

pub mod exercises;
pub mod pictures;
