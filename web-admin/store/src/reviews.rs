//! Attempts that wait to be looked at, and those that somebody has.

use model::ids::{PersonId, SessionId};
use model::{CurrentPerson, Moment, Role, SessionKey};
use sqlx::{FromRow, SqliteConnection, SqliteExecutor};

use super::Result;

/// Most attempts of the queue that are listed at once.
pub const LISTED: u32 = 50;

/// An attempt that waits.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct WaitingReview {
    /// Session.
    pub id: SessionId,
    /// When it began.
    pub started_at: Moment,
    /// Who tried.
    pub trainee: String,
    /// The exercise's title, or its id where this school never published it.
    pub exercise: String,
    /// The re-simulation differs.
    pub flagged: bool,
    /// 0–100, by the grade that counts.
    pub score: f64,
    /// Passed, by the grade that counts.
    pub passed: bool,
    /// Questions that nobody has answered.
    pub questions: i64,
}

/// Somebody has looked at an attempt.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Review {
    /// The name of whoever it was.
    pub by: String,
    /// When.
    pub reviewed_at: Moment,
}

macro_rules! waiting {
    ($chosen:literal) => {
        concat!(
            "SELECT s.id, s.started_at, p.display_name AS trainee, coalesce(r.title, s.exercise_id) AS exercise,
               coalesce(s.verify_flagged, 0) AS flagged, g.score, g.passed,
               (SELECT count(*) FROM comments c WHERE c.school_id = s.school_id AND c.session_id = s.id
                  AND c.kind = 'question' AND c.withdrawn_at IS NULL AND NOT EXISTS (
                    SELECT 1 FROM comments a WHERE a.school_id = c.school_id AND a.session_id = c.session_id
                      AND a.answers = c.id AND a.withdrawn_at IS NULL)) AS questions
             FROM (SELECT n.id FROM ",
            $chosen,
            " AND n.school_id = $1 AND n.state = 'scored' AND n.reviewed = 0
                ORDER BY n.verify_flagged DESC, n.started_at, n.id LIMIT $3) chosen
             CROSS JOIN sessions s ON s.school_id = $1 AND s.id = chosen.id
             JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
             JOIN people p ON p.school_id = s.school_id AND p.id = s.trainee_id
             LEFT JOIN exercise_revisions r ON r.id = s.revision_id
             ORDER BY s.verify_flagged DESC, s.started_at, s.id"
        )
    };
}

/// What waits for a person: flagged first, then the oldest; at most one more than [`LISTED`]. An instructor sees the
/// attempts of the cohorts they teach, an administrator those of all trainees.
pub async fn list_review_queue(
    executor: impl SqliteExecutor<'_>,
    viewer: &CurrentPerson,
) -> Result<Vec<WaitingReview>> {
    let statement = match viewer.role {
        Role::Administrator => {
            waiting!("sessions n WHERE (SELECT role FROM people WHERE people.id = n.trainee_id) = 'trainee'")
        }
        // A cross join keeps this order: from the few who are taught to their attempts, not through the whole queue.
        _ => waiting!(
            "(SELECT DISTINCT trainee_id AS person_id FROM taught_trainees WHERE teacher_id = $2) taught
             CROSS JOIN sessions n WHERE n.trainee_id = taught.person_id"
        ),
    };
    sqlx::query_as(statement).bind(viewer.school_id).bind(viewer.id).bind(LISTED + 1).fetch_all(executor).await
}

/// Marks an attempt as looked at. False where somebody has already.
///
/// # Errors
/// When attempt or person are of another school, or the database fails.
pub async fn mark_reviewed(
    writer: &mut SqliteConnection,
    session: SessionKey,
    by: PersonId,
    now: Moment,
) -> Result<bool> {
    sqlx::query(
        "INSERT INTO reviews (school_id, session_id, reviewed_by, reviewed_at) VALUES ($1, $2, $3, $4)
         ON CONFLICT (school_id, session_id) DO NOTHING",
    )
    .bind(session.school_id)
    .bind(session.id)
    .bind(by)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Puts an attempt back into the queue. False where it is there.
pub async fn unmark_reviewed(writer: &mut SqliteConnection, session: SessionKey) -> Result<bool> {
    sqlx::query("DELETE FROM reviews WHERE school_id = $1 AND session_id = $2")
        .bind(session.school_id)
        .bind(session.id)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Who has looked at an attempt.
pub async fn find_review(executor: impl SqliteExecutor<'_>, session: SessionKey) -> Result<Option<Review>> {
    sqlx::query_as(
        "SELECT p.display_name AS by, r.reviewed_at FROM reviews r
         JOIN people p ON p.school_id = r.school_id AND p.id = r.reviewed_by
         WHERE r.school_id = $1 AND r.session_id = $2",
    )
    .bind(session.school_id)
    .bind(session.id)
    .fetch_optional(executor)
    .await
}
