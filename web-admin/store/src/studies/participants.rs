//! Who takes part in a study, and the attempts that they make for it.

use model::ids::{PersonId, SessionId, StudyId};
use model::{Moment, PersonKey, count_u32};
use sqlx::FromRow;

use super::Study;
use crate::{Connection, Executor, Json, Result};

/// Somebody who takes part.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct StudyParticipant {
    /// Who.
    pub person_id: PersonId,
    /// What recordings and files say of them.
    pub pseudonym: String,
    /// The name of somebody of the school; a guest has none.
    pub name: Option<String>,
    /// The place of their group in the study's.
    #[sqlx(try_from = "i64")]
    pub group_place: u32,
    /// What the study asked them, in the order of its questions.
    pub facts: Json<Vec<String>>,
    /// When the person consented; absent while invited.
    pub agreed_at: Option<Moment>,
    /// When they left or declined.
    pub withdrawn_at: Option<Moment>,
    /// A guest's code that was not used yet.
    pub has_code: bool,
    /// Attempts made, of those that are asked.
    #[sqlx(try_from = "i64")]
    pub attempts: u32,
    /// Answers sent to what the study asks.
    #[sqlx(try_from = "i64")]
    pub answers: u32,
}

/// A person to invite.
#[derive(Clone, Copy, Debug)]
pub struct NewParticipant<'a> {
    /// The study.
    pub study: &'a Study,
    /// Who.
    pub person_id: PersonId,
    /// The place of their group in the study's.
    pub group_place: u32,
    /// What the study asked them, in the order of its questions.
    pub facts: &'a [String],
    /// Who added them.
    pub added_by: PersonId,
}

/// Invites a person to a study, also one who had left. Returns false if the person takes part or is invited already.
///
/// # Errors
/// When somebody is of another school, or the database fails.
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

/// Who takes part in a study $2 of a school $1, and how far each has come.
macro_rules! participant {
    ($rest:literal) => {
        concat!(
            "SELECT t.person_id, p.pseudonym, CASE WHEN p.role <> 'guest' THEN p.display_name END AS name, t.group_place,
               t.facts, t.agreed_at, t.withdrawn_at,
               EXISTS (SELECT 1 FROM sign_in_codes c WHERE c.person_id = t.person_id AND p.role = 'guest') AS has_code,
               (SELECT CAST(coalesce(sum(min(n.made, u.attempts)), 0) AS BIGINT) FROM (
                 SELECT count(*) AS made FROM sessions s
                 JOIN study_exercises e ON e.study_id = t.study_id AND e.revision_id = s.revision_id
                 WHERE s.school_id = t.school_id AND s.trainee_id = t.person_id AND s.uncounted IS NULL
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

/// Everybody who takes part or has left, by group, in the order in which they came.
pub async fn list_participants(executor: impl Executor<'_>, study: &Study) -> Result<Vec<StudyParticipant>> {
    sqlx::query_as(participant!("ORDER BY t.group_place, t.added_at, t.person_id"))
        .bind(study.school_id)
        .bind(study.id)
        .fetch_all(executor)
        .await
}

/// How many take part in a study, or have left it.
pub async fn count_participants(executor: impl Executor<'_>, study: &Study) -> Result<i64> {
    sqlx::query_scalar("SELECT count(*) FROM study_participants WHERE school_id = $1 AND study_id = $2")
        .bind(study.school_id)
        .bind(study.id)
        .fetch_one(executor)
        .await
}

/// Somebody who takes part or is asked to, and has not left.
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

/// Records that an invited person has consented; an earlier consent stays. Returns false if the person is not invited.
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

/// Takes somebody out of a study, with what they told and answered for it. False where they do not take part.
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

/// An attempt of a study: one of those that are asked of somebody who takes part.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct StudyAttempt {
    /// Who.
    pub person_id: PersonId,
    /// The attempt.
    pub session_id: SessionId,
    /// At which exercise.
    pub exercise_id: String,
    /// Their how-manieth at it, from 1.
    #[sqlx(try_from = "i64")]
    pub number: u32,
    /// When it began.
    pub started_at: Moment,
    /// 0–100, by the grade that counts.
    pub score: f64,
    /// Passed, by the grade that counts.
    pub passed: bool,
}

/// The scored attempts of a study, person by person in the order of their groups, in order of time.
pub async fn list_study_attempts(executor: impl Executor<'_>, study: &Study) -> Result<Vec<StudyAttempt>> {
    sqlx::query_as(
        "SELECT person_id, session_id, exercise_id, number, started_at, score, passed FROM (
           SELECT t.group_place, t.added_at, t.person_id, s.id AS session_id, s.exercise_id, s.started_at, g.score, g.passed,
             row_number() OVER (PARTITION BY t.person_id, s.revision_id ORDER BY s.started_at, s.id) AS number
           FROM study_participants t CROSS JOIN sessions s
           JOIN study_exercises e ON e.study_id = $2 AND e.revision_id = s.revision_id
           JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
           WHERE s.school_id = $1 AND s.trainee_id = t.person_id
             AND s.state = 'scored' AND s.uncounted IS NULL AND s.received_at >= t.agreed_at AND t.school_id = $1
             AND t.study_id = $2 AND t.withdrawn_at IS NULL) numbered
         WHERE number <= $3 ORDER BY group_place, added_at, person_id, started_at, session_id",
    )
    .bind(study.school_id)
    .bind(study.id)
    .bind(i64::from(study.attempts))
    .fetch_all(executor)
    .await
}

/// How many attempts somebody has yet to make for a study.
pub async fn count_open_attempts(
    executor: impl Executor<'_>,
    PersonKey { school_id: school, person_id: person }: PersonKey,
    study: StudyId,
) -> Result<u32> {
    sqlx::query_scalar(
        "SELECT CAST(coalesce(sum(max(0, u.attempts - (SELECT count(*) FROM sessions s
             WHERE s.school_id = $1 AND s.trainee_id = $2 AND s.revision_id = e.revision_id AND s.uncounted IS NULL
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

/// The exercises of the open studies that somebody takes part in.
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
