//! Writing and publishing documents.

pub mod drafts;
pub mod exercises;
pub mod pictures;
