//! A school's attempts as research may have them: under pseudonyms, and of nobody who has not agreed where agreement is asked for.

use model::ids::{SchoolId, SessionId};
use model::{Moment, Role, Uncounted};
use sqlx::FromRow;

use super::sessions::SessionState;
use super::{Executor, Result};

/// An attempt without a name.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct ResearchAttempt {
    /// The attempt.
    pub id: SessionId,
    /// When it began.
    pub started_at: Moment,
    /// Whose it is.
    pub pseudonym: String,
    /// What they are at the school.
    pub role: Role,
    /// What was attempted.
    pub exercise_id: String,
    /// Hash of the exercise that was attempted.
    pub exercise_sha256: String,
    /// What became of it.
    pub state: SessionState,
    /// 0–100, by the grade that counts.
    pub score: Option<f64>,
    /// Passed, by the grade that counts.
    pub passed: Option<bool>,
    /// The computed score, 0–100.
    pub computed_score: Option<f64>,
    /// How long it took, in s.
    pub duration_s: f64,
    /// The recording has its end.
    pub complete: bool,
    /// With what.
    pub device: String,
    /// By which program.
    pub simulator_version: String,
    /// Why it counts nowhere; absent where it counts.
    pub uncounted: Option<Uncounted>,
    /// Its recording, relative to the recordings folder.
    pub recording_path: String,
}

/// Attempts after one of them in the order of their ids, at most `limit`: those of trainees, and those of staff who let their attempts be
/// used. A guest's are in their study, with what they have agreed to.
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

/// Attempts of a school that nobody gets: of guests, and of staff who have not agreed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct HeldBack {
    /// Of guests.
    pub of_guests: i64,
    /// Of staff.
    pub of_staff: i64,
}

/// Counts the attempts that [`list_research_attempts`] leaves out: people first, who are few, then their attempts.
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
