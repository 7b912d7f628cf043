//! Actions of teachers on an attempt: confirming supervision, marking as reviewed, overriding the
//! grade.

use model::CurrentPerson;
use serde_json::json;
use store::audit::AuditEntry;
use store::recordings::sessions::Session;
use store::scoring::grades::NewOverride;
use store::scoring::{grades, reviews, supervisions};

use crate::error::Error;
use crate::letters::notices;
use crate::letters::notices::News;
use crate::service::Service;
use crate::training::learning_records::queueing::{GradeSource, queue_statements};

/// Records that a teacher supervised an attempt, or withdraws that.
///
/// # Errors
/// Returns [`Error::Forbidden`] for one's own attempt; fails if the database fails.
pub async fn set_supervised(
    service: &Service,
    by: &CurrentPerson,
    session: &Session,
    was_there: bool,
) -> Result<(), Error> {
    if session.trainee_id == by.id {
        return Err(Error::Forbidden(tr!("you cannot confirm your own attempt")));
    }
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    let (changed, action) = if was_there {
        (supervisions::confirm_supervision(&mut tx, session, by.id, now).await?, "session.supervised")
    } else {
        (supervisions::withdraw_supervision(&mut tx, session.key()).await?, "session.supervision_withdrawn")
    };
    if changed {
        AuditEntry::by(by, action, session.id).append(&mut tx, now).await?;
    }
    Ok(tx.commit().await?)
}

/// Overrides the computed grade, or restores it.
pub async fn override_grade(
    service: &Service,
    by: &CurrentPerson,
    session: &Session,
    new: &NewOverride<'_>,
) -> Result<(), Error> {
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    let id = grades::put_override(&mut tx, session.key(), new, now).await?;
    let source = if new.grade.is_some() { GradeSource::Override(id) } else { GradeSource::Withdrawal(id) };
    queue_statements(service, &mut tx, session.key(), source, now).await?;
    let action = if new.grade.is_some() { "grade.overridden" } else { "grade.override_withdrawn" };
    let details = json!({ "score": new.grade.map(|(score, _)| score), "passed": new.grade.map(|(_, passed)| passed) });
    AuditEntry::by(by, action, session.id).with(details).append(&mut tx, now).await?;
    notices::tell(&mut tx, by, News::Judged(session), now).await?;
    Ok(tx.commit().await?)
}

/// Marks an attempt as reviewed, or returns it to the review queue.
pub async fn set_reviewed(
    service: &Service,
    by: &CurrentPerson,
    session: &Session,
    reviewed: bool,
) -> Result<(), Error> {
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    let (changed, action) = if reviewed {
        (reviews::mark_reviewed(&mut tx, session.key(), by.id, now).await?, "session.reviewed")
    } else {
        (reviews::unmark_reviewed(&mut tx, session.key()).await?, "session.review_withdrawn")
    };
    if changed {
        AuditEntry::by(by, action, session.id).append(&mut tx, now).await?;
    }
    Ok(tx.commit().await?)
}
