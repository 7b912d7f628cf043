//! Document errors with their location.

use phrase::Phrase;

/// One issue: `file:line:column: field: value unit; allowed`.
#[derive(Clone, Debug, PartialEq)]
pub struct Issue {
    /// The file name as the caller passed it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Dotted path of the field, for example `layer[1].thickness_mm`.
    pub field: String,
    /// The value as written, with its unit if there is one.
    pub found: Phrase,
    /// The allowed values in words.
    pub allowed: Phrase,
}

/// A finding about a field of a document that parsed, made by a caller other than the reader.
#[derive(Clone, Debug, PartialEq)]
pub struct Remark {
    /// Dotted path of the field, for example `rubric[0].full`.
    pub field: String,
    /// The value found.
    pub found: Phrase,
    /// The expected value in words.
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
