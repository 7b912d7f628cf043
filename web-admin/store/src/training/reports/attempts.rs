//! Lists of attempts.

use assessment::{Deduction, HardFailure};
use model::ids::{PersonId, SchoolId, SessionId};
use model::titles::StoredTitle;
use model::{AttemptPlace, CurrentPerson, Moment, Proof, Role, Uncounted, count_u32};
use sqlx::FromRow;

use crate::engine::twin;
use crate::recordings::sessions::SessionState;
use crate::{Executor, Json, Result};

/// An attempt in a list.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct ListedAttempt {
    /// Session.
    pub id: SessionId,
    /// Start time.
    pub started_at: Moment,
    /// Name of the trainee.
    pub trainee: String,
    /// Title of the exercise, or its id if this school never published it.
    #[sqlx(try_from = "StoredTitle")]
    pub exercise: String,
    /// State.
    pub state: SessionState,
    /// Reason for the rejection.
    pub refusal: Option<String>,
    /// Reason why it does not count; `None` if it counts.
    pub uncounted: Option<Uncounted>,
    /// The re-simulation differs.
    pub flagged: bool,
    /// Effective score, 0–100.
    pub score: Option<f64>,
    /// Passed, by the effective grade.
    pub passed: Option<bool>,
    /// Computed score, 0–100, if it was overridden.
    pub computed: Option<f64>,
    /// Deductions of the newest computed score.
    pub deductions: Option<Json<Vec<Deduction>>>,
    /// Hard fails of the newest computed score.
    pub hard_fails: Option<Json<Vec<HardFailure>>>,
}

/// Selects a list of attempts. All lists have the same columns; files have additional ones.
macro_rules! listed {
    ($more:literal, $from:literal, $rest:literal) => {
        concat!(
            "SELECT s.id, s.started_at, p.display_name AS trainee, coalesce(r.title, s.exercise_id) AS exercise,
               s.state, s.refusal, s.uncounted, coalesce(s.verify_flagged, FALSE) AS flagged, g.score, g.passed, c.deductions,
               c.hard_fails, CASE WHEN g.override_id IS NOT NULL THEN c.score END AS computed",
            $more,
            " FROM ",
            $from,
            " JOIN people p ON p.school_id = s.school_id AND p.id = s.trainee_id
             LEFT JOIN exercise_revisions r ON r.id = s.revision_id
             LEFT JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
             LEFT JOIN scores c ON c.id = g.score_id ",
            $rest,
            " ORDER BY s.started_at DESC, s.id DESC LIMIT $3 + 0 OFFSET $4"
        )
    };
}

/// An attempt in an exported file: the listed values, and identifiers.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct AttemptRecord {
    /// Listed values.
    #[sqlx(flatten)]
    pub listed: ListedAttempt,
    /// Id of the trainee.
    pub trainee_id: PersonId,
    /// Pseudonym of the trainee, which recordings contain.
    pub pseudonym: String,
    /// Exercise id.
    pub exercise_id: String,
    /// SHA-256 of the exercise document.
    pub exercise_sha256: String,
    /// Time at which the upload was acknowledged.
    pub received_at: Moment,
    /// Duration, in s.
    pub duration_s: f64,
    /// The recording is complete, not truncated.
    pub complete: bool,
    /// Device.
    pub device: String,
    /// Version of the simulator.
    pub simulator_version: String,
    /// Start time claimed by the recording, if it differs from `started_at`.
    pub claimed_started_at: Option<Moment>,
    /// Proofs.
    #[sqlx(flatten)]
    pub proof: Proof,
}

/// A page of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListStretch {
    /// Maximum number of entries.
    pub limit: u32,
    /// Number of entries to skip.
    pub offset: u32,
}

/// Returns the attempts of a trainee, newest first.
pub async fn attempts_of(
    executor: impl Executor<'_>,
    school: SchoolId,
    trainee: PersonId,
    stretch: ListStretch,
) -> Result<Vec<ListedAttempt>> {
    sqlx::query_as(listed!("", "sessions s", "WHERE s.school_id = $1 AND s.trainee_id = $2"))
        .bind(school)
        .bind(trainee)
        .bind(i64::from(stretch.limit))
        .bind(i64::from(stretch.offset))
        .fetch_all(executor)
        .await
}

