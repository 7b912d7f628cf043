//! Outgoing mail.

use crate::Moment;
use crate::ids::{DatedId, LetterId, PersonId, ResponseId, SchoolId, SupportNoteId, SurveyId};

/// Kind of mail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum MailKind {
    /// A link for setting the first password.
    Invitation,
    /// A link for resetting the password.
    Reset,
    /// A reminder of something to do.
    Reminder,
    /// The person's second factor was turned off.
    #[cfg_attr(feature = "sqlx", sqlx(rename = "second_factor_off"))]
    SecondFactorOff,
    /// Unread notices.
    News,
    /// An account of another system was joined to the person's.
    #[cfg_attr(feature = "sqlx", sqlx(rename = "identity_joined"))]
    IdentityJoined,
    /// A message from a teacher.
    Message,
}

/// Problem with a sent mail.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MailTrouble {
    /// It could not be sent, with the error message.
    Unsent(String),
    /// The outcome is unknown: it is being sent, or the service ended while it was.
    Unknown,
}

/// A mail to be sent.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct Mail {
    /// Id.
    pub id: LetterId,
    /// School.
    pub school_id: SchoolId,
    /// Recipient.
    pub person_id: PersonId,
    /// Kind of mail.
    pub kind: MailKind,
    /// The item of a reminder.
    pub assignment_id: Option<DatedId>,
    /// The record that contains a message.
    pub note_id: Option<SupportNoteId>,
    /// Number of attempts to send it.
    pub tries: i64,
    /// Name of the recipient.
    pub name: String,
    /// Email address of the recipient.
    pub email: String,
    /// Name of the school.
    pub school: String,
    /// Time zone of the school.
    pub time_zone: String,
    /// Code of the language chosen by the recipient, or else by the school.
    pub language: Option<String>,
    /// The account is neither disabled nor erased, and the school sends this kind of mail.
    pub enabled: bool,
}

/// A warning before the erasure of an inactive person.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct RetentionLetter {
    /// Id.
    pub id: LetterId,
    /// Number of attempts to send it.
    pub tries: i64,
    /// Name of the recipient.
    pub name: String,
    /// Email address of the recipient.
    pub email: String,
    /// Name of the school.
    pub school: String,
    /// Code of the language chosen by the recipient, or else by the school.
    pub language: Option<String>,
    /// Months of inactivity after which the school erases a person.
    #[cfg_attr(feature = "sqlx", sqlx(try_from = "crate::count::StoredCount"))]
    pub months: Option<u32>,
    /// Days until the erasure.
    #[cfg_attr(feature = "sqlx", sqlx(try_from = "i64"))]
    pub warn_days: u32,
}

/// A letter with a survey link.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct SurveyLetter {
    /// Id.
    pub id: LetterId,
    /// School.
    pub school_id: SchoolId,
    /// Survey.
    pub survey_id: SurveyId,
    /// Name of the recipient; may be empty.
    pub name: String,
    /// Email address of the recipient.
    pub email: String,
    /// Response whose link an earlier attempt has created.
    pub response_id: Option<ResponseId>,
    /// Number of attempts to send it.
    pub tries: i64,
    /// Name of the school.
    pub school: String,
}

/// Status of a letter.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct LetterDelivery {
    /// Name of the recipient; may be empty.
    pub name: String,
    /// Email address of the recipient.
    pub email: String,
    /// Time at which it was sent.
    pub sent_at: Option<Moment>,
    /// Error of the last attempt.
    pub error: Option<String>,
    /// Time of the next attempt.
    pub next_run_at: Option<Moment>,
}
