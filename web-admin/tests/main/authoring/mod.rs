//! Writing and publishing documents.

pub(crate) mod draft_forms;
pub(crate) mod draft_instruments;
pub(crate) mod drafts;
pub(crate) mod pictures;
pub(crate) mod previews;
pub(crate) mod publishing;
