//! Participants of studies and their attempts.

use model::ids::{PersonId, SessionId, StudyId};
use model::{Moment, PersonKey, count_u32};
use sqlx::FromRow;

use super::Study;
use crate::{Connection, Executor, Json, Result};

/// A participant or invited person.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct StudyParticipant {
    /// Person.
    pub person_id: PersonId,
    /// Pseudonym, used in recordings and files.
    pub pseudonym: String,
    /// Name of a person of the school; `None` for a guest.
    pub name: Option<String>,
    /// Index of their group among the groups of the study.
    #[sqlx(try_from = "i64")]
    pub group_place: u32,
    /// Answers to the study's questions, in order.
    pub facts: Json<Vec<String>>,
    /// Time of consent; `None` while invited.
    pub agreed_at: Option<Moment>,
    /// Time at which they left or declined.
    pub withdrawn_at: Option<Moment>,
    /// A guest has an unused sign-in code.
    pub has_code: bool,
    /// Number of required attempts that were made.
    #[sqlx(try_from = "i64")]
    pub attempts: u32,
    /// Number of submitted responses to the study's surveys.
    #[sqlx(try_from = "i64")]
    pub answers: u32,
}

/// A person to be invited.
#[derive(Clone, Copy, Debug)]
pub struct NewParticipant<'a> {
    /// The study.
    pub study: &'a Study,
    /// Person.
    pub person_id: PersonId,
    /// Index of their group among the groups of the study.
    pub group_place: u32,
    /// Answers to the study's questions, in order.
    pub facts: &'a [String],
    /// Person who adds them.
    pub added_by: PersonId,
}

/// Invites a person to a study, also one who left it. Returns false if the person takes part or is
/// already invited.
///
/// # Errors
/// If one of the people belongs to another school, or the database fails.
pub async fn add_participant(writer: &mut Connection, new: NewParticipant<'_>, now: Moment) -> Result<bool> {
    sqlx::query(
        "INSERT INTO study_participants (school_id, study_id, person_id, group_place, facts, added_at, added_by, consented_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $6)
         ON CONFLICT (study_id, person_id) DO UPDATE SET group_place = excluded.group_place, facts = excluded.facts,
           added_at = excluded.added_at, added_by = excluded.added_by, consented_at = excluded.consented_at,
           agreed_at = NULL, withdrawn_at = NULL WHERE study_participants.withdrawn_at IS NOT NULL",
    )
    .bind(new.study.school_id)
    .bind(new.study.id)
    .bind(new.person_id)
    .bind(i64::from(new.group_place))
    .bind(Json(new.facts))
    .bind(now)
    .bind(new.added_by)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Selects the participants of study `$2` of school `$1`, with their progress.
macro_rules! participant {
    ($rest:literal) => {
        concat!(
            "SELECT t.person_id, p.pseudonym, CASE WHEN p.role <> 'guest' THEN p.display_name END AS name, t.group_place,
               t.facts, t.agreed_at, t.withdrawn_at,
               EXISTS (SELECT 1 FROM sign_in_codes c WHERE c.person_id = t.person_id AND p.role = 'guest') AS has_code,
               (SELECT CAST(coalesce(sum(min(n.made, u.attempts)), 0) AS BIGINT) FROM (
                 SELECT count(*) AS made FROM sessions s
                 JOIN study_exercises e ON e.study_id = t.study_id AND e.revision_id = s.revision_id
                 WHERE s.school_id = t.school_id AND s.trainee_id = t.person_id AND s.state = 'scored' AND s.uncounted IS DISTINCT FROM 'duplicate'
                   AND s.received_at >= t.agreed_at GROUP BY s.revision_id) n) AS attempts,
               (SELECT count(*) FROM surveys v JOIN survey_responses r ON r.survey_id = v.id AND r.person_id = t.person_id
                 WHERE v.school_id = t.school_id AND v.study_id = t.study_id AND r.state = 'submitted') AS answers
             FROM study_participants t JOIN studies u ON u.id = t.study_id
             JOIN people p ON p.school_id = t.school_id AND p.id = t.person_id
             WHERE t.school_id = $1 AND t.study_id = $2 ",
            $rest
        )
    };
}

/// Returns all current and former participants, by group, in the order of their invitation.
pub async fn list_participants(executor: impl Executor<'_>, study: &Study) -> Result<Vec<StudyParticipant>> {
    sqlx::query_as(participant!("ORDER BY t.group_place, t.added_at, t.person_id"))
        .bind(study.school_id)
        .bind(study.id)
        .fetch_all(executor)
        .await
}

/// Returns the number of current and former participants.
pub async fn count_participants(executor: impl Executor<'_>, study: &Study) -> Result<i64> {
    sqlx::query_scalar("SELECT count(*) FROM study_participants WHERE school_id = $1 AND study_id = $2")
        .bind(study.school_id)
        .bind(study.id)
        .fetch_one(executor)
        .await
}

/// Returns a participant or invited person who has not left.
pub async fn find_participant(
    executor: impl Executor<'_>,
    study: &Study,
    person: PersonId,
) -> Result<Option<StudyParticipant>> {
    sqlx::query_as(participant!("AND t.person_id = $3 AND t.withdrawn_at IS NULL"))
        .bind(study.school_id)
        .bind(study.id)
        .bind(person)
        .fetch_optional(executor)
        .await
}

/// Records the consent of an invited person and keeps an earlier one. Returns false if the person
/// is not invited.
pub async fn note_consent(writer: &mut Connection, study: &Study, person: PersonId, now: Moment) -> Result<bool> {
    sqlx::query(
        "UPDATE study_participants SET agreed_at = coalesce(agreed_at, $4)
         WHERE school_id = $1 AND study_id = $2 AND person_id = $3 AND withdrawn_at IS NULL",
    )
    .bind(study.school_id)
    .bind(study.id)
    .bind(person)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Removes a person from a study and deletes their answers to its questions and surveys. Returns
/// false if they do not take part.
pub async fn withdraw_participant(
    writer: &mut Connection,
    study: &Study,
    person: PersonId,
    now: Moment,
) -> Result<bool> {
    sqlx::query(
        "DELETE FROM survey_tags WHERE school_id = $1 AND response_id IN (SELECT r.id FROM surveys v
           JOIN survey_responses r ON r.survey_id = v.id AND r.person_id = $3
           WHERE v.school_id = $1 AND v.study_id = $2)",
    )
    .bind(study.school_id)
    .bind(study.id)
    .bind(person)
    .execute(&mut *writer)
    .await?;
    sqlx::query(
        "UPDATE survey_responses SET state = 'withdrawn', answers = '[]', submitted_at = NULL, consented_at = NULL,
           label = NULL, person_id = NULL, session_id = NULL
         WHERE school_id = $1 AND person_id = $3
           AND survey_id IN (SELECT id FROM surveys WHERE school_id = $1 AND study_id = $2)",
    )
    .bind(study.school_id)
    .bind(study.id)
    .bind(person)
    .execute(&mut *writer)
    .await?;
    sqlx::query(
        "UPDATE study_participants SET withdrawn_at = $4, facts = '[]'
         WHERE school_id = $1 AND study_id = $2 AND person_id = $3 AND withdrawn_at IS NULL",
    )
    .bind(study.school_id)
    .bind(study.id)
    .bind(person)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// A required attempt of a participant.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct StudyAttempt {
    /// Person.
    pub person_id: PersonId,
    /// The attempt.
    pub session_id: SessionId,
    /// Id of the exercise.
    pub exercise_id: String,
    /// Number of the person's attempt at this exercise, from 1.
    #[sqlx(try_from = "i64")]
    pub number: u32,
    /// Start time.
    pub started_at: Moment,
    /// Effective score, 0–100.
    pub score: f64,
    /// Passed, by the effective grade.
    pub passed: bool,
}

/// Returns the scored attempts of a study, sorted by group, person and time.
pub async fn list_study_attempts(executor: impl Executor<'_>, study: &Study) -> Result<Vec<StudyAttempt>> {
    sqlx::query_as(
        "SELECT person_id, session_id, exercise_id, number, started_at, score, passed FROM (
           SELECT t.group_place, t.added_at, t.person_id, s.id AS session_id, s.exercise_id, s.started_at, g.score, g.passed,
             row_number() OVER (PARTITION BY t.person_id, s.revision_id ORDER BY s.started_at, s.id) AS number
           FROM study_participants t CROSS JOIN sessions s
           JOIN study_exercises e ON e.study_id = $2 AND e.revision_id = s.revision_id
           JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
           WHERE s.school_id = $1 AND s.trainee_id = t.person_id
             AND s.state = 'scored' AND s.uncounted IS DISTINCT FROM 'duplicate' AND s.received_at >= t.agreed_at AND t.school_id = $1
             AND t.study_id = $2 AND t.withdrawn_at IS NULL) numbered
         WHERE number <= $3 ORDER BY group_place, added_at, person_id, started_at, session_id",
    )
    .bind(study.school_id)
    .bind(study.id)
    .bind(i64::from(study.attempts))
    .fetch_all(executor)
    .await
}

