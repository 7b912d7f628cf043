//! Notices of new events for a person until they are read, and whether they are mailed.

use model::ids::{AssignmentId, CommentId, NoticeId, PersonId, RoundId, SchoolId, SessionId, SupportNoteId};
use model::letters::notice::{Notice, NoticeKind, NoticePlace};
use model::{Moment, PersonKey, SessionKey, count_u32};
use sqlx::FromRow;

use crate::{Connection, Executor, Json, Result};

/// A notice to be stored.
#[derive(Clone, Copy, Debug)]
pub struct NewNotice {
    /// Recipient.
    pub whom: PersonKey,
    /// Kind of notice.
    pub kind: NoticeKind,
    /// Person who caused it.
    pub by: PersonId,
    /// The attempt.
    pub session_id: Option<SessionId>,
    /// The comment or reply.
    pub comment_id: Option<CommentId>,
    /// The assignment.
    pub assignment_id: Option<AssignmentId>,
    /// The round of ratings.
    pub round_id: Option<RoundId>,
    /// The record that contains a message.
    pub note_id: Option<SupportNoteId>,
}

/// Stores a notice.
///
/// # Errors
/// If one of the objects belongs to another school, or the database fails.
pub async fn add_notice(writer: &mut Connection, new: NewNotice, now: Moment) -> Result<()> {
    sqlx::query(
        "INSERT INTO notices (id, school_id, person_id, kind, by_id, session_id, comment_id, assignment_id, round_id, note_id, made_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11)",
    )
    .bind(NoticeId::made_at(now))
    .bind(new.whom.school_id)
    .bind(new.whom.person_id)
    .bind(new.kind)
    .bind(new.by)
    .bind(new.session_id)
    .bind(new.comment_id)
    .bind(new.assignment_id)
    .bind(new.round_id)
    .bind(new.note_id)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the instructors of a trainee's cohorts.
pub async fn list_teachers_of(executor: impl Executor<'_>, trainee: PersonKey) -> Result<Vec<PersonId>> {
    sqlx::query_scalar(
        "SELECT DISTINCT teacher.person_id FROM cohort_members own
         CROSS JOIN cohort_members teacher
         WHERE teacher.cohort_id = own.cohort_id AND teacher.role = 'instructor' AND own.school_id = $1
         AND own.person_id = $2 AND own.role = 'trainee'",
    )
    .bind(trainee.school_id)
    .bind(trainee.person_id)
    .fetch_all(executor)
    .await
}

/// Returns the participants of a comment thread who may still see the attempt: the author, those
/// who replied, and the trainee.
pub async fn list_speakers_on(
    executor: impl Executor<'_>,
    session: SessionKey,
    comment: CommentId,
) -> Result<Vec<PersonId>> {
    sqlx::query_scalar(
        "SELECT c.author_id FROM comments c
         JOIN sessions s ON s.school_id = c.school_id AND s.id = c.session_id
         JOIN people p ON p.school_id = c.school_id AND p.id = c.author_id
         WHERE c.school_id = $1 AND c.session_id = $2 AND (c.id = $3 OR c.answers = $3) AND c.withdrawn_at IS NULL
           AND p.disabled_at IS NULL AND (p.role = 'administrator' OR p.id = s.trainee_id OR EXISTS (
             SELECT 1 FROM taught_trainees t WHERE t.trainee_id = s.trainee_id AND t.teacher_id = p.id))
         UNION SELECT trainee_id FROM sessions WHERE school_id = $1 AND id = $2",
    )
    .bind(session.school_id)
    .bind(session.id)
    .bind(comment)
    .fetch_all(executor)
    .await
}

/// Returns the trainees of an assignment.
pub async fn list_assignees(
    executor: impl Executor<'_>,
    school: SchoolId,
    assignment: AssignmentId,
) -> Result<Vec<PersonId>> {
    sqlx::query_scalar(
        "SELECT m.person_id FROM assignments a
         CROSS JOIN cohort_members m
         WHERE m.cohort_id = a.cohort_id AND m.role = 'trainee' AND a.school_id = $1 AND a.id = $2
         UNION SELECT person_id FROM assignments WHERE school_id = $1 AND id = $2 AND person_id IS NOT NULL",
    )
    .bind(school)
    .bind(assignment)
    .fetch_all(executor)
    .await
}

/// Returns the person who made an assignment, unless they have an unread notice about a grade of it
/// that was refused.
pub async fn find_unaware_maker(
    executor: impl Executor<'_>,
    school: SchoolId,
    assignment: AssignmentId,
) -> Result<Option<PersonId>> {
    sqlx::query_scalar(
        "SELECT a.made_by FROM assignments a WHERE a.school_id = $1 AND a.id = $2 AND NOT EXISTS (
           SELECT 1 FROM notices n WHERE n.school_id = a.school_id AND n.person_id = a.made_by AND n.kind = 'delivery'
             AND n.assignment_id = a.id AND n.read_at IS NULL)",
    )
    .bind(school)
    .bind(assignment)
    .fetch_optional(executor)
    .await
}

