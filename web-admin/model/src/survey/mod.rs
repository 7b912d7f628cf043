//! Surveys: who is behind an answer, and in what state it is.

pub mod given;
pub mod groups;
pub mod results;
mod scales;

use serde::{Deserialize, Serialize};

use crate::Moment;
use crate::ids::{PersonId, RevisionId, SchoolId, StudyId, SurveyId};

/// For how many hours after an attempt a survey about it is offered where nobody says otherwise: workload is forgotten in a day.
pub const FRESH_HOURS: u32 = 24;

/// The role of whoever answers by a link.
pub const PROFESSIONAL: &str = "professional";

/// Whether an answer leads to who gave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
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

/// A survey.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct Survey {
    /// Id.
    pub id: SurveyId,
    /// Its school.
    pub school_id: SchoolId,
    /// The revision of the instrument that it asks.
    pub revision_id: RevisionId,
    /// The instrument's title, in the reader's language.
    #[cfg_attr(feature = "sqlx", sqlx(try_from = "crate::titles::StoredTitle"))]
    pub instrument: String,
    /// Title.
    pub title: String,
    /// Whose it is; none: the administrators'.
    pub owner_id: Option<PersonId>,
    /// Whether answers lead to who gave them.
    pub identity: Identity,
    /// Asked after each attempt.
    pub after_attempts: bool,
    /// For how many hours after it, while it is fresh in mind; none: as long as the survey is open.
    #[cfg_attr(feature = "sqlx", sqlx(try_from = "crate::count::StoredCount"))]
    pub fresh_hours: Option<u32>,
    /// The study that asks it of its participants.
    pub study_id: Option<StudyId>,
    /// A study asks it after the last attempt, not after each.
    pub at_end: bool,
    /// The answers were made by a program.
    pub generated: bool,
    /// From when on it can be answered.
    pub opens_at: Moment,
    /// Until when.
    pub closes_at: Option<Moment>,
    /// When it was made.
    pub created_at: Moment,
}

impl Survey {
    /// Whether it can be answered at a moment.
    #[must_use]
    pub fn is_open(&self, now: Moment) -> bool {
        self.opens_at <= now && self.closes_at.is_none_or(|closes| now < closes)
    }
}
