//! What is mailed.

use crate::Moment;
use crate::ids::{DatedId, LetterId, PersonId, ResponseId, SchoolId, SurveyId};

/// What a mail is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum MailKind {
    /// A link to a first password.
    Invitation,
    /// A link to another password.
    Reset,
    /// Something is due soon.
    Reminder,
    /// Their second factor was turned off.
    #[cfg_attr(feature = "sqlx", sqlx(rename = "second_factor_off"))]
    SecondFactorOff,
    /// What is new for them.
    News,
}

/// Why it is not known that a mail went out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MailTrouble {
    /// It did not: why.
    Unsent(String),
    /// It is on its way, or the service ended while it was.
    Unknown,
}

/// A mail that is to be sent.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct Mail {
    /// Id.
    pub id: LetterId,
    /// School.
    pub school_id: SchoolId,
    /// To whom.
    pub person_id: PersonId,
    /// What about.
    pub kind: MailKind,
    /// The assignment or task of a reminder.
    pub assignment_id: Option<DatedId>,
    /// How often it was tried.
    pub tries: i64,
    /// Their name.
    pub name: String,
    /// Their address.
    pub email: String,
    /// Their school's name.
    pub school: String,
    /// The school's time zone.
    pub time_zone: String,
    /// The language that they have chosen, or else their school, by its code.
    pub language: Option<String>,
    /// They may be written to, being neither disabled nor erased, and the school mails such letters.
    pub enabled: bool,
}

/// A letter that is to be sent.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct RetentionLetter {
    /// Id.
    pub id: LetterId,
    /// How often it was tried.
    pub tries: i64,
    /// To whom.
    pub name: String,
    /// Their address.
    pub email: String,
    /// Their school's name.
    pub school: String,
    /// The language that they have chosen, or else their school, by its code.
    pub language: Option<String>,
    /// Months that the school keeps whoever does nothing.
    #[cfg_attr(feature = "sqlx", sqlx(try_from = "crate::count::StoredCount"))]
    pub months: Option<u32>,
    /// Days until they are erased.
    #[cfg_attr(feature = "sqlx", sqlx(try_from = "i64"))]
    pub warn_days: u32,
}

/// A letter that is to be sent.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct SurveyLetter {
    /// Id.
    pub id: LetterId,
    /// School.
    pub school_id: SchoolId,
    /// Survey.
    pub survey_id: SurveyId,
    /// Name of whom it goes to; may be empty.
    pub name: String,
    /// Where it goes.
    pub email: String,
    /// The response whose link an earlier try has made.
    pub response_id: Option<ResponseId>,
    /// How often it was tried.
    pub tries: i64,
    /// The school's name.
    pub school: String,
}

/// How a letter went.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct LetterDelivery {
    /// Name of whom it goes to; may be empty.
    pub name: String,
    /// Where it goes.
    pub email: String,
    /// When it went out.
    pub sent_at: Option<Moment>,
    /// Why it did not.
    pub error: Option<String>,
    /// When it is tried, for the first time or again.
    pub next_run_at: Option<Moment>,
}