/// An attempt of a round and its trainee; without an attempt, the person who created the round.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct RoundPart {
    /// The person.
    pub person_id: PersonId,
    /// The attempt.
    pub session_id: Option<SessionId>,
}

/// Returns the people whom the result of a round concerns. Empty until all ratings are finished.
/// Candidates of an exam are left out: they see their result when the exam is closed.
pub async fn list_round_parts(executor: impl Executor<'_>, school: SchoolId, round: RoundId) -> Result<Vec<RoundPart>> {
    sqlx::query_as(
        "SELECT o.made_by AS person_id, NULL AS session_id FROM rating_rounds o
         WHERE o.school_id = $1 AND o.id = $2 AND o.withdrawn_at IS NULL
           AND NOT EXISTS (SELECT 1 FROM ratings r WHERE r.round_id = o.id AND r.finished_at IS NULL)
         UNION SELECT s.trainee_id, s.id FROM ratings r
         CROSS JOIN sessions s
         WHERE s.school_id = $1 AND s.id = r.session_id AND r.round_id = $2
           AND NOT EXISTS (SELECT 1 FROM ratings q WHERE q.round_id = $2 AND q.finished_at IS NULL)
           AND NOT EXISTS (SELECT 1 FROM exams x WHERE x.round_id = $2)",
    )
    .bind(school)
    .bind(round)
    .fetch_all(executor)
    .await
}

/// Returns a person's unread notices, newest first.
pub async fn list_unread_notices(executor: impl Executor<'_>, person: PersonKey, most: u32) -> Result<Vec<Notice>> {
    sqlx::query_as(
        "SELECT n.kind, b.display_name AS by, n.session_id, n.comment_id, coalesce(c.from_s, q.from_s) AS from_s, n.round_id,
           coalesce(x.title, s.exercise_id, r.title, u.title, o.title, w.subject, '') AS title, n.made_at
         FROM notices n
         JOIN people b ON b.school_id = n.school_id AND b.id = n.by_id
         LEFT JOIN sessions s ON s.school_id = n.school_id AND s.id = n.session_id
         LEFT JOIN exercise_revisions x ON x.id = s.revision_id
         LEFT JOIN comments c ON c.id = n.comment_id
         LEFT JOIN comments q ON q.id = c.answers
         LEFT JOIN assignments a ON a.id = n.assignment_id
         LEFT JOIN exercises e ON e.school_id = a.school_id AND e.exercise_id = a.exercise_id
         LEFT JOIN exercise_revisions r ON r.id = e.revision_id
         LEFT JOIN curricula k ON k.school_id = a.school_id AND k.curriculum_id = a.curriculum_id
         LEFT JOIN curriculum_revisions u ON u.id = k.revision_id
         LEFT JOIN rating_rounds o ON o.id = n.round_id
         LEFT JOIN support_notes w ON w.id = n.note_id
         WHERE n.school_id = $1 AND n.person_id = $2 AND n.read_at IS NULL
         ORDER BY n.made_at DESC, n.id DESC LIMIT $3 + 0",
    )
    .bind(person.school_id)
    .bind(person.person_id)
    .bind(i64::from(most))
    .fetch_all(executor)
    .await
}

/// Returns the number of unread notices that a page marks as read.
pub async fn count_unread_at(executor: impl Executor<'_>, person: PersonKey, place: NoticePlace) -> Result<u32> {
    sqlx::query_scalar(
        "SELECT count(*) FROM notices WHERE school_id = $1 AND person_id = $2 AND read_at IS NULL
           AND ($3 IS NULL OR session_id = $3) AND ($4 IS NULL OR round_id = $4)
           AND kind IN (SELECT value FROM json_each($5))",
    )
    .bind(person.school_id)
    .bind(person.person_id)
    .bind(place.session())
    .bind(place.round())
    .bind(kinds_at(place))
    .fetch_one(executor)
    .await
    .map(count_u32::<i64>)
}

fn kinds_at(place: NoticePlace) -> Json<Vec<&'static str>> {
    Json(place.kinds().iter().map(|kind| kind.word()).collect())
}

