//! Lists of attempts.

use assessment::{Deduction, HardFailure};
use model::ids::{PersonId, SchoolId, SessionId};
use model::{AttemptPlace, CurrentPerson, Moment, Proof, Role, Uncounted, count_u32};
use sqlx::FromRow;

use crate::engine::twin;
use crate::sessions::SessionState;
use crate::{Executor, Json, Result};
use model::titles::StoredTitle;

/// An attempt in a list.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct ListedAttempt {
    /// Session.
    pub id: SessionId,
    /// When it began.
    pub started_at: Moment,
    /// Who tried.
    pub trainee: String,
    /// The exercise's title, or its id where this school never published it.
    #[sqlx(try_from = "StoredTitle")]
    pub exercise: String,
    /// What became of it.
    pub state: SessionState,
    /// Why it was refused.
    pub refusal: Option<String>,
    /// Why it counts nowhere; absent where it counts.
    pub uncounted: Option<Uncounted>,
    /// The re-simulation differs.
    pub flagged: bool,
    /// 0–100, by the grade that counts.
    pub score: Option<f64>,
    /// Passed, by the grade that counts.
    pub passed: Option<bool>,
    /// The computed score, 0–100, where somebody has put another in its place.
    pub computed: Option<f64>,
    /// Points lost, by the newest computed score.
    pub deductions: Option<Json<Vec<Deduction>>>,
    /// Reasons of hard fails, by the newest computed score.
    pub hard_fails: Option<Json<Vec<HardFailure>>>,
}

/// A list of attempts: the same columns whatever limits it, and what a file has more.
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

/// An attempt as a file has it: what lists show, and by what it is known elsewhere.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct AttemptRecord {
    /// As it is listed.
    #[sqlx(flatten)]
    pub listed: ListedAttempt,
    /// Who tried.
    pub trainee_id: PersonId,
    /// Their pseudonym, which recordings carry.
    pub pseudonym: String,
    /// Exercise id.
    pub exercise_id: String,
    /// SHA-256 of the exercise document.
    pub exercise_sha256: String,
    /// When the upload was acknowledged.
    pub received_at: Moment,
    /// Length, in s.
    pub duration_s: f64,
    /// The recording has its end; a cut one has not.
    pub complete: bool,
    /// Device.
    pub device: String,
    /// Version of the simulator.
    pub simulator_version: String,
    /// When it began by what the recording says, where that is not believed.
    pub claimed_started_at: Option<Moment>,
    /// What is proved of it.
    #[sqlx(flatten)]
    pub proof: Proof,
}

/// A stretch of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListStretch {
    /// At most so many.
    pub limit: u32,
    /// After so many.
    pub offset: u32,
}

/// The attempts of a trainee, newest first.
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

/// The attempts of a trainee at an exercise, newest first.
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

/// How many attempts a trainee has made.
pub async fn count_attempts(executor: impl Executor<'_>, school: SchoolId, trainee: PersonId) -> Result<u32> {
    sqlx::query_scalar("SELECT count(*) FROM sessions WHERE school_id = $1 AND trainee_id = $2")
        .bind(school)
        .bind(trainee)
        .fetch_one(executor)
        .await
        .map(count_u32::<i64>)
}

/// The latest attempts in the cohorts that somebody teaches; for an administrator, of all trainees of the school.
pub async fn latest_taught(executor: impl Executor<'_>, viewer: &CurrentPerson) -> Result<Vec<ListedAttempt>> {
    // From those who are taught to the latest of each, and from these to the latest of all: however many attempts the
    // school has. A cross join keeps this order. Where there are ten whose last attempt is later than something, no
    // earlier one is among the latest ten.
    let statement = match viewer.role {
        Role::Administrator => listed!(
            "",
            // From the end of the index, until there are enough.
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

/// The latest attempts at an exercise that a person may see.
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
        // As in [`latest_taught`], with their own.
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

/// Attempts of a school's people, newest first, after one of them; at most `limit`. Those of guests are in their studies.
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
