//! What is new for somebody: what others did that concerns them.

use crate::Moment;
use crate::ids::{CommentId, RoundId, SessionId};

/// What somebody is told of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum NoticeKind {
    /// Somebody has commented on their attempt.
    Comment,
    /// Somebody whom they teach asks.
    Question,
    /// Somebody has answered a comment.
    Answer,
    /// Their score was changed, or the computed one counts again.
    Override,
    /// All have rated their attempt, or the round that they asked for is finished.
    Rating,
    /// Something was assigned to them.
    Assignment,
}

impl NoticeKind {
    /// The word for it in the database.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Comment => "comment",
            Self::Question => "question",
            Self::Answer => "answer",
            Self::Override => "override",
            Self::Rating => "rating",
            Self::Assignment => "assignment",
        }
    }
}

/// Something new.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct Notice {
    /// What it is.
    pub kind: NoticeKind,
    /// The name of whoever did it.
    pub by: String,
    /// The attempt.
    pub session_id: Option<SessionId>,
    /// What was said.
    pub comment_id: Option<CommentId>,
    /// The second of the attempt that it is about.
    pub from_s: Option<f64>,
    /// The round of ratings.
    pub round_id: Option<RoundId>,
    /// Title of the exercise, of what was assigned, or of the round.
    #[cfg_attr(feature = "sqlx", sqlx(try_from = "crate::titles::StoredTitle"))]
    pub title: String,
    /// When it was done.
    pub made_at: Moment,
}

impl Notice {
    /// The page on which it is read.
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
            (NoticeKind::Assignment, ..) => "/assignments".to_owned(),
            _ => "/".to_owned(),
        }
    }
}

/// A page on which what is new is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoticePlace {
    /// What is said about an attempt.
    Replay(SessionId),
    /// An attempt.
    Attempt(SessionId),
    /// The history of its grade.
    Grade(SessionId),
    /// A round of ratings.
    Round(RoundId),
    /// One's assignments.
    Assignments,
    /// The home page, where everything is marked as read.
    Everywhere,
}

impl NoticePlace {
    /// What is read there.
    #[must_use]
    pub const fn kinds(self) -> &'static [NoticeKind] {
        match self {
            Self::Replay(_) => &[NoticeKind::Comment, NoticeKind::Question, NoticeKind::Answer],
            Self::Attempt(_) => &[NoticeKind::Override],
            Self::Grade(_) => &[NoticeKind::Override, NoticeKind::Rating],
            Self::Round(_) => &[NoticeKind::Rating],
            Self::Assignments => &[NoticeKind::Assignment],
            Self::Everywhere => &[
                NoticeKind::Comment,
                NoticeKind::Question,
                NoticeKind::Answer,
                NoticeKind::Override,
                NoticeKind::Rating,
                NoticeKind::Assignment,
            ],
        }
    }

    /// The attempt that it is limited to.
    #[must_use]
    pub const fn session(self) -> Option<SessionId> {
        match self {
            Self::Replay(session) | Self::Attempt(session) | Self::Grade(session) => Some(session),
            Self::Round(_) | Self::Assignments | Self::Everywhere => None,
        }
    }

    /// The round that it is limited to.
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
    //! Fails when a notice leads to a page on which it is not read.

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
    }
}
