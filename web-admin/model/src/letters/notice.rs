//! Notices of actions by others that concern a person.

use crate::Moment;
use crate::ids::{CommentId, RoundId, SessionId};

/// Kind of notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum NoticeKind {
    /// Someone commented on the person's attempt.
    Comment,
    /// A trainee of the person asked a question.
    Question,
    /// Someone replied to a comment.
    Answer,
    /// The person's score was overridden, or an override was removed.
    Override,
    /// All ratings of the person's attempt, or of the round that the person created, are finished.
    Rating,
    /// An assignment was made to the person.
    Assignment,
    /// A learning platform has refused a grade of an assignment that the person made.
    Delivery,
    /// A teacher wrote to the person.
    Message,
}

impl NoticeKind {
    /// Returns the word used in the database.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Comment => "comment",
            Self::Question => "question",
            Self::Answer => "answer",
            Self::Override => "override",
            Self::Rating => "rating",
            Self::Assignment => "assignment",
            Self::Delivery => "delivery",
            Self::Message => "message",
        }
    }
}

/// A notice.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct Notice {
    /// Kind.
    pub kind: NoticeKind,
    /// Name of the person who caused it, or whose grade it is.
    pub by: String,
    /// Attempt.
    pub session_id: Option<SessionId>,
    /// Comment or reply.
    pub comment_id: Option<CommentId>,
    /// Time in the attempt that it refers to, in s.
    pub from_s: Option<f64>,
    /// Round of ratings.
    pub round_id: Option<RoundId>,
    /// Title of the exercise, the assignment or the round.
    #[cfg_attr(feature = "sqlx", sqlx(try_from = "crate::titles::StoredTitle"))]
    pub title: String,
    /// Time of the event.
    pub made_at: Moment,
}

impl Notice {
    /// Returns the path of the page that shows it.
    #[must_use]
    pub fn href(&self) -> String {
        match (self.kind, self.session_id, self.round_id) {
            (NoticeKind::Comment | NoticeKind::Question | NoticeKind::Answer, Some(session), _) => {
                let at = self.from_s.map_or_else(String::new, |from_s| format!("?t={from_s:.2}"));
                let to = self.comment_id.map_or_else(String::new, |id| format!("#comment-{id}"));
                format!("/sessions/{session}/replay{at}{to}")
            }
            (NoticeKind::Override, Some(session), _) => format!("/sessions/{session}"),
            (NoticeKind::Rating, Some(session), _) => format!("/sessions/{session}/grade"),
            (NoticeKind::Rating, None, Some(round)) => format!("/ratings/{round}"),
            (NoticeKind::Assignment | NoticeKind::Delivery, ..) => "/assignments".to_owned(),
            (NoticeKind::Message, ..) => "/#messages".to_owned(),
            _ => "/".to_owned(),
        }
    }
}

/// A page that marks notices as read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoticePlace {
    /// The comments on an attempt.
    Replay(SessionId),
    /// An attempt.
    Attempt(SessionId),
    /// The grade history of an attempt.
    Grade(SessionId),
    /// A round of ratings.
    Round(RoundId),
    /// The person's assignments.
    Assignments,
    /// The home page, which marks all notices as read.
    Everywhere,
}

impl NoticePlace {
    /// Returns the kinds of notices that the page marks as read.
    #[must_use]
    pub const fn kinds(self) -> &'static [NoticeKind] {
        match self {
            Self::Replay(_) => &[NoticeKind::Comment, NoticeKind::Question, NoticeKind::Answer],
            Self::Attempt(_) => &[NoticeKind::Override],
            Self::Grade(_) => &[NoticeKind::Override, NoticeKind::Rating],
            Self::Round(_) => &[NoticeKind::Rating],
            Self::Assignments => &[NoticeKind::Assignment, NoticeKind::Delivery],
            Self::Everywhere => &[
                NoticeKind::Comment,
                NoticeKind::Question,
                NoticeKind::Answer,
                NoticeKind::Override,
                NoticeKind::Rating,
                NoticeKind::Assignment,
                NoticeKind::Delivery,
                NoticeKind::Message,
            ],
        }
    }

    /// Returns the attempt to which the page is limited.
    #[must_use]
    pub const fn session(self) -> Option<SessionId> {
        match self {
            Self::Replay(session) | Self::Attempt(session) | Self::Grade(session) => Some(session),
            Self::Round(_) | Self::Assignments | Self::Everywhere => None,
        }
    }

    /// Returns the round to which the page is limited.
    #[must_use]
    pub const fn round(self) -> Option<RoundId> {
        match self {
            Self::Round(round) => Some(round),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    //! Checks that each notice links to a page that marks it as read.

    use super::*;

    #[test]
    fn each_notice_leads_to_where_it_is_read() {
        let notice = |kind, session_id, round_id| Notice {
            kind,
            by: "Dr Osei".to_owned(),
            session_id,
            comment_id: Some(CommentId::nil()),
            from_s: Some(3.5),
            round_id,
            title: "Stop in the fat".to_owned(),
            made_at: Moment::from_micros(0),
        };
        let (session, round) = (SessionId::nil(), RoundId::nil());
        let comment = notice(NoticeKind::Comment, Some(session), None).href();
        assert_eq!(comment, format!("/sessions/{session}/replay?t=3.50#comment-{}", CommentId::nil()));
        assert!(NoticePlace::Replay(session).kinds().contains(&NoticeKind::Comment));
        assert_eq!(notice(NoticeKind::Rating, None, Some(round)).href(), format!("/ratings/{round}"));
        assert_eq!(notice(NoticeKind::Rating, Some(session), Some(round)).href(), format!("/sessions/{session}/grade"));
        assert_eq!(notice(NoticeKind::Assignment, None, None).href(), "/assignments");
        assert_eq!(notice(NoticeKind::Message, None, None).href(), "/#messages");
    }
}
