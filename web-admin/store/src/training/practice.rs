//! Practice of trainees: one row per trainee and exercise with sums and a history. Sums by month
//! are in [`crate::training::tallies`].
//!
//! Call [`refresh_practice`] in every transaction that changes the effective score of an attempt:
//! scoring, re-grading, overrides.

use std::collections::BTreeMap;
use std::sync::Arc;

use model::ids::{AssignmentId, CohortId, PersonId, RevisionId, SchoolId, SessionId};
use model::training::progress::ScoredAttempt;
use model::training::risk::PracticeSigns;
use model::{Moment, PersonKey, SessionKey, count_i64};
use serde::{Deserialize, Serialize};
use sqlx::FromRow;

use crate::auth::lti::deliveries;
use crate::training::tallies;
use crate::training::tallies::Sums;
use crate::{Connection, Executor, Json, Result};

/// An attempt in a history: session, start time in µs, score, passed, revision.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct PastAttempt(SessionId, i64, f64, bool, Option<RevisionId>);

impl PastAttempt {
    fn attempt(self, exercise: &Arc<str>) -> ScoredAttempt {
        let Self(session, at, score, passed, revision) = self;
        let at = Moment::from_micros(at).to_utc();
        ScoredAttempt { session, exercise: Arc::clone(exercise), at, score, passed, revision }
    }
}

#[derive(FromRow)]
struct PastRow {
    id: SessionId,
    started_at: Moment,
    score: f64,
    passed: bool,
    revision_id: Option<RevisionId>,
}

#[derive(FromRow)]
struct PracticeRow {
    trainee_id: PersonId,
    exercise_id: String,
    history: Json<Vec<PastAttempt>>,
}

impl PracticeRow {
    fn attempts(self) -> impl Iterator<Item = ScoredAttempt> {
        let exercise_id: Arc<str> = self.exercise_id.into();
        self.history.0.into_iter().map(move |past| past.attempt(&exercise_id))
    }
}

/// Scored attempts by trainee; those at one exercise are in order of time.
pub type ByTrainee = BTreeMap<PersonId, Vec<ScoredAttempt>>;

fn list_practice_by_trainee(rows: Vec<PracticeRow>) -> ByTrainee {
    let mut attempts = ByTrainee::new();
    for row in rows {
        attempts.entry(row.trainee_id).or_default().extend(row.attempts());
    }
    attempts
}

/// Selects the practice of trainees in school `$1`. The first argument selects their `person_id`s,
/// limited by `$2`.
macro_rules! practised {
    ($trainees:literal, $rest:literal) => {
        concat!(
            "SELECT p.trainee_id, p.exercise_id, p.history FROM (",
            $trainees,
            ") trained CROSS JOIN practice p WHERE p.school_id = $1 AND p.trainee_id = trained.person_id ",
            $rest
        )
    };
}

/// The attempt whose effective score has changed.
#[derive(FromRow)]
struct ChangedScore {
    trainee_id: PersonId,
    exercise_id: String,
    started_at: Moment,
}

/// Updates the sums after a change of an attempt's effective score, and marks the trainee's grades for
/// learning platforms.
pub async fn refresh_practice(writer: &mut Connection, session: SessionKey) -> Result<()> {
    let changed: ChangedScore =
        sqlx::query_as("SELECT trainee_id, exercise_id, started_at FROM sessions WHERE school_id = $1 AND id = $2")
            .bind(session.school_id)
            .bind(session.id)
            .fetch_one(&mut *writer)
            .await?;
    let trainee = PersonKey { school_id: session.school_id, person_id: changed.trainee_id };
    deliveries::mark_person(&mut *writer, trainee).await?;
    let before = sums(&mut *writer, session.school_id, &changed).await?;
    let history = history(&mut *writer, session.school_id, &changed).await?;
    let after = Sums {
        attempts: count_i64(history.len()),
        passes: history.iter().map(|past| i64::from(past.3)).sum(),
        points: history.iter().map(|past| past.2).sum(),
    };
    put(&mut *writer, session.school_id, &changed, after, &history).await?;
    put_signs(&mut *writer, session.school_id, &changed, &history).await?;
    let difference = Sums {
        attempts: after.attempts - before.attempts,
        passes: after.passes - before.passes,
        points: after.points - before.points,
    };
    tallies::add_to_tally(writer, trainee, changed.started_at, difference).await
}

