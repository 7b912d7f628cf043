//! Writing and publishing documents.

pub(crate) mod examining;
pub mod exercises;
pub mod pictures;
