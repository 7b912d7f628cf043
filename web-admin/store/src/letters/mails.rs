//! The queue of outgoing mail, and its results.

use model::ids::{DatedId, LetterId, PersonId, SchoolId, SupportNoteId};
use model::letters::mail::{Mail, MailKind, MailTrouble};
use model::{Moment, PersonKey};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// A mail to be queued.
#[derive(Clone, Copy, Debug)]
pub struct NewMail {
    /// School.
    pub school_id: SchoolId,
    /// Recipient.
    pub person_id: PersonId,
    /// Kind of mail.
    pub kind: MailKind,
    /// The item of a reminder.
    pub assignment_id: Option<DatedId>,
}

/// Queues a mail. A reminder is queued only once; another kind is not queued while an earlier mail
/// of the same kind to the same person is waiting.
pub async fn queue_mail(writer: &mut Connection, mail: NewMail, now: Moment) -> Result<()> {
    sqlx::query(
        "INSERT INTO mails (id, school_id, person_id, kind, assignment_id, next_run_at)
         SELECT $1, $2, $3, $4, $5, $6
         WHERE NOT EXISTS (SELECT 1 FROM mails WHERE school_id = $2 AND person_id = $3 AND kind = $4
                           AND assignment_id IS NOT DISTINCT FROM $5 AND (next_run_at IS NOT NULL OR kind = 'reminder'))",
    )
    .bind(LetterId::made_at(now))
    .bind(mail.school_id)
    .bind(mail.person_id)
    .bind(mail.kind)
    .bind(mail.assignment_id)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Queues a teacher's message.
pub async fn queue_message(writer: &mut Connection, to: PersonKey, note: SupportNoteId, now: Moment) -> Result<()> {
    sqlx::query(
        "INSERT INTO mails (id, school_id, person_id, kind, note_id, next_run_at) VALUES ($1, $2, $3, $4, $5, $6)",
    )
    .bind(LetterId::made_at(now))
    .bind(to.school_id)
    .bind(to.person_id)
    .bind(MailKind::Message)
    .bind(note)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

macro_rules! select_mails {
    ($rest:literal) => {
        concat!(
            "SELECT m.id, m.school_id, m.person_id, m.kind, m.assignment_id, m.note_id, m.tries, p.display_name AS name, p.email,
               s.name AS school, s.time_zone, coalesce(p.language, s.letter_language) AS language,
               p.disabled_at IS NULL AND p.email NOT LIKE '%@no-address.invalid' AND CASE m.kind WHEN 'reminder' THEN s.mails_reminders WHEN 'news' THEN s.mails_news
                 ELSE TRUE END AS enabled
             FROM mails m JOIN people p ON p.id = m.person_id JOIN schools s ON s.id = m.school_id ",
            $rest
        )
    };
}

/// Returns the mails that are due, oldest first.
pub async fn list_due_mails(executor: impl Executor<'_>, now: Moment, limit: u32) -> Result<Vec<Mail>> {
    sqlx::query_as(select_mails!("WHERE m.next_run_at <= $1 ORDER BY m.next_run_at LIMIT $2 + 0"))
        .bind(now)
        .bind(i64::from(limit))
        .fetch_all(executor)
        .await
}

/// Returns the reminders of a person that are due, oldest first.
pub async fn list_due_reminders(executor: impl Executor<'_>, whom: PersonKey, now: Moment) -> Result<Vec<Mail>> {
    sqlx::query_as(select_mails!(
        "WHERE m.school_id = $1 AND m.person_id = $2 AND m.kind = 'reminder' AND m.next_run_at <= $3 ORDER BY m.id"
    ))
    .bind(whom.school_id)
    .bind(whom.person_id)
    .bind(now)
    .fetch_all(executor)
    .await
}

/// Returns when the last reminder of a person was sent.
pub async fn find_last_reminder(executor: impl Executor<'_>, whom: PersonKey) -> Result<Option<Moment>> {
    sqlx::query_scalar("SELECT max(sent_at) FROM mails WHERE school_id = $1 AND person_id = $2 AND kind = 'reminder'")
        .bind(whom.school_id)
        .bind(whom.person_id)
        .fetch_one(executor)
        .await
}

/// Postpones the reminders of a person that are due.
pub async fn postpone_reminders(writer: &mut Connection, whom: PersonKey, now: Moment, until: Moment) -> Result<()> {
    sqlx::query(
        "UPDATE mails SET next_run_at = $4
         WHERE school_id = $1 AND person_id = $2 AND kind = 'reminder' AND next_run_at <= $3",
    )
    .bind(whom.school_id)
    .bind(whom.person_id)
    .bind(now)
    .bind(until)
    .execute(writer)
    .await
    .map(drop)
}

/// Claims a mail before it is sent, so that it is never sent twice automatically, even after a
/// crash. Returns false if another worker has claimed it.
pub async fn claim_mail(writer: &mut Connection, id: LetterId) -> Result<bool> {
    sqlx::query(
        "UPDATE mails SET next_run_at = NULL, tries = tries + 1, error = NULL WHERE id = $1 AND next_run_at IS NOT NULL",
    )
    .bind(id)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Records that a mail was sent.
pub async fn mark_mail_sent(writer: &mut Connection, id: LetterId, now: Moment) -> Result<()> {
    sqlx::query("UPDATE mails SET sent_at = $2 WHERE id = $1").bind(id).bind(now).execute(writer).await.map(drop)
}

/// Records that a mail could not be sent, and when to retry; `None` means that it is not retried.
pub async fn mark_mail_failed(writer: &mut Connection, id: LetterId, error: &str, again: Option<Moment>) -> Result<()> {
    sqlx::query("UPDATE mails SET error = $2, next_run_at = $3 WHERE id = $1")
        .bind(id)
        .bind(error)
        .bind(again)
        .execute(writer)
        .await
        .map(drop)
}

/// A letter that could not be sent.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct FailedLetter {
    /// Recipient; `None` if it was sent to an address without an account.
    pub person_id: Option<PersonId>,
    /// Name of the recipient, or the address.
    pub name: String,
    /// Error message.
    pub error: String,
}

/// Returns the letters of a school that could not be sent, latest first. A failure is left out once
/// a later letter to the same person was sent.
pub async fn list_failed_letters(
    executor: impl Executor<'_>,
    school: SchoolId,
    limit: u32,
) -> Result<Vec<FailedLetter>> {
    sqlx::query_as(
        "SELECT person_id, name, error FROM (SELECT m.id, m.person_id, p.display_name AS name, m.error
           FROM mails m JOIN people p ON p.id = m.person_id
           WHERE m.school_id = $1 AND m.error IS NOT NULL AND m.sent_at IS NULL
             AND NOT EXISTS (SELECT 1 FROM mails l WHERE l.school_id = m.school_id AND l.person_id = m.person_id
               AND l.id > m.id AND l.sent_at IS NOT NULL)
         UNION ALL SELECT s.id, NULL AS person_id, s.email AS name, s.error FROM survey_letters s
           WHERE s.school_id = $1 AND s.error IS NOT NULL AND s.sent_at IS NULL) failed ORDER BY id DESC LIMIT $2 + 0",
    )
    .bind(school)
    .bind(i64::from(limit))
    .fetch_all(executor)
    .await
}

/// Deletes a mail that is no longer needed.
pub async fn withdraw_mail(writer: &mut Connection, id: LetterId) -> Result<()> {
    sqlx::query("DELETE FROM mails WHERE id = $1").bind(id).execute(writer).await.map(drop)
}

/// Returns the problem with a person's latest mail with a link: sending failed, or the outcome is
/// unknown. `None` if it was sent or is waiting for the first attempt.
pub async fn find_mail_trouble(
    executor: impl Executor<'_>,
    school: SchoolId,
    person: PersonId,
) -> Result<Option<MailTrouble>> {
    let latest: Option<(Option<Moment>, Option<Moment>, Option<String>)> = sqlx::query_as(
        "SELECT sent_at, next_run_at, error FROM mails WHERE school_id = $1 AND person_id = $2 AND kind IN ('invitation', 'reset')
         ORDER BY id DESC LIMIT 1",
    )
    .bind(school)
    .bind(person)
    .fetch_optional(executor)
    .await?;
    Ok(latest.and_then(|of_mail| match of_mail {
        (None, _, Some(why)) => Some(MailTrouble::Unsent(why)),
        (None, None, None) => Some(MailTrouble::Unknown),
        _ => None,
    }))
}
