//! The exam files of an attempt, on its page.

use model::ids::{ExamFileId, SessionId};
use time::OffsetDateTime;

/// The exam files of an attempt, for people who may freeze it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExamFiles {
    /// The attempt.
    pub session: SessionId,
    /// Whether it is scored, so that it can be frozen.
    pub is_scored: bool,
    /// The files, oldest first.
    pub files: Vec<ExamFileRow>,
}

impl ExamFiles {
    /// Returns the address of the form, and the start of those of the files.
    #[must_use]
    pub fn href(&self) -> String {
        format!("/sessions/{}/exam-files", self.session)
    }
}

/// An exam file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExamFileRow {
    /// Id.
    pub id: ExamFileId,
    /// Name of the person who froze the attempt.
    pub by: String,
    /// Time of freezing.
    pub at: OffsetDateTime,
    /// Length, in bytes.
    pub bytes: i64,
    /// SHA-256 of the file.
    pub sha256: String,
    /// The content was erased with its person.
    pub is_erased: bool,
}
