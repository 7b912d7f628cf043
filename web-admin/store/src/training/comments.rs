//! Comments on attempts, and replies to them.

use model::ids::{CommentId, PersonId};
use model::training::comment::{Comment, CommentKind};
use model::{Moment, Role, SessionKey};
use serde::Serialize;
use sqlx::FromRow;
use utoipa::ToSchema;

use crate::{Connection, Executor, Result};

/// A stored comment or reply.
#[derive(Clone, Debug, PartialEq, FromRow, Serialize, ToSchema)]
#[schema(as = Kept)]
pub struct CommentRecord {
    /// Id.
    #[schema(value_type = Uuid)]
    pub id: CommentId,
    /// Id of the comment that this is a reply to; absent for a comment.
    #[schema(value_type = Option<Uuid>)]
    pub answers: Option<CommentId>,
    /// Id of the author.
    #[schema(value_type = Uuid)]
    pub author_id: PersonId,
    /// Name of the author.
    pub author: String,
    /// Role of the author.
    pub author_role: Role,
    /// Kind of comment; absent for a reply.
    pub kind: Option<CommentKind>,
    /// Time of the comment, or start of its interval, in s from the start of the recording; absent
    /// for a reply.
    pub from_s: Option<f64>,
    /// End of the interval, in s from the start of the recording; absent for a single moment.
    pub to_s: Option<f64>,
    /// Text.
    pub body: String,
    /// When it was written.
    #[schema(value_type = String, format = DateTime)]
    pub made_at: Moment,
}

/// Stores a comment.
///
/// # Errors
/// If the attempt or the author belongs to another school, or the database fails.
pub async fn add_comment(
    writer: &mut Connection,
    session: SessionKey,
    author: PersonId,
    comment: &Comment,
    now: Moment,
) -> Result<CommentId> {
    let id = CommentId::made_at(now);
    sqlx::query(
        "INSERT INTO comments (id, school_id, session_id, author_id, kind, from_s, to_s, body, made_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9)",
    )
    .bind(id)
    .bind(session.school_id)
    .bind(session.id)
    .bind(author)
    .bind(comment.kind)
    .bind(comment.from_s)
    .bind(comment.to_s)
    .bind(&comment.body)
    .bind(now)
    .execute(writer)
    .await?;
    Ok(id)
}

/// A reply to a comment.
#[derive(Clone, Copy, Debug)]
pub struct CommentAnswer<'a> {
    /// Comment to reply to.
    pub comment_id: CommentId,
    /// Text of the reply.
    pub body: &'a str,
}

/// Stores a reply to a comment of the same attempt. Returns `None` if there is no such comment, if
/// it was withdrawn, or if it is itself a reply.
///
/// # Errors
/// If the author belongs to another school, or the database fails.
pub async fn answer_comment(
    writer: &mut Connection,
    session: SessionKey,
    author: PersonId,
    answer: CommentAnswer<'_>,
    now: Moment,
) -> Result<Option<CommentId>> {
    let id = CommentId::made_at(now);
    let done = sqlx::query(
        "INSERT INTO comments (id, school_id, session_id, author_id, answers, body, made_at)
         SELECT $1, school_id, session_id, $4, id, $6, $7 FROM comments
         WHERE school_id = $2 AND session_id = $3 AND id = $5 AND answers IS NULL AND withdrawn_at IS NULL",
    )
    .bind(id)
    .bind(session.school_id)
    .bind(session.id)
    .bind(author)
    .bind(answer.comment_id)
    .bind(answer.body)
    .bind(now)
    .execute(writer)
    .await?;
    Ok((done.rows_affected() == 1).then_some(id))
}

/// Withdraws a comment or reply of its author. Returns false if it does not exist.
pub async fn withdraw_comment(
    writer: &mut Connection,
    session: SessionKey,
    author: PersonId,
    comment: CommentId,
    now: Moment,
) -> Result<bool> {
    sqlx::query(
        "UPDATE comments SET withdrawn_at = $5
         WHERE school_id = $1 AND session_id = $2 AND id = $3 AND author_id = $4 AND withdrawn_at IS NULL",
    )
    .bind(session.school_id)
    .bind(session.id)
    .bind(comment)
    .bind(author)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Returns the comments on an attempt, sorted by their time in the recording, followed by the
/// replies, sorted by the time of writing. Replies to a withdrawn comment are left out.
pub async fn list_session_comments(executor: impl Executor<'_>, session: SessionKey) -> Result<Vec<CommentRecord>> {
    sqlx::query_as(
        "SELECT c.id, c.answers, c.author_id, p.display_name AS author, p.role AS author_role, c.kind, c.from_s,
           c.to_s, c.body, c.made_at
         FROM comments c
         JOIN people p ON p.school_id = c.school_id AND p.id = c.author_id
         LEFT JOIN comments q ON q.school_id = c.school_id AND q.session_id = c.session_id AND q.id = c.answers
         WHERE c.school_id = $1 AND c.session_id = $2 AND c.withdrawn_at IS NULL AND q.withdrawn_at IS NULL
         ORDER BY c.from_s IS NULL, c.from_s, c.made_at, c.id",
    )
    .bind(session.school_id)
    .bind(session.id)
    .fetch_all(executor)
    .await
}
