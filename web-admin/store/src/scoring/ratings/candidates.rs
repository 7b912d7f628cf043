//! Possible raters and attempts for a round of ratings.

use model::Moment;
use model::ids::{AssignmentId, PersonId, SchoolId, SessionId};
use model::titles::StoredTitle;
use sqlx::FromRow;

use crate::{Executor, Result};

/// Maximum number of attempts to offer.
const OFFERED: u32 = 100;

/// A possible rater.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Rater {
    /// Id.
    pub id: PersonId,
    /// Name.
    pub name: String,
}

/// An attempt that can be rated.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct RateableAttempt {
    /// The attempt.
    pub id: SessionId,
    /// Name of the trainee.
    pub trainee: String,
    /// Title of the exercise, or its id.
    #[sqlx(try_from = "StoredTitle")]
    pub exercise: String,
    /// Start time.
    pub started_at: Moment,
}

/// Returns the instructors of a school who can sign in, sorted by name.
pub async fn raters(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<Rater>> {
    sqlx::query_as(
        "SELECT id, display_name AS name FROM people
         WHERE school_id = $1 AND role = 'instructor' AND disabled_at IS NULL AND erased_at IS NULL
         ORDER BY display_name, id",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Returns the scored attempts of an assignment's trainees at its exercise, or at any exercise of
/// its course, that were started after the assignment was made; latest first.
pub async fn of_assignment(
    executor: impl Executor<'_>,
    school: SchoolId,
    id: AssignmentId,
) -> Result<Vec<RateableAttempt>> {
    sqlx::query_as(
        "SELECT s.id, p.display_name AS trainee, coalesce(x.title, s.exercise_id) AS exercise, s.started_at
         FROM (SELECT n.id FROM (
             SELECT m.person_id FROM assignments b
               JOIN cohort_members m ON m.cohort_id = b.cohort_id AND m.role = 'trainee' WHERE b.id = $2
             UNION ALL SELECT c.person_id FROM assignments c WHERE c.id = $2 AND c.person_id IS NOT NULL) trained
           CROSS JOIN (SELECT exercise_id, made_at FROM assignments WHERE id = $2 AND exercise_id IS NOT NULL
             UNION ALL SELECT e.exercise_id, d.made_at FROM assignments d
               JOIN curricula u ON u.school_id = d.school_id AND u.curriculum_id = d.curriculum_id
               JOIN curriculum_entries e ON e.revision_id = u.revision_id WHERE d.id = $2) task
           CROSS JOIN sessions n
           WHERE n.school_id = $1 AND n.trainee_id = trained.person_id
             AND n.exercise_id = task.exercise_id AND n.started_at >= task.made_at AND n.state = 'scored'
             AND n.uncounted IS NULL ORDER BY n.started_at DESC, n.id LIMIT $3 + 0) chosen
         CROSS JOIN sessions s
         JOIN people p ON p.school_id = s.school_id AND p.id = s.trainee_id
         LEFT JOIN exercise_revisions x ON x.id = s.revision_id WHERE s.school_id = $1 AND s.id = chosen.id
         ORDER BY s.started_at DESC, s.id",
    )
    .bind(school)
    .bind(id)
    .bind(i64::from(OFFERED))
    .fetch_all(executor)
    .await
}
