//! Free texts by a person and about their attempts.

/// Numbers of free texts, by author.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TextCounts {
    /// Comments, reasons and answers by the person.
    pub written: i64,
    /// Texts by others about the person's attempts or consent.
    pub about: i64,
    /// Reasons about the person's attempts in the audit log, which cannot be changed.
    pub sealed: i64,
}

/// Maximum number of mentions in a search.
pub const MOST_MENTIONS: usize = 50;