/// Returns the number of attempts that a person still has to make for a study.
pub async fn count_open_attempts(
    executor: impl Executor<'_>,
    PersonKey { school_id: school, person_id: person }: PersonKey,
    study: StudyId,
) -> Result<u32> {
    sqlx::query_scalar(
        "SELECT CAST(coalesce(sum(max(0, u.attempts - (SELECT count(*) FROM sessions s
             WHERE s.school_id = $1 AND s.trainee_id = $2 AND s.revision_id = e.revision_id AND s.uncounted IS DISTINCT FROM 'duplicate'
               AND s.received_at >= t.agreed_at))), 0) AS BIGINT)
         FROM study_participants t JOIN studies u ON u.id = t.study_id
         JOIN study_exercises e ON e.study_id = t.study_id
         WHERE t.school_id = $1 AND t.person_id = $2 AND t.study_id = $3 AND t.agreed_at IS NOT NULL
           AND t.withdrawn_at IS NULL",
    )
    .bind(school)
    .bind(person)
    .bind(study)
    .fetch_one(executor)
    .await
    .map(count_u32::<i64>)
}

/// Returns the exercises of the open studies that a person takes part in.
pub async fn list_studied_exercises(
    executor: impl Executor<'_>,
    PersonKey { school_id: school, person_id: person }: PersonKey,
) -> Result<Vec<String>> {
    sqlx::query_scalar(
        "SELECT DISTINCT r.exercise_id FROM study_participants t
         JOIN studies u ON u.id = t.study_id AND u.closed_at IS NULL
         JOIN study_exercises e ON e.study_id = t.study_id
         JOIN exercise_revisions r ON r.school_id = e.school_id AND r.id = e.revision_id
         WHERE t.school_id = $1 AND t.person_id = $2 AND t.agreed_at IS NOT NULL AND t.withdrawn_at IS NULL",
    )
    .bind(school)
    .bind(person)
    .fetch_all(executor)
    .await
}
