//! Support of a trainee at risk: a message, a conversation, or a note.

use crate::Moment;
use crate::ids::{PersonId, SupportNoteId};
use crate::single_line_text::{strange_in, title};

/// Maximum length of a text, in characters.
pub const MOST_CHARACTERS: usize = 4000;
/// Maximum number of people of one message or note.
pub const MOST_PEOPLE: usize = 500;

/// Kind of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum SupportKind {
    /// A message to the person, by mail and as a notice.
    Message,
    /// Somebody spoke to the person.
    Spoken,
    /// A note for the others who teach the person.
    Note,
}

impl SupportKind {
    /// All kinds, in the order of the form.
    pub const ALL: [Self; 3] = [Self::Message, Self::Spoken, Self::Note];

    /// Returns the name used in forms and the database.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Message => "message",
            Self::Spoken => "spoken",
            Self::Note => "note",
        }
    }
}

/// A valid text to be recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SupportText {
    /// Kind.
    pub kind: SupportKind,
    /// Subject on one line, of a message.
    pub subject: Option<String>,
    /// The text; may have several lines.
    pub body: String,
}

impl SupportText {
    /// Validates an entered text.
    ///
    /// # Errors
    /// If the kind is unknown, the subject of a message is missing, too long or not on one line, or
    /// the text is missing, too long or contains a control character; as a message.
    pub fn read(kind: &str, subject: &str, body: &str) -> Result<Self, String> {
        let kind = SupportKind::ALL.into_iter().find(|known| known.name() == kind);
        let kind = kind.ok_or_else(|| tr!("Choose what was done: a message, a conversation or a note.").to_owned())?;
        let subject = match kind {
            SupportKind::Message => Some(title(subject).map_err(|_| refuse_subject())?.to_owned()),
            SupportKind::Spoken | SupportKind::Note => None,
        };
        let body = body.replace("\r\n", "\n").trim().to_owned();
        let least = usize::from(kind != SupportKind::Spoken);
        let count = body.chars().count();
        if !(least..=MOST_CHARACTERS).contains(&count) {
            return Err(tr!(
                "text: {count} characters; allowed: {least} to {most}",
                count = count,
                least = least,
                most = MOST_CHARACTERS
            ));
        }
        if body.lines().any(|line| strange_in(&line.replace('\t', " ")).is_some()) {
            return Err(tr!("text: contains a control character, which is not allowed").to_owned());
        }
        Ok(Self { kind, subject, body })
    }
}

fn refuse_subject() -> String {
    tr!("subject: a message needs one, on one line, of at most 200 characters").to_owned()
}

/// A support record.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct SupportNote {
    /// Id.
    pub id: SupportNoteId,
    /// The person.
    pub person_id: PersonId,
    /// Name of the author.
    pub by: String,
    /// Kind.
    pub kind: SupportKind,
    /// Subject of a message.
    pub subject: Option<String>,
    /// Text; may be empty for a conversation.
    pub body: String,
    /// Whether a message was queued as a mail.
    pub mailed: bool,
    /// When.
    pub made_at: Moment,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_needs_a_subject_on_one_line_and_a_text() {
        let read = |kind: &str, subject: &str, body: &str| SupportText::read(kind, subject, body);
        let fine = read("message", " Practice ", "Dear all,\r\n\r\nplease practise.").unwrap();
        assert_eq!((fine.subject.as_deref(), fine.body.as_str()), (Some("Practice"), "Dear all,\n\nplease practise."));
        assert_eq!(read("note", "ignored", "x").unwrap().subject, None);
        assert!(read("spoken", "", "").is_ok(), "that somebody spoke to a person says enough");
        for (kind, subject, body) in [
            ("shout", "a", "b"),
            ("message", "", "b"),
            ("message", "a\nBcc: b", "c"),
            ("message", "a", " "),
            ("note", "", ""),
            ("note", "", "a\u{202e}b"),
        ] {
            assert!(read(kind, subject, body).is_err(), "{kind} {subject:?} {body:?}");
        }
        assert!(read("note", "", &"x".repeat(MOST_CHARACTERS)).is_ok());
        assert!(read("note", "", &"x".repeat(MOST_CHARACTERS + 1)).is_err());
    }
}
