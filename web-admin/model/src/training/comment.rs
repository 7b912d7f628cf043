//! A comment on a moment or an interval of an attempt.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Maximum length of a comment, in characters.
pub const MOST_CHARACTERS: usize = 2000;

/// Kind of comment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum CommentKind {
    /// Something was done well.
    Praise,
    /// Something was done wrong.
    Error,
    /// A question.
    Question,
    /// An explanation worth knowing.
    Teaching,
}

impl CommentKind {
    /// All kinds, in the order of the form.
    pub const ALL: [Self; 4] = [Self::Praise, Self::Error, Self::Question, Self::Teaching];

    /// Returns the name used in forms, files and the database.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Praise => "praise",
            Self::Error => "error",
            Self::Question => "question",
            Self::Teaching => "teaching",
        }
    }
}

/// A comment as entered.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, ToSchema)]
#[schema(as = Typed)]
pub struct TypedComment {
    /// `praise`, `error`, `question` or `teaching`.
    #[serde(default)]
    pub kind: String,
    /// Time of the comment, or start of its interval, in s from the start of the attempt.
    #[serde(default)]
    pub from_s: String,
    /// End of the interval, in s from the start of the attempt; empty for a single moment.
    #[serde(default)]
    pub to_s: String,
    /// Text of the comment, at most 2000 characters.
    #[serde(default)]
    pub body: String,
}

/// A valid comment.
#[derive(Clone, Debug, PartialEq)]
pub struct Comment {
    /// Kind.
    pub kind: CommentKind,
    /// Time of the comment, or start of its interval, in s.
    pub from_s: f64,
    /// End of the interval, in s; `None` for a single moment.
    pub to_s: Option<f64>,
    /// Text.
    pub body: String,
}

/// A comment was refused: field, value and accepted values.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CommentRefused(String);

impl Comment {
    /// Validates an entered comment for an attempt of duration `duration_s`, in s.
    ///
    /// # Errors
    /// If the kind is unknown, a time is outside the attempt, or the text is empty or too long.
    pub fn parse(typed: &TypedComment, duration_s: f64) -> Result<Self, CommentRefused> {
        let kind = CommentKind::ALL.into_iter().find(|kind| kind.name() == typed.kind);
        let kind = kind.ok_or_else(|| {
            CommentRefused(format!("kind: \"{}\"; allowed: praise, error, question, teaching", typed.kind))
        })?;
        let from_s = moment("from", &typed.from_s, 0.0, duration_s)?;
        let to_s = match typed.to_s.trim() {
            "" => None,
            to_s => Some(moment("to", to_s, from_s, duration_s)?),
        };
        Ok(Self { kind, from_s, to_s, body: words(&typed.body)? })
    }
}

fn moment(field: &str, typed: &str, least_s: f64, most_s: f64) -> Result<f64, CommentRefused> {
    let typed = typed.trim();
    let seconds = typed.replace(',', ".").parse::<f64>().ok().filter(|s| (least_s..=most_s).contains(s));
    seconds.ok_or_else(|| {
        // Rounded inwards, so that the limits named in the message are themselves valid.
        let (least_s, most_s) = ((least_s * 100.0).ceil() / 100.0, (most_s * 100.0).floor() / 100.0);
        CommentRefused(tr!(
            "{field}: “{typed}”; allowed: {least} to {most} s, within the attempt",
            field = field,
            typed = typed,
            least = least_s,
            most = most_s
        ))
    })
}

/// Validates the text of a comment or reply.
///
/// # Errors
/// If it is empty or too long, or contains U+0000, at which SQLite ends a text.
pub fn words(typed: &str) -> Result<String, CommentRefused> {
    let body = typed.trim();
    if body.contains('\0') {
        return Err(CommentRefused(tr!("comment: contains the character U+0000, which is not allowed").to_owned()));
    }
    match body.chars().count() {
        0 => Err(CommentRefused(tr!("comment: empty; enter a text").to_owned())),
        1..=MOST_CHARACTERS => Ok(body.to_owned()),
        count => Err(CommentRefused(tr!(
            "comment: {count} characters; allowed: at most {most}",
            count = count,
            most = MOST_CHARACTERS
        ))),
    }
}

#[cfg(test)]
mod tests {
    //! Checks that comments outside the attempt are refused, and that the text is kept unchanged.
    use super::*;

    fn typed(from_s: &str, to_s: &str) -> TypedComment {
        TypedComment {
            kind: "praise".into(),
            from_s: from_s.into(),
            to_s: to_s.into(),
            body: " Well <b>held</b>. ".into(),
        }
    }

    #[test]
    fn a_moment_and_an_interval_within_the_attempt_are_kept() {
        let kept = Comment::parse(&typed("1,5", ""), 10.0).expect("a comma is a point to half of the world");
        assert_eq!((kept.from_s.to_bits(), kept.to_s), (1.5_f64.to_bits(), None));
        assert_eq!(kept.body, "Well <b>held</b>.");
        assert!(Comment::parse(&typed("0", "10"), 10.0).is_ok());
    }

    #[test]
    fn out_of_range_comment_time_is_rejected_with_the_range() {
        for (from_s, to_s, word) in [
            ("10.1", "", "from: “10.1”; allowed: 0 to 10 s"),
            ("-1", "", "from"),
            ("", "", "from"),
            ("NaN", "", "from"),
            ("5", "4", "to: “4”; allowed: 5 to 10 s"),
            ("5", "11", "to"),
            ("5", "inf", "to"),
        ] {
            let refused = Comment::parse(&typed(from_s, to_s), 10.0).expect_err(from_s).to_string();
            assert!(refused.contains(word), "{refused}");
        }
    }

    #[test]
    fn no_words_too_many_words_and_an_unknown_kind_are_refused() {
        assert!(words(" \n ").is_err());
        assert!(words(&"ä".repeat(MOST_CHARACTERS)).is_ok());
        assert!(words(&"ä".repeat(MOST_CHARACTERS + 1)).is_err());
        let odd = TypedComment { kind: "shout".into(), ..typed("1", "") };
        assert!(Comment::parse(&odd, 10.0).expect_err("no such kind").to_string().contains("shout"));
    }
}
