//! Support records of trainees at risk.

use model::ids::{PersonId, SupportNoteId};
use model::training::risk::TraineeAddress;
use model::training::support_note::{SupportNote, SupportText};
use model::{CurrentPerson, Moment, PersonKey, Role};

use crate::{Connection, Executor, Result};

/// A record to be stored.
#[derive(Clone, Copy, Debug)]
pub struct NewSupportNote<'a> {
    /// The trainee.
    pub person_id: PersonId,
    /// The text.
    pub text: &'a SupportText,
    /// Whether it is queued as a mail.
    pub mailed: bool,
}

/// Stores a record and returns its id.
///
/// # Errors
/// If the trainee belongs to another school, or the database fails.
pub async fn add_support_note(
    writer: &mut Connection,
    by: &CurrentPerson,
    new: NewSupportNote<'_>,
    now: Moment,
) -> Result<SupportNoteId> {
    sqlx::query_scalar(
        "INSERT INTO support_notes (id, school_id, person_id, by_id, kind, subject, body, mailed, made_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9) RETURNING id",
    )
    .bind(SupportNoteId::made_at(now))
    .bind(by.school_id)
    .bind(new.person_id)
    .bind(by.id)
    .bind(new.text.kind)
    .bind(&new.text.subject)
    .bind(&new.text.body)
    .bind(new.mailed)
    .bind(now)
    .fetch_one(writer)
    .await
}

/// Selects records of school `$1`.
macro_rules! support_notes {
    ($rest:literal) => {
        concat!(
            "SELECT n.id, n.person_id, b.display_name AS \"by\", n.kind, n.subject, n.body, n.mailed, n.made_at
             FROM support_notes n JOIN people b ON b.school_id = n.school_id AND b.id = n.by_id
             WHERE n.school_id = $1 ",
            $rest
        )
    };
}

/// Returns the latest records about a trainee, newest first.
pub async fn list_support_notes(executor: impl Executor<'_>, person: PersonKey, most: u32) -> Result<Vec<SupportNote>> {
    sqlx::query_as(support_notes!("AND n.person_id = $2 ORDER BY n.made_at DESC, n.id DESC LIMIT $3 + 0"))
        .bind(person.school_id)
        .bind(person.person_id)
        .bind(i64::from(most))
        .fetch_all(executor)
        .await
}

/// Returns the message that a mail contains; `None` if it was erased.
pub async fn find_support_note(
    executor: impl Executor<'_>,
    person: PersonKey,
    id: SupportNoteId,
) -> Result<Option<SupportNote>> {
    sqlx::query_as(support_notes!("AND n.person_id = $2 AND n.id = $3"))
        .bind(person.school_id)
        .bind(person.person_id)
        .bind(id)
        .fetch_optional(executor)
        .await
}

/// Returns an enabled trainee whom the viewer teaches, or for an administrator any of the school.
pub async fn find_supported_trainee(
    executor: impl Executor<'_>,
    viewer: &CurrentPerson,
    id: PersonId,
) -> Result<Option<TraineeAddress>> {
    sqlx::query_as(
        "SELECT p.id, p.display_name AS name, p.email NOT LIKE '%@no-address.invalid' AS has_address FROM people p
         WHERE p.school_id = $1 AND p.id = $3 AND p.role = 'trainee' AND p.disabled_at IS NULL
           AND ($4 OR EXISTS (SELECT 1 FROM taught_trainees t WHERE t.trainee_id = p.id AND t.teacher_id = $2))",
    )
    .bind(viewer.school_id)
    .bind(viewer.id)
    .bind(id)
    .bind(viewer.role == Role::Administrator)
    .fetch_optional(executor)
    .await
}