/// Returns the attempts of a trainee at an exercise, newest first.
pub async fn attempts_at(
    executor: impl Executor<'_>,
    school: SchoolId,
    trainee: PersonId,
    exercise: &str,
    stretch: ListStretch,
) -> Result<Vec<ListedAttempt>> {
    sqlx::query_as(listed!("", "sessions s", "WHERE s.school_id = $1 AND s.trainee_id = $2 AND s.exercise_id = $5"))
        .bind(school)
        .bind(trainee)
        .bind(i64::from(stretch.limit))
        .bind(i64::from(stretch.offset))
        .bind(exercise)
        .fetch_all(executor)
        .await
}

/// Returns the number of attempts of a trainee.
pub async fn count_attempts(executor: impl Executor<'_>, school: SchoolId, trainee: PersonId) -> Result<u32> {
    sqlx::query_scalar("SELECT count(*) FROM sessions WHERE school_id = $1 AND trainee_id = $2")
        .bind(school)
        .bind(trainee)
        .fetch_one(executor)
        .await
        .map(count_u32::<i64>)
}

/// Returns the latest attempts in the cohorts that a person teaches; for an administrator, of all
/// trainees of the school.
pub async fn latest_taught(executor: impl Executor<'_>, viewer: &CurrentPerson) -> Result<Vec<ListedAttempt>> {
    // The query goes from the trainees to the latest attempts of each, and from these to the latest
    // of all, so that its cost does not depend on the number of attempts. The cross join fixes this
    // order. If ten trainees have their last attempt after some time, no attempt before that time
    // is among the latest ten.
    let statement = match viewer.role {
        Role::Administrator => listed!(
            "",
            // Reads backwards from the end of the index until there are enough.
            "(SELECT n.id FROM sessions n WHERE n.school_id = $1 AND n.started_at > -9000000000000000000
                 AND (SELECT role FROM people WHERE people.id = n.trainee_id) = 'trainee'
               ORDER BY n.started_at DESC, n.id DESC LIMIT $3 + 0) chosen
             CROSS JOIN sessions s",
            "WHERE s.school_id = $1 AND s.id = chosen.id AND $2 IS NOT NULL"
        ),
        _ => twin!(
            executor,
            listed!(
                "",
                "(SELECT n.id FROM (SELECT DISTINCT trainee_id AS person_id FROM taught_trainees WHERE teacher_id = $2) taught
                   CROSS JOIN sessions n
                   WHERE n.school_id = $1 AND n.id IN (
                     SELECT l.id FROM sessions l WHERE l.school_id = $1 AND l.trainee_id = taught.person_id
                       AND l.started_at >= coalesce((
                         SELECT (SELECT max(o.started_at) FROM sessions o
                           WHERE o.school_id = $1 AND o.trainee_id = taught.trainee_id) AS last
                         FROM taught_trainees taught WHERE taught.teacher_id = $2
                         GROUP BY taught.trainee_id ORDER BY last DESC NULLS LAST LIMIT 1 OFFSET $3 - 1), -9000000000000000000)
                     ORDER BY l.started_at DESC, l.id DESC LIMIT $3 + 0)
                   ORDER BY n.started_at DESC, n.id DESC LIMIT $3 + 0) chosen
                 CROSS JOIN sessions s",
                "WHERE s.school_id = $1 AND s.id = chosen.id"
            ),
            listed!(
                "",
                "(SELECT n.id FROM (SELECT DISTINCT trainee_id AS person_id FROM taught_trainees WHERE teacher_id = $2) taught
                   CROSS JOIN LATERAL (
                     SELECT l.id, l.started_at FROM sessions l WHERE l.school_id = $1 AND l.trainee_id = taught.person_id
                     ORDER BY l.started_at DESC, l.id DESC LIMIT $3 + 0) n
                   ORDER BY n.started_at DESC, n.id DESC LIMIT $3 + 0) chosen
                 CROSS JOIN sessions s",
                "WHERE s.school_id = $1 AND s.id = chosen.id"
            ),
        ),
    };
    sqlx::query_as(statement).bind(viewer.school_id).bind(viewer.id).bind(10).bind(0).fetch_all(executor).await
}

