//! Queue of attempts waiting for review, and completed reviews.

use model::ids::{PersonId, SessionId};
use model::scoring::review::{QueuePlace, ReviewFilter};
use model::titles::StoredTitle;
use model::{AttemptPlace, CurrentPerson, Moment, Role, SessionKey, count_u32};
use sqlx::FromRow;

use crate::{Connection, Executor, Pool, Result};

/// Maximum number of attempts listed at once.
pub const LISTED: u32 = 50;

/// An attempt waiting for review.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct WaitingReview {
    /// Session.
    pub id: SessionId,
    /// Start time.
    pub started_at: Moment,
    /// Name of the trainee.
    pub trainee: String,
    /// Title of the exercise, or its id if this school never published it.
    #[sqlx(try_from = "StoredTitle")]
    pub exercise: String,
    /// The re-simulation differs.
    pub flagged: bool,
    /// Effective score, 0–100.
    pub score: f64,
    /// Passed, by the effective grade.
    pub passed: bool,
    /// Number of unanswered questions.
    pub questions: i64,
    /// Priority; see [`ReviewFilter::ranks`].
    #[sqlx(try_from = "i64")]
    pub rank: u32,
}

/// A completed review.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Review {
    /// Name of the reviewer.
    pub by: String,
    /// Time of the review.
    pub reviewed_at: Moment,
}

macro_rules! waiting {
    ($chosen:literal) => {
        concat!(
            "SELECT s.id, s.started_at, p.display_name AS trainee, coalesce(r.title, s.exercise_id) AS exercise,
               coalesce(s.verify_flagged, FALSE) AS flagged, g.score, g.passed, s.review_rank AS rank,
               (SELECT count(*) FROM comments c WHERE c.school_id = s.school_id AND c.session_id = s.id
                  AND c.kind = 'question' AND c.withdrawn_at IS NULL AND NOT EXISTS (
                    SELECT 1 FROM comments a WHERE a.school_id = c.school_id AND a.session_id = c.session_id
                      AND a.answers = c.id AND a.withdrawn_at IS NULL)) AS questions
             FROM (SELECT n.id FROM ",
            $chosen,
            " AND ($8 IS NULL OR n.exercise_id = $8) AND n.school_id = $1 AND n.state = 'scored' AND n.reviewed = 0 AND n.review_rank = $4
                AND (n.started_at, n.id) > ($5, $6) ORDER BY n.started_at, n.id LIMIT $3 + 0) chosen
             CROSS JOIN sessions s
             JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
             JOIN people p ON p.school_id = s.school_id AND p.id = s.trainee_id
             LEFT JOIN exercise_revisions r ON r.id = s.revision_id WHERE s.school_id = $1 AND s.id = chosen.id
             ORDER BY s.started_at, s.id"
        )
    };
}

/// Returns the attempts waiting for a person's review, after a position in the queue: first those
/// with questions, then flagged ones, then failed ones, each with the oldest first; at most one
/// more than [`LISTED`]. An instructor sees the attempts of their cohorts, an administrator those
/// of all trainees.
pub async fn list_review_queue(
    reader: &Pool,
    viewer: &CurrentPerson,
    filter: &ReviewFilter,
    after: Option<QueuePlace>,
) -> Result<Vec<WaitingReview>> {
    let mut waiting: Vec<WaitingReview> = Vec::new();
    let wanted = |rank: &u32| after.is_none_or(|after| *rank <= after.rank);
    for rank in filter.ranks().filter(wanted) {
        let after = after.filter(|after| after.rank == rank).map(|after| after.place);
        let room = LISTED + 1 - count_u32(waiting.len());
        if room == 0 {
            break;
        }
        waiting.extend(list_waiting_of_rank(reader, viewer, filter, RankStretch { rank, after, room }).await?);
    }
    Ok(waiting)
}

/// A part of the queue within one rank.
#[derive(Clone, Copy)]
struct RankStretch {
    rank: u32,
    after: Option<AttemptPlace>,
    room: u32,
}

async fn list_waiting_of_rank(
    reader: &Pool,
    viewer: &CurrentPerson,
    filter: &ReviewFilter,
    stretch: RankStretch,
) -> Result<Vec<WaitingReview>> {
    // The cross join fixes the order of the join: from the few matching trainees to their attempts,
    // not through the whole queue.
    let statement = match (viewer.role, filter.cohort, &filter.exercise) {
        (Role::Administrator, None, Some(_)) => waiting!(
            "sessions n WHERE n.exercise_id = $8 AND $7 IS NULL
             AND (SELECT role FROM people WHERE people.id = n.trainee_id) = 'trainee'"
        ),
        (Role::Administrator, None, None) => waiting!(
            "sessions n WHERE $7 IS NULL AND (SELECT role FROM people WHERE people.id = n.trainee_id) = 'trainee'"
        ),
        (Role::Administrator, Some(_), _) => waiting!(
            "(SELECT person_id FROM cohort_members WHERE school_id = $1 AND cohort_id = $7 AND role = 'trainee') taught
             CROSS JOIN sessions n WHERE n.trainee_id = taught.person_id"
        ),
        _ => waiting!(
            "(SELECT DISTINCT trainee_id AS person_id FROM taught_trainees
              WHERE teacher_id = $2 AND ($7 IS NULL OR cohort_id = $7)) taught
             CROSS JOIN sessions n WHERE n.trainee_id = taught.person_id"
        ),
    };
    let before_all = AttemptPlace { started_at: Moment::from_micros(i64::MIN), id: SessionId::nil() };
    let after = stretch.after.unwrap_or(before_all);
    sqlx::query_as(statement)
        .bind(viewer.school_id)
        .bind(viewer.id)
        .bind(i64::from(stretch.room))
        .bind(i64::from(stretch.rank))
        .bind(after.started_at)
        .bind(after.id)
        .bind(filter.cohort)
        .bind(&filter.exercise)
        .fetch_all(reader)
        .await
}

impl WaitingReview {
    /// Returns the position in the queue.
    #[must_use]
    pub const fn place(&self) -> QueuePlace {
        QueuePlace { rank: self.rank, place: AttemptPlace { started_at: self.started_at, id: self.id } }
    }
}

/// Marks an attempt as reviewed. Returns false if it already was.
///
/// # Errors
/// If the attempt or the person belongs to another school, or the database fails.
pub async fn mark_reviewed(writer: &mut Connection, session: SessionKey, by: PersonId, now: Moment) -> Result<bool> {
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

/// Puts an attempt back into the queue. Returns false if it was not reviewed.
pub async fn unmark_reviewed(writer: &mut Connection, session: SessionKey) -> Result<bool> {
    sqlx::query("DELETE FROM reviews WHERE school_id = $1 AND session_id = $2")
        .bind(session.school_id)
        .bind(session.id)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Returns the review of an attempt, if there is one.
pub async fn find_review(executor: impl Executor<'_>, session: SessionKey) -> Result<Option<Review>> {
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
