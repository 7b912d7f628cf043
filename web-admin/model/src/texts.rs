//! Free texts that somebody wrote, or that others wrote about their attempts.

/// How many texts there are, by who wrote them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TextCounts {
    /// Comments, reasons and answers of theirs.
    pub written: i64,
    /// What others wrote about their attempts, or about their consent.
    pub about: i64,
    /// Reasons about their attempts in the audit log, which never changes.
    pub sealed: i64,
}

/// Most mentions that are looked for.
pub const MOST_MENTIONS: usize = 50;
