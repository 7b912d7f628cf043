//! What trainees have practised, summed up: a row for each trainee and exercise, and sums by month.
//!
//! [`refresh`] belongs into every transaction that changes which score counts: scoring, re-grading, an override.

use serde::{Deserialize, Serialize};
use sqlx::types::Json;
use sqlx::{FromRow, SqliteConnection, SqliteExecutor};
use uuid::Uuid;

use super::Result;
use super::scores::SessionKey;
use crate::domain::Moment;
use crate::domain::progress::Attempt;

/// The cohort in `tallies` that stands for the whole school.
const WHOLE_SCHOOL: Uuid = Uuid::nil();

/// An attempt in a history: session, start in µs, score, passed, revision.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Past(Uuid, i64, f64, bool, Option<Uuid>);

impl Past {
    fn attempt(self, exercise: &str) -> Attempt {
        let Self(session, at, score, passed, revision) = self;
        Attempt {
            session: session.to_string(),
            exercise: exercise.to_owned(),
            at: Moment::from_micros(at).to_utc(),
            score,
            passed,
            revision,
        }
    }
}

#[derive(FromRow)]
struct PastRow {
    id: Uuid,
    started_at: Moment,
    score: f64,
    passed: bool,
    revision_id: Option<Uuid>,
}

#[derive(FromRow)]
struct PracticeRow {
    trainee_id: Uuid,
    exercise_id: String,
    history: Json<Vec<Past>>,
}

impl PracticeRow {
    fn attempts(self) -> impl Iterator<Item = (Uuid, Attempt)> {
        let Self { trainee_id, exercise_id, history } = self;
        history.0.into_iter().map(move |past| (trainee_id, past.attempt(&exercise_id)))
    }
}

/// The attempt whose counting score has changed.
#[derive(FromRow)]
struct Changed {
    trainee_id: Uuid,
    exercise_id: String,
    started_at: Moment,
}

/// How many attempts, how many passed, the sum of their scores.
#[derive(Clone, Copy, Debug, Default, PartialEq, FromRow)]
pub struct Sums {
    /// Scored attempts.
    pub attempts: i64,
    /// Attempts passed.
    pub passes: i64,
    /// Sum of the scores, each 0–100.
    pub points: f64,
}

/// Brings the sums up to date with the score that counts for an attempt.
///
/// # Errors
/// When the database fails.
pub async fn refresh(writer: &mut SqliteConnection, session: SessionKey) -> Result<()> {
    let changed: Changed =
        sqlx::query_as("SELECT trainee_id, exercise_id, started_at FROM sessions WHERE school_id = $1 AND id = $2")
            .bind(session.school_id)
            .bind(session.id)
            .fetch_one(&mut *writer)
            .await?;
    let before = sums(&mut *writer, session.school_id, &changed).await?;
    let history = history(&mut *writer, session.school_id, &changed).await?;
    let after = Sums {
        attempts: i64::try_from(history.len()).unwrap_or(i64::MAX),
        passes: history.iter().map(|past| i64::from(past.3)).sum(),
        points: history.iter().map(|past| past.2).sum(),
    };
    put(writer, session.school_id, &changed, (after, &history)).await?;
    let difference = Sums {
        attempts: after.attempts - before.attempts,
        passes: after.passes - before.passes,
        points: after.points - before.points,
    };
    tally(writer, session.school_id, &changed, difference).await
}

async fn sums(executor: impl SqliteExecutor<'_>, school: Uuid, changed: &Changed) -> Result<Sums> {
    let sums: Option<Sums> = sqlx::query_as(
        "SELECT attempts, passes, points FROM practice WHERE school_id = $1 AND trainee_id = $2 AND exercise_id = $3",
    )
    .bind(school)
    .bind(changed.trainee_id)
    .bind(&changed.exercise_id)
    .fetch_optional(executor)
    .await?;
    Ok(sums.unwrap_or_default())
}

/// Every scored attempt of the same trainee at the same exercise, each by the score that counts.
async fn history(executor: impl SqliteExecutor<'_>, school: Uuid, changed: &Changed) -> Result<Vec<Past>> {
    let rows: Vec<PastRow> = sqlx::query_as(
        "SELECT s.id, s.started_at, g.score, g.passed, s.revision_id FROM sessions s
         JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
         WHERE s.school_id = $1 AND s.trainee_id = $2 AND s.exercise_id = $3 AND s.state = 'scored'
         ORDER BY s.started_at, s.id",
    )
    .bind(school)
    .bind(changed.trainee_id)
    .bind(&changed.exercise_id)
    .fetch_all(executor)
    .await?;
    Ok(rows.into_iter().map(|r| Past(r.id, r.started_at.micros(), r.score, r.passed, r.revision_id)).collect())
}

async fn put(
    writer: &mut SqliteConnection,
    school: Uuid,
    changed: &Changed,
    (sums, history): (Sums, &[Past]),
) -> Result<()> {
    sqlx::query(
        "INSERT INTO practice (school_id, trainee_id, exercise_id, attempts, passes, points, history)
         VALUES ($1, $2, $3, $4, $5, $6, $7) ON CONFLICT (school_id, trainee_id, exercise_id) DO UPDATE SET
         attempts = excluded.attempts, passes = excluded.passes, points = excluded.points, history = excluded.history",
    )
    .bind(school)
    .bind(changed.trainee_id)
    .bind(&changed.exercise_id)
    .bind(sums.attempts)
    .bind(sums.passes)
    .bind(sums.points)
    .bind(Json(history))
    .execute(writer)
    .await
    .map(drop)
}