/// Marks the notices of a page as read.
pub async fn mark_notices_read(
    writer: &mut Connection,
    person: PersonKey,
    place: NoticePlace,
    now: Moment,
) -> Result<()> {
    sqlx::query(
        "UPDATE notices SET read_at = $6 WHERE school_id = $1 AND person_id = $2 AND read_at IS NULL
           AND ($3 IS NULL OR session_id = $3) AND ($4 IS NULL OR round_id = $4)
           AND kind IN (SELECT value FROM json_each($5))",
    )
    .bind(person.school_id)
    .bind(person.person_id)
    .bind(place.session())
    .bind(place.round())
    .bind(kinds_at(place))
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Deletes the notices of a withdrawn comment and of the replies to it.
pub async fn forget_comment_notices(writer: &mut Connection, session: SessionKey, comment: CommentId) -> Result<()> {
    sqlx::query(
        "DELETE FROM notices WHERE school_id = $1 AND session_id = $2 AND comment_id IN (
           SELECT id FROM comments WHERE school_id = $1 AND session_id = $2 AND (id = $3 OR answers = $3))",
    )
    .bind(session.school_id)
    .bind(session.id)
    .bind(comment)
    .execute(writer)
    .await
    .map(drop)
}

/// Deletes the notices of a withdrawn assignment.
pub async fn forget_assignment_notices(
    writer: &mut Connection,
    school: SchoolId,
    assignment: AssignmentId,
) -> Result<()> {
    sqlx::query("DELETE FROM notices WHERE school_id = $1 AND assignment_id = $2")
        .bind(school)
        .bind(assignment)
        .execute(writer)
        .await
        .map(drop)
}

#[derive(FromRow)]
struct ReaderRow {
    school_id: SchoolId,
    person_id: PersonId,
}

/// Limits for notices and recipients of the news mail that is due now.
#[derive(Clone, Copy, Debug)]
pub struct LetterTimes {
    /// Notices made earlier are no longer mailed.
    pub from: Moment,
    /// Notices made later wait, so that several are mailed together.
    pub to: Moment,
    /// A person who was mailed later than this waits for the next day.
    pub last: Moment,
}

/// Returns people who are due to be mailed their unread notices.
pub async fn list_awaited_letters(
    executor: impl Executor<'_>,
    times: LetterTimes,
    most: u32,
) -> Result<Vec<PersonKey>> {
    let rows: Vec<ReaderRow> = sqlx::query_as(
        "SELECT DISTINCT n.school_id, n.person_id FROM notices n
         JOIN people p ON p.school_id = n.school_id AND p.id = n.person_id
         WHERE n.read_at IS NULL AND n.mailed_at IS NULL AND n.made_at BETWEEN $1 AND $2
           AND p.mail_news = 1 AND p.disabled_at IS NULL AND p.password_hash <> ''
           AND NOT EXISTS (SELECT 1 FROM mails m WHERE m.school_id = n.school_id AND m.person_id = n.person_id
             AND m.kind = 'news' AND (m.next_run_at IS NOT NULL OR m.sent_at > $3))
         LIMIT $4 + 0",
    )
    .bind(times.from)
    .bind(times.to)
    .bind(times.last)
    .bind(i64::from(most))
    .fetch_all(executor)
    .await?;
    Ok(rows.into_iter().map(|row| PersonKey { school_id: row.school_id, person_id: row.person_id }).collect())
}

/// Records that all unread notices of a person are in a mail.
pub async fn mark_notices_mailed(writer: &mut Connection, person: PersonKey, now: Moment) -> Result<()> {
    sqlx::query(
        "UPDATE notices SET mailed_at = $3 WHERE school_id = $1 AND person_id = $2 AND read_at IS NULL AND mailed_at IS NULL",
    )
    .bind(person.school_id)
    .bind(person.person_id)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns whether a person receives mails about new notices.
pub async fn wants_news_letters(executor: impl Executor<'_>, person: PersonKey) -> Result<bool> {
    sqlx::query_scalar("SELECT mail_news FROM people WHERE school_id = $1 AND id = $2")
        .bind(person.school_id)
        .bind(person.person_id)
        .fetch_one(executor)
        .await
}

/// Records that a message is mailed by itself, so that no mail of news repeats it.
pub async fn mark_message_mailed(
    writer: &mut Connection,
    person: PersonKey,
    note: SupportNoteId,
    now: Moment,
) -> Result<()> {
    sqlx::query("UPDATE notices SET mailed_at = $4 WHERE school_id = $1 AND person_id = $2 AND note_id = $3")
        .bind(person.school_id)
        .bind(person.person_id)
        .bind(note)
        .bind(now)
        .execute(writer)
        .await
        .map(drop)
}

/// Sets whether a person receives mails about new notices.
pub async fn set_news_letters(writer: &mut Connection, person: PersonKey, wanted: bool) -> Result<()> {
    sqlx::query("UPDATE people SET mail_news = $3 WHERE school_id = $1 AND id = $2")
        .bind(person.school_id)
        .bind(person.person_id)
        .bind(wanted)
        .execute(writer)
        .await
        .map(drop)
}