async fn sums(executor: impl Executor<'_>, school: SchoolId, changed: &ChangedScore) -> Result<Sums> {
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

/// Returns all counted and scored attempts of the same trainee at the same exercise, with their
/// effective scores.
async fn history(executor: impl Executor<'_>, school: SchoolId, changed: &ChangedScore) -> Result<Vec<PastAttempt>> {
    let rows: Vec<PastRow> = sqlx::query_as(
        "SELECT s.id, s.started_at, g.score, g.passed, s.revision_id FROM sessions s
         JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
         WHERE s.school_id = $1 AND s.trainee_id = $2 AND s.exercise_id = $3 AND s.state = 'scored'
           AND s.uncounted IS NULL
         ORDER BY s.started_at, s.id",
    )
    .bind(school)
    .bind(changed.trainee_id)
    .bind(&changed.exercise_id)
    .fetch_all(executor)
    .await?;
    Ok(rows.into_iter().map(|r| PastAttempt(r.id, r.started_at.micros(), r.score, r.passed, r.revision_id)).collect())
}

async fn put(
    writer: &mut Connection,
    school: SchoolId,
    changed: &ChangedScore,
    sums: Sums,
    history: &[PastAttempt],
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

/// Updates the signs of risk, and the time of the trainee's latest attempt.
async fn put_signs(
    writer: &mut Connection,
    school: SchoolId,
    changed: &ChangedScore,
    history: &[PastAttempt],
) -> Result<()> {
    let scores: Vec<(f64, bool)> = history.iter().map(|past| (past.2, past.3)).collect();
    match history.last().zip(PracticeSigns::of(&scores)) {
        Some((last, signs)) => {
            sqlx::query(
                "INSERT INTO practice_signs (school_id, trainee_id, exercise_id, last_at, last_score, passes, fails, last_mean, falls)
                 VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9) ON CONFLICT (school_id, trainee_id, exercise_id) DO UPDATE SET
                 last_at = excluded.last_at, last_score = excluded.last_score, passes = excluded.passes,
                 fails = excluded.fails, last_mean = excluded.last_mean, falls = excluded.falls",
            )
            .bind(school)
            .bind(changed.trainee_id)
            .bind(&changed.exercise_id)
            .bind(last.1)
            .bind(signs.last_score)
            .bind(i64::from(signs.passes))
            .bind(i64::from(signs.fails))
            .bind(signs.fall.map(|(mean, _)| mean))
            .bind(signs.fall.map(|(_, fall)| fall))
            .execute(&mut *writer)
            .await?
        }
        None => {
            sqlx::query("DELETE FROM practice_signs WHERE school_id = $1 AND trainee_id = $2 AND exercise_id = $3")
                .bind(school)
                .bind(changed.trainee_id)
                .bind(&changed.exercise_id)
                .execute(&mut *writer)
                .await?
        }
    };
    sqlx::query(
        "UPDATE people SET practised_at = (SELECT max(s.last_at) FROM practice_signs s
           WHERE s.school_id = $1 AND s.trainee_id = $2) WHERE school_id = $1 AND id = $2",
    )
    .bind(school)
    .bind(changed.trainee_id)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the scored attempts of a trainee in order of time, with their effective scores.
pub async fn list_trainee_practice(
    executor: impl Executor<'_>,
    school: SchoolId,
    trainee: PersonId,
) -> Result<Vec<ScoredAttempt>> {
    let rows: Vec<PracticeRow> = sqlx::query_as(
        "SELECT trainee_id, exercise_id, history FROM practice WHERE school_id = $1 AND trainee_id = $2",
    )
    .bind(school)
    .bind(trainee)
    .fetch_all(executor)
    .await?;
    let mut attempts: Vec<ScoredAttempt> = rows.into_iter().flat_map(PracticeRow::attempts).collect();
    attempts.sort_by_key(|attempt| (attempt.at, attempt.session));
    Ok(attempts)
}

/// Every scored attempt of the next people of a school who have any, after one of them.
pub async fn list_school_practice(
    executor: impl Executor<'_>,
    PersonKey { school_id: school, person_id: after }: PersonKey,
    most: u32,
) -> Result<ByTrainee> {
    let rows = sqlx::query_as(practised!(
        "SELECT DISTINCT trainee_id AS person_id FROM practice WHERE school_id = $1 AND trainee_id > $2
         ORDER BY trainee_id LIMIT $3 + 0",
        ""
    ));
    Ok(list_practice_by_trainee(rows.bind(school).bind(after).bind(i64::from(most)).fetch_all(executor).await?))
}

/// Every scored attempt of a cohort's trainees.
pub async fn list_cohort_practice(
    executor: impl Executor<'_>,
    school: SchoolId,
    cohort: CohortId,
) -> Result<ByTrainee> {
    let rows = sqlx::query_as(practised!(
        "SELECT person_id FROM cohort_members WHERE school_id = $1 AND cohort_id = $2 AND role = 'trainee'",
        ""
    ));
    Ok(list_practice_by_trainee(rows.bind(school).bind(cohort).fetch_all(executor).await?))
}

/// Returns the scored attempts of a cohort's trainees at an exercise.
pub async fn of_cohort_at(
    executor: impl Executor<'_>,
    school: SchoolId,
    cohort: CohortId,
    exercise: &str,
) -> Result<ByTrainee> {
    let rows = sqlx::query_as(practised!(
        "SELECT person_id FROM cohort_members WHERE school_id = $1 AND cohort_id = $2 AND role = 'trainee'",
        "AND p.exercise_id = $3"
    ));
    Ok(list_practice_by_trainee(rows.bind(school).bind(cohort).bind(exercise).fetch_all(executor).await?))
}

/// Returns the scored attempts of the trainees of an assignment.
pub async fn of_assignment(
    executor: impl Executor<'_>,
    school: SchoolId,
    assignment: AssignmentId,
) -> Result<ByTrainee> {
    let rows = sqlx::query_as(practised!(
        "SELECT m.person_id FROM assignments a JOIN cohort_members m ON m.cohort_id = a.cohort_id AND m.role = 'trainee'
         WHERE a.id = $2
         UNION ALL SELECT person_id FROM assignments WHERE id = $2 AND person_id IS NOT NULL",
        ""
    ));
    Ok(list_practice_by_trainee(rows.bind(school).bind(assignment).fetch_all(executor).await?))
}

/// Maximum number of cohort members searched for attempts at the same exercise.
const LOOKED_THROUGH: u32 = 200;

/// Returns the latest attempt at an exercise of each of the other trainees in a trainee's cohorts,
/// at most `most`.
pub async fn list_latest_of_others(
    executor: impl Executor<'_>,
    PersonKey { school_id: school, person_id: trainee }: PersonKey,
    exercise: &str,
    most: u32,
) -> Result<Vec<SessionId>> {
    let latest: Vec<Option<String>> = sqlx::query_scalar(
        "SELECT json_extract(p.history, '$[#-1][0]') FROM (
           SELECT DISTINCT other.person_id FROM cohort_members own
           CROSS JOIN cohort_members other
           WHERE other.cohort_id = own.cohort_id AND other.role = 'trainee' AND own.school_id = $1 AND own.person_id = $2
           AND own.role = 'trainee' AND other.person_id <> $2 LIMIT $4 + 0) mates
         CROSS JOIN practice p WHERE p.school_id = $1 AND p.trainee_id = mates.person_id AND p.exercise_id = $3 LIMIT $5 + 0",
    )
    .bind(school)
    .bind(trainee)
    .bind(exercise)
    .bind(i64::from(LOOKED_THROUGH))
    .bind(i64::from(most))
    .fetch_all(executor)
    .await?;
    Ok(latest.into_iter().flatten().filter_map(|id| id.parse().ok()).collect())
}
