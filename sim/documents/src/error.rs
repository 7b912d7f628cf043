//! What is wrong with a document, and where.

use phrase::Phrase;

/// One thing wrong: `file:line:column: field: value unit; allowed`.
#[derive(Clone, Debug, PartialEq)]
pub struct Issue {
    /// The file as it was named to us.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Dotted path of the field, for example `layer[1].thickness_mm`.
    pub field: String,
    /// The value as written, with its unit, where there is one.
    pub found: Phrase,
    /// What is allowed, in words.
    pub allowed: Phrase,
}

/// What somebody other than the reader has to say of a field of a document that can be read.
#[derive(Clone, Debug, PartialEq)]
pub struct Remark {
    /// Dotted path of the field, for example `rubric[0].full`.
    pub field: String,
    /// What was found.
    pub found: Phrase,
    /// What would be right, in words.
    pub allowed: Phrase,
}

/// A refused document: at least one issue.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}", .issues.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct DocumentError {
    /// Every issue found, in document order.
    pub issues: Vec<Issue>,
}

impl std::fmt::Display for Issue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}: {}: {}; {}", self.file, self.line, self.column, self.field, self.found, self.allowed)
    }
}

impl From<Issue> for DocumentError {
    fn from(issue: Issue) -> Self {
        Self { issues: vec![issue] }
    }
}
