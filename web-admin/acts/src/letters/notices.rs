//! Notices: recorded in the transaction of the action that causes them, marked as read on the page
//! they refer to, mailed at most once a day.

use std::time::Duration;

use model::ids::{AssignmentId, CommentId, RoundId, SessionId};
use model::letters::mail::MailKind;
use model::letters::notice::{NoticeKind, NoticePlace};
use model::{CurrentPerson, Moment, PersonKey};
use serde_json::json;
use store::Connection;
use store::audit::AuditEntry;
use store::letters::mails::NewMail;
use store::letters::notices::{LetterTimes, NewNotice};
use store::letters::{mails, notices};
use store::recordings::sessions::Session;

use crate::error::{Error, error_chain};
use crate::replicas::{self, Duty};
use crate::service::Service;

/// Interval between checks for notices to mail.
const EVERY: Duration = Duration::from_secs(600);
/// How long a notice waits for further ones before it is mailed, in s.
const WAIT_S: i64 = 3600;
/// Minimum time between two notification mails to one person, in s.
const DAY_S: i64 = 24 * 3600;
/// Age above which a notice is no longer mailed, in s.
const STALE_S: i64 = 7 * DAY_S;
/// Maximum number of mails queued per check.
const BATCH: u32 = 500;

/// An event that causes notices.
#[derive(Clone, Copy, Debug)]
pub(crate) enum News<'a> {
    /// A comment or a question was added to an attempt.
    Said { session: &'a Session, comment: CommentId, question: bool },
    /// A comment was answered.
    Answered { session: &'a Session, comment: CommentId, answer: CommentId },
    /// A score was overridden, or the computed one restored.
    Judged(&'a Session),
    /// A rating was finished, possibly the last of its round.
    Rated(RoundId),
    /// An assignment was made.
    Assigned(AssignmentId),
}

/// Records a notice for everyone concerned by an event, except for the person who caused it.
pub(crate) async fn tell(tx: &mut Connection, by: &CurrentPerson, news: News<'_>, now: Moment) -> Result<(), Error> {
    for notice in list_notices_of(tx, by, news).await? {
        if notice.whom.person_id != by.id {
            notices::add_notice(tx, notice, now).await?;
        }
    }
    Ok(())
}

/// Records a notice for the person who made an assignment: a learning platform has refused the grade
/// of a trainee. There is one notice until it is read, because often all grades are refused.
pub(crate) async fn tell_refused_grade(
    tx: &mut Connection,
    trainee: PersonKey,
    assignment: AssignmentId,
    now: Moment,
) -> Result<(), Error> {
    let maker = notices::find_unaware_maker(&mut *tx, trainee.school_id, assignment).await?;
    if let Some(person_id) = maker {
        let notice = NewNotice {
            whom: PersonKey { school_id: trainee.school_id, person_id },
            kind: NoticeKind::Delivery,
            by: trainee.person_id,
            session_id: None,
            comment_id: None,
            assignment_id: Some(assignment),
            round_id: None,
            note_id: None,
        };
        notices::add_notice(tx, notice, now).await?;
    }
    Ok(())
}

async fn list_notices_of(tx: &mut Connection, by: &CurrentPerson, news: News<'_>) -> Result<Vec<NewNotice>, Error> {
    let whom = |person_id| PersonKey { school_id: by.school_id, person_id };
    let blank = |kind, person_id| NewNotice {
        whom: whom(person_id),
        kind,
        by: by.id,
        session_id: None,
        comment_id: None,
        assignment_id: None,
        round_id: None,
        note_id: None,
    };
    Ok(match news {
        News::Said { session, comment, question } => {
            let (session_id, comment_id) = (Some(session.id), Some(comment));
            let people = match (session.trainee_id == by.id, question) {
                (false, _) => vec![session.trainee_id],
                (true, true) => notices::list_teachers_of(&mut *tx, whom(session.trainee_id)).await?,
                (true, false) => Vec::new(),
            };
            let kind = if session.trainee_id == by.id { NoticeKind::Question } else { NoticeKind::Comment };
            let notice = |person| NewNotice { session_id, comment_id, ..blank(kind, person) };
            people.into_iter().map(notice).collect()
        }
        News::Answered { session, comment, answer } => {
            let people = notices::list_speakers_on(&mut *tx, session.key(), comment).await?;
            let (session_id, comment_id) = (Some(session.id), Some(answer));
            let notice = |person| NewNotice { session_id, comment_id, ..blank(NoticeKind::Answer, person) };
            people.into_iter().map(notice).collect()
        }
        News::Judged(session) => {
            let session_id: Option<SessionId> = Some(session.id);
            vec![NewNotice { session_id, ..blank(NoticeKind::Override, session.trainee_id) }]
        }
        News::Rated(round) => {
            let parts = notices::list_round_parts(&mut *tx, by.school_id, round).await?;
            let notice = |part: notices::RoundPart| NewNotice {
                session_id: part.session_id,
                round_id: Some(round),
                ..blank(NoticeKind::Rating, part.person_id)
            };
            parts.into_iter().map(notice).collect()
        }
        News::Assigned(assignment) => {
            let people = notices::list_assignees(&mut *tx, by.school_id, assignment).await?;
            let notice =
                |person| NewNotice { assignment_id: Some(assignment), ..blank(NoticeKind::Assignment, person) };
            people.into_iter().map(notice).collect()
        }
    })
}

/// Marks the notices shown at `place` as read. Returns the visitor with the remaining number of
/// unread notices.
pub async fn note_read(state: &Service, person: CurrentPerson, place: NoticePlace) -> Result<CurrentPerson, Error> {
    if person.news == 0 {
        return Ok(person);
    }
    let read = notices::count_unread_at(state.db.reader(), (&person).into(), place).await?;
    if read > 0 {
        let mut tx = state.db.write().await?;
        notices::mark_notices_read(&mut tx, (&person).into(), place, state.clock.now()).await?;
        tx.commit().await?;
    }
    Ok(CurrentPerson { news: person.news.saturating_sub(read), ..person })
}

/// Queues notification mails to everyone assigned, at the request of the assignment's author.
pub async fn mail_assignees(state: &Service, by: &CurrentPerson, assignment: AssignmentId) -> Result<(), Error> {
    let (now, mut tx) = (state.clock.now(), state.db.write().await?);
    let people = notices::list_assignees(&mut *tx, by.school_id, assignment).await?;
    let told = json!({ "letters": people.len() });
    for person_id in people {
        queue_letter(&mut tx, PersonKey { school_id: by.school_id, person_id }, now).await?;
    }
    AuditEntry::by(by, "assignment.mailed", assignment).with(told).append(&mut tx, now).await?;
    tx.commit().await?;
    state.mails.notify_one();
    Ok(())
}

async fn queue_letter(tx: &mut Connection, person: PersonKey, now: Moment) -> Result<(), Error> {
    let PersonKey { school_id, person_id } = person;
    let mail = NewMail { school_id, person_id, kind: MailKind::News, assignment_id: None };
    mails::queue_mail(&mut *tx, mail, now).await?;
    Ok(notices::mark_notices_mailed(&mut *tx, person, now).await?)
}

/// Sets whether a person receives notification mails.
pub async fn choose_news_letters(state: &Service, person: &CurrentPerson, wanted: bool) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    notices::set_news_letters(&mut tx, person.into(), wanted).await?;
    let told = json!({ "wanted": wanted });
    AuditEntry::by(person, "person.news_mail_set", person.id).with(told).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// Queues notification mails periodically until the future is dropped.
pub async fn run(state: Service) {
    loop {
        if let Err(error) = replicas::do_duty(&state, Duty::News, queue_news_letters(&state)).await {
            tracing::warn!(cause = error_chain(&error), "failed to queue notification emails");
        }
        tokio::time::sleep(EVERY).await;
    }
}

/// Queues a mail for everyone who has a notice at least an hour old and got no notification mail
/// within the last day.
///
/// # Errors
/// Fails if the database fails.
pub async fn queue_news_letters(state: &Service) -> Result<(), Error> {
    let now = state.clock.now();
    let times = LetterTimes { from: now.plus_s(-STALE_S), to: now.plus_s(-WAIT_S), last: now.plus_s(-DAY_S) };
    let awaited = notices::list_awaited_letters(state.db.reader(), times, BATCH).await?;
    if awaited.is_empty() {
        return Ok(());
    }
    let mut tx = state.db.write().await?;
    for person in awaited {
        queue_letter(&mut tx, person, now).await?;
    }
    tx.commit().await?;
    state.mails.notify_one();
    Ok(())
}
