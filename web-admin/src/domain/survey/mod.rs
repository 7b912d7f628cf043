//! Surveys: who is behind an answer, and in what state it is.

pub mod groups;
pub mod results;

use serde::{Deserialize, Serialize};

/// The role of whoever answers by a link.
pub const PROFESSIONAL: &str = "professional";

/// Whether an answer leads to who gave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, sqlx::Type)]
#[serde(rename_all = "lowercase")]
#[sqlx(rename_all = "lowercase")]
pub enum Identity {
    /// It does not: neither person nor attempt are kept with it.
    Anonymous,
    /// To a pseudonym, and to the attempt.
    Pseudonymous,
    /// To a name.
    Named,
}

impl Identity {
    /// The word for it.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Anonymous => "anonymous",
            Self::Pseudonymous => "pseudonymous",
            Self::Named => "named",
        }
    }
}

/// How far a response has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, sqlx::Type)]
#[serde(rename_all = "lowercase")]
#[sqlx(rename_all = "lowercase")]
pub enum ResponseState {
    /// A link was made, and nobody has consented.
    Invited,
    /// Somebody has consented and not sent their answers.
    Begun,
    /// Sent.
    Submitted,
    /// Taken back; the answers are gone.
    Withdrawn,
}
