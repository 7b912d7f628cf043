//! Writing and publishing documents.

pub mod diff;
pub mod document_forms;
pub mod draft;
pub mod exercise;
pub mod measured;
pub mod pictures;
pub mod revisions;
