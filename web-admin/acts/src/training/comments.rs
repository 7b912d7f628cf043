//! Comments on an attempt.

use model::CurrentPerson;
use model::ids::CommentId;
use model::training::comment::{Comment, CommentKind};
use serde_json::json;
use store::audit::AuditEntry;
use store::letters::notices as told;
use store::recordings::sessions::Session;
use store::training::comments;
use store::training::comments::CommentAnswer;

use crate::error::Error;
use crate::letters::notices;
use crate::letters::notices::News;
use crate::service::Service;

/// Adds a comment, notifies its readers and returns its id.
pub async fn add_comment(
    service: &Service,
    by: &CurrentPerson,
    session: &Session,
    comment: &Comment,
) -> Result<CommentId, Error> {
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    let made = comments::add_comment(&mut tx, session.key(), by.id, comment, now).await?;
    AuditEntry::by(by, "comment.added", session.id).with(json!({ "comment": made })).append(&mut tx, now).await?;
    let question = comment.kind == CommentKind::Question;
    notices::tell(&mut tx, by, News::Said { session, comment: made, question }, now).await?;
    tx.commit().await?;
    Ok(made)
}

/// Answers a comment, notifies its author and returns the answer's id.
///
/// # Errors
/// Returns [`Error::NotFound`] if there is no such comment; fails if the database fails.
pub async fn answer_comment(
    service: &Service,
    by: &CurrentPerson,
    session: &Session,
    comment: CommentId,
    body: &str,
) -> Result<CommentId, Error> {
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    let made =
        comments::answer_comment(&mut tx, session.key(), by.id, CommentAnswer { comment_id: comment, body }, now)
            .await?;
    let made = made.ok_or(Error::NotFound)?;
    AuditEntry::by(by, "comment.answered", session.id).with(json!({ "comment": made })).append(&mut tx, now).await?;
    notices::tell(&mut tx, by, News::Answered { session, comment, answer: made }, now).await?;
    tx.commit().await?;
    Ok(made)
}

/// Withdraws a person's own comment and deletes its notices.
///
/// # Errors
/// Returns [`Error::NotFound`] if this person has written no such comment; fails if the database
/// fails.
pub async fn withdraw_comment(
    service: &Service,
    by: &CurrentPerson,
    session: &Session,
    comment: CommentId,
) -> Result<(), Error> {
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    if !comments::withdraw_comment(&mut tx, session.key(), by.id, comment, now).await? {
        return Err(Error::NotFound);
    }
    told::forget_comment_notices(&mut tx, session.key(), comment).await?;
    AuditEntry::by(by, "comment.withdrawn", session.id)
        .with(json!({ "comment": comment }))
        .append(&mut tx, now)
        .await?;
    Ok(tx.commit().await?)
}
