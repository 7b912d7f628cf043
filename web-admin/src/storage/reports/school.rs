//! A school as a whole: exercises, counts, people.

use sqlx::{FromRow, SqliteExecutor};
use uuid::Uuid;

use super::Named;
use crate::domain::{Moment, Role};
use crate::storage::Result;

/// An exercise in short, in the revision that trainees are given.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct ExerciseInShort {
    /// Exercise id.
    pub exercise_id: String,
    /// Score needed to pass, 0–100.
    pub pass_mark: f64,
    /// Difficulty, 1–5.
    pub difficulty: u8,
}

/// The exercises a school gives to trainees.
///
/// # Errors
/// When the database fails.
pub async fn exercises(executor: impl SqliteExecutor<'_>, school: Uuid) -> Result<Vec<ExerciseInShort>> {
    sqlx::query_as(
        "SELECT e.exercise_id, r.pass_mark, r.difficulty FROM exercises e
         JOIN exercise_revisions r ON r.id = e.revision_id WHERE e.school_id = $1",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// The school at a glance.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Counts {
    /// The school's name.
    pub school: String,
    /// People who may sign in, by role.
    pub trainees: i64,
    /// As `trainees`.
    pub instructors: i64,
    /// As `trainees`.
    pub administrators: i64,
    /// Scored attempts.
    pub attempts: i64,
    /// Attempts begun since a moment.
    pub recent: i64,
    /// Recordings in the queue.
    pub waiting: i64,
    /// Recordings that could not be scored.
    pub refused: i64,
    /// Recordings whose re-simulation differs.
    pub flagged: i64,
}

/// Counts of a school; `since` bounds the recent ones.
///
/// # Errors
/// When the database fails.
pub async fn counts(executor: impl SqliteExecutor<'_>, school: Uuid, since: Moment) -> Result<Counts> {
    sqlx::query_as(
        "SELECT s.name AS school,
           (SELECT count(*) FROM people p WHERE p.school_id = s.id AND p.role = 'trainee' AND p.disabled_at IS NULL)
             AS trainees,
           (SELECT count(*) FROM people p WHERE p.school_id = s.id AND p.role = 'instructor' AND p.disabled_at IS NULL)
             AS instructors,
           (SELECT count(*) FROM people p
             WHERE p.school_id = s.id AND p.role = 'administrator' AND p.disabled_at IS NULL) AS administrators,
           (SELECT coalesce(sum(t.attempts), 0) FROM tallies t
             WHERE t.school_id = s.id AND t.cohort_id = zeroblob(16)) AS attempts,
           (SELECT count(*) FROM sessions a WHERE a.school_id = s.id AND a.started_at >= $2) AS recent,
           (SELECT count(*) FROM jobs j WHERE j.school_id = s.id) AS waiting,
           (SELECT count(*) FROM sessions a WHERE a.school_id = s.id AND a.state = 'refused') AS refused,
           (SELECT count(*) FROM sessions a WHERE a.school_id = s.id AND a.verify_flagged = 1) AS flagged
         FROM schools s WHERE s.id = $1",
    )
    .bind(school)
    .bind(since)
    .fetch_one(executor)
    .await
}

/// A job that was tried and is not done.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct FailingJob {
    /// Session.
    pub session_id: Uuid,
    /// How often it was tried.
    pub attempts: i64,
    /// What went wrong last.
    pub error: String,
}

/// The jobs of a school that failed at least once, at most 50.
///
/// # Errors
/// When the database fails.
pub async fn failing_jobs(executor: impl SqliteExecutor<'_>, school: Uuid) -> Result<Vec<FailingJob>> {
    sqlx::query_as(
        "SELECT session_id, attempts, coalesce(error, '') AS error FROM jobs
         WHERE school_id = $1 AND attempts > 0 ORDER BY next_run_at, session_id LIMIT 50",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// A person as the administrator sees them.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct ListedPerson {
    /// Id.
    pub id: Uuid,
    /// Name.
    pub display_name: String,
    /// Address.
    pub email: String,
    /// Role.
    pub role: Role,
    /// May sign in.
    pub enabled: bool,
    /// Upload tokens that are valid.
    pub tokens: i64,
}

/// Everybody of a school, by name.
///
/// # Errors
/// When the database fails.
pub async fn people(executor: impl SqliteExecutor<'_>, school: Uuid) -> Result<Vec<ListedPerson>> {
    sqlx::query_as(
        "SELECT p.id, p.display_name, p.email, p.role, p.disabled_at IS NULL AS enabled,
           (SELECT count(*) FROM api_tokens t
             WHERE t.school_id = p.school_id AND t.person_id = p.id AND t.revoked_at IS NULL) AS tokens
         FROM people p WHERE p.school_id = $1 ORDER BY p.display_name, p.id",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Who is in which cohort of a school: the person, and the cohort's name.
///
/// # Errors
/// When the database fails.
pub async fn memberships(executor: impl SqliteExecutor<'_>, school: Uuid) -> Result<Vec<Named>> {
    sqlx::query_as(
        "SELECT m.person_id AS id, c.name FROM cohort_members m
         JOIN cohorts c ON c.school_id = m.school_id AND c.id = m.cohort_id
         WHERE m.school_id = $1 ORDER BY c.name",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}