/// Returns the latest attempts at an exercise that a person may see.
pub async fn latest_at(
    executor: impl Executor<'_>,
    viewer: &CurrentPerson,
    exercise: &str,
) -> Result<Vec<ListedAttempt>> {
    let statement = match viewer.role {
        Role::Administrator => listed!(
            "",
            "(SELECT n.id FROM sessions n WHERE n.school_id = $1 AND n.exercise_id = $5
                 AND (SELECT role FROM people WHERE people.id = n.trainee_id) <> 'guest'
               ORDER BY n.started_at DESC, n.id DESC LIMIT $3 + 0) chosen
             CROSS JOIN sessions s",
            "WHERE s.school_id = $1 AND s.id = chosen.id"
        ),
        // Same as in [`latest_taught`], including the viewer's own attempts.
        Role::Instructor | Role::Trainee | Role::Guest => twin!(
            executor,
            listed!(
                "",
                "(SELECT n.id FROM (SELECT trainee_id AS person_id FROM taught_trainees WHERE teacher_id = $2 UNION SELECT $2) seen
                   CROSS JOIN sessions n
                   WHERE n.school_id = $1 AND n.id IN (
                     SELECT l.id FROM sessions l
                     WHERE l.school_id = $1 AND l.trainee_id = seen.person_id AND l.exercise_id = $5
                     ORDER BY l.started_at DESC, l.id DESC LIMIT $3 + 0)
                   ORDER BY n.started_at DESC, n.id DESC LIMIT $3 + 0) chosen
                 CROSS JOIN sessions s",
                "WHERE s.school_id = $1 AND s.id = chosen.id"
            ),
            listed!(
                "",
                "(SELECT n.id FROM (SELECT trainee_id AS person_id FROM taught_trainees WHERE teacher_id = $2 UNION SELECT $2) seen
                   CROSS JOIN LATERAL (
                     SELECT l.id, l.started_at FROM sessions l
                     WHERE l.school_id = $1 AND l.trainee_id = seen.person_id AND l.exercise_id = $5
                     ORDER BY l.started_at DESC, l.id DESC LIMIT $3 + 0) n
                   ORDER BY n.started_at DESC, n.id DESC LIMIT $3 + 0) chosen
                 CROSS JOIN sessions s",
                "WHERE s.school_id = $1 AND s.id = chosen.id"
            ),
        ),
    };
    sqlx::query_as(statement)
        .bind(viewer.school_id)
        .bind(viewer.id)
        .bind(25)
        .bind(0)
        .bind(exercise)
        .fetch_all(executor)
        .await
}

/// Returns attempts of a school after a cursor, newest first; at most `limit`. Attempts of guests
/// are left out: they belong to studies.
pub async fn records_after(
    executor: impl Executor<'_>,
    school: SchoolId,
    after: AttemptPlace,
    limit: u32,
) -> Result<Vec<AttemptRecord>> {
    sqlx::query_as(listed!(
        ", s.trainee_id, p.pseudonym, s.exercise_id, s.exercise_sha256, s.received_at, s.duration_s, s.complete, s.device,
           s.simulator_version, s.claimed_started_at, q.signed, q.resimulated, q.supervised",
        "(SELECT n.id FROM sessions n WHERE n.school_id = $1 AND (n.started_at, n.id) < ($2, $5)
             AND (SELECT role FROM people WHERE people.id = n.trainee_id) <> 'guest'
           ORDER BY n.started_at DESC, n.id DESC LIMIT $3 + 0) chosen
         CROSS JOIN sessions s
         CROSS JOIN proofs q",
        "WHERE s.school_id = $1 AND s.id = chosen.id AND q.school_id = $1 AND q.session_id = chosen.id"
    ))
    .bind(school)
    .bind(after.started_at)
    .bind(i64::from(limit))
    .bind(0)
    .bind(after.id)
    .fetch_all(executor)
    .await
}
