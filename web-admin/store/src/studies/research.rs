//! A school's attempts for research: pseudonymous, and without those of people whose consent is
//! required and missing.

use model::ids::{SchoolId, SessionId};
use model::{Moment, Role, Uncounted};
use sqlx::FromRow;

use crate::recordings::sessions::SessionState;
use crate::{Executor, Result};

/// An attempt without names.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct ResearchAttempt {
    /// The attempt.
    pub id: SessionId,
    /// Start time.
    pub started_at: Moment,
    /// Pseudonym of the person who made it.
    pub pseudonym: String,
    /// Role of that person.
    pub role: Role,
    /// Id of the exercise.
    pub exercise_id: String,
    /// SHA-256 of the exercise document.
    pub exercise_sha256: String,
    /// State.
    pub state: SessionState,
    /// Effective score, 0–100.
    pub score: Option<f64>,
    /// Passed, by the effective grade.
    pub passed: Option<bool>,
    /// Computed score, 0–100.
    pub computed_score: Option<f64>,
    /// Duration, in s.
    pub duration_s: f64,
    /// The recording is complete.
    pub complete: bool,
    /// Device.
    pub device: String,
    /// Version of the simulator.
    pub simulator_version: String,
    /// Reason why it does not count; `None` if it counts.
    pub uncounted: Option<Uncounted>,
    /// Path of the recording, relative to the recordings folder.
    pub recording_path: String,
}

/// Returns attempts after one of them, in the order of their ids; at most `limit`. It includes
/// those of trainees and of staff who consented. Attempts of guests belong to their study and its
/// consent.
pub async fn list_research_attempts(
    executor: impl Executor<'_>,
    school: SchoolId,
    after: SessionId,
    limit: u32,
) -> Result<Vec<ResearchAttempt>> {
    sqlx::query_as(
        "SELECT s.id, s.started_at, p.pseudonym, p.role, s.exercise_id, s.exercise_sha256, s.state, g.score, g.passed,
           c.score AS computed_score, s.duration_s, s.complete, s.device, s.simulator_version, s.uncounted, s.recording_path
         FROM sessions s
         JOIN people p ON p.school_id = s.school_id AND p.id = s.trainee_id
         LEFT JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
         LEFT JOIN scores c ON c.id = g.score_id
         WHERE s.school_id = $1 AND s.id > $2 AND (p.role = 'trainee' OR (p.role <> 'guest' AND EXISTS (
           SELECT 1 FROM expert_declarations d
           WHERE d.school_id = s.school_id AND d.person_id = s.trainee_id AND d.withdrawn_at IS NULL)))
         ORDER BY s.id LIMIT $3 + 0",
    )
    .bind(school)
    .bind(after)
    .bind(i64::from(limit))
    .fetch_all(executor)
    .await
}

/// Number of attempts left out: of guests, and of staff without consent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct HeldBack {
    /// Attempts of guests.
    pub of_guests: i64,
    /// Attempts of staff without consent.
    pub of_staff: i64,
}

/// Counts the attempts that [`list_research_attempts`] leaves out. The query starts from the
/// people, who are few, and goes on to their attempts.
pub async fn count_held_back(executor: impl Executor<'_>, school: SchoolId) -> Result<HeldBack> {
    sqlx::query_as(
        "SELECT coalesce(sum(iif(p.role = 'guest', 1, 0)), 0) AS of_guests,
           coalesce(sum(iif(p.role <> 'guest', 1, 0)), 0) AS of_staff
         FROM people p CROSS JOIN sessions s
         WHERE s.school_id = p.school_id AND s.trainee_id = p.id AND p.school_id = $1
         AND (p.role = 'guest' OR (p.role <> 'trainee' AND NOT EXISTS (
           SELECT 1 FROM expert_declarations d
           WHERE d.school_id = p.school_id AND d.person_id = p.id AND d.withdrawn_at IS NULL)))",
    )
    .bind(school)
    .fetch_one(executor)
    .await
}