/// Adds a difference to the school's month and to that of each cohort the trainee is in.
async fn tally(writer: &mut SqliteConnection, school: Uuid, changed: &Changed, by: Sums) -> Result<()> {
    let cohorts: Vec<Uuid> = sqlx::query_scalar(
        "SELECT cohort_id FROM cohort_members WHERE person_id = $2 AND role = 'trainee' AND school_id = $1",
    )
    .bind(school)
    .bind(changed.trainee_id)
    .fetch_all(&mut *writer)
    .await?;
    let at = changed.started_at.to_utc();
    let month = i64::from(at.year()) * 12 + i64::from(u8::from(at.month())) - 1;
    for cohort in cohorts.into_iter().chain([WHOLE_SCHOOL]) {
        sqlx::query(
            "INSERT INTO tallies (school_id, cohort_id, month, attempts, passes, points)
             VALUES ($1, $2, $3, $4, $5, $6) ON CONFLICT (school_id, cohort_id, month) DO UPDATE SET
             attempts = attempts + excluded.attempts, passes = passes + excluded.passes,
             points = points + excluded.points",
        )
        .bind(school)
        .bind(cohort)
        .bind(month)
        .bind(by.attempts)
        .bind(by.passes)
        .bind(by.points)
        .execute(&mut *writer)
        .await?;
    }
    Ok(())
}

/// The scored attempts of a trainee in order of time, each by the score that counts.
///
/// # Errors
/// When the database fails.
pub async fn of_trainee(executor: impl SqliteExecutor<'_>, school: Uuid, trainee: Uuid) -> Result<Vec<Attempt>> {
    let rows: Vec<PracticeRow> = sqlx::query_as(
        "SELECT trainee_id, exercise_id, history FROM practice WHERE school_id = $1 AND trainee_id = $2",
    )
    .bind(school)
    .bind(trainee)
    .fetch_all(executor)
    .await?;
    let mut attempts: Vec<Attempt> = rows.into_iter().flat_map(PracticeRow::attempts).map(|(_, a)| a).collect();
    attempts.sort_by(|a, b| (a.at, &a.session).cmp(&(b.at, &b.session)));
    Ok(attempts)
}

/// Every scored attempt of a cohort's trainees, beside the trainee who made it.
///
/// # Errors
/// When the database fails.
pub async fn of_cohort(executor: impl SqliteExecutor<'_>, school: Uuid, cohort: Uuid) -> Result<Vec<(Uuid, Attempt)>> {
    let rows: Vec<PracticeRow> = sqlx::query_as(
        "SELECT p.trainee_id, p.exercise_id, p.history FROM cohort_members m
         JOIN practice p ON p.school_id = m.school_id AND p.trainee_id = m.person_id
         WHERE m.school_id = $1 AND m.cohort_id = $2 AND m.role = 'trainee'",
    )
    .bind(school)
    .bind(cohort)
    .fetch_all(executor)
    .await?;
    Ok(rows.into_iter().flat_map(PracticeRow::attempts).collect())
}

/// Sums of a cohort over a year.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct YearOfCohort {
    /// The cohort.
    pub cohort_id: Uuid,
    /// Its name.
    pub cohort: String,
    /// The year, UTC.
    pub year: i32,
    /// Its sums.
    #[sqlx(flatten)]
    pub sums: Sums,
}

/// Sums by year and cohort, the latest year first.
///
/// # Errors
/// When the database fails.
pub async fn by_year(executor: impl SqliteExecutor<'_>, school: Uuid) -> Result<Vec<YearOfCohort>> {
    sqlx::query_as(
        "SELECT c.id AS cohort_id, c.name AS cohort, t.month / 12 AS year, sum(t.attempts) AS attempts,
           sum(t.passes) AS passes, sum(t.points) AS points
         FROM cohorts c JOIN tallies t ON t.school_id = c.school_id AND t.cohort_id = c.id
         WHERE c.school_id = $1 GROUP BY c.id, c.name, t.month / 12 ORDER BY year DESC, c.name",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Sums of the whole school by month, the earliest first: 12 × year + month − 1, and the sums.
///
/// # Errors
/// When the database fails.
pub async fn by_month(executor: impl SqliteExecutor<'_>, school: Uuid) -> Result<Vec<(i64, Sums)>> {
    let rows: Vec<(i64, i64, i64, f64)> = sqlx::query_as(
        "SELECT month, attempts, passes, points FROM tallies WHERE school_id = $1 AND cohort_id = $2 ORDER BY month",
    )
    .bind(school)
    .bind(WHOLE_SCHOOL)
    .fetch_all(executor)
    .await?;
    let sums = |(month, attempts, passes, points)| (month, Sums { attempts, passes, points });
    Ok(rows.into_iter().map(sums).collect())
}
