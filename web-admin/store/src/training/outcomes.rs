//! Outcomes of a school, the courses that lead to them, and the levels entrusted to trainees.

use model::ids::{CohortId, EntrustmentId, OutcomeId, PersonId, SchoolId};
use model::training::outcome::OutcomeText;
use model::{Moment, PersonKey};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// An outcome.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Outcome {
    /// Id.
    pub id: OutcomeId,
    /// Code, unique in the school.
    pub code: String,
    /// Title.
    pub title: String,
    /// Description; may be empty.
    pub description: String,
    /// Identifier in a catalogue; empty if it was entered by hand.
    pub source: String,
    /// Time at which it was retired.
    pub retired_at: Option<Moment>,
}

/// Selects outcomes of school `$1`.
macro_rules! outcomes {
    ($rest:literal) => {
        concat!(
            "SELECT o.id, o.code, o.title, o.description, o.source, o.retired_at FROM outcomes o WHERE o.school_id = $1 ",
            $rest
        )
    };
}

/// Returns all outcomes of a school, sorted by code.
pub async fn list_outcomes(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<Outcome>> {
    sqlx::query_as(outcomes!("ORDER BY o.code")).bind(school).fetch_all(executor).await
}

/// Returns the outcomes to which a course leads and which are not retired, sorted by code.
pub async fn list_taught_outcomes(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<Outcome>> {
    sqlx::query_as(outcomes!(
        "AND o.retired_at IS NULL AND EXISTS (SELECT 1 FROM outcome_courses c WHERE c.outcome_id = o.id)
         ORDER BY o.code"
    ))
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Returns whether a school has outcomes.
pub async fn has_outcomes(executor: impl Executor<'_>, school: SchoolId) -> Result<bool> {
    sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM outcomes WHERE school_id = $1)")
        .bind(school)
        .fetch_one(executor)
        .await
}

/// Returns an outcome of a school.
pub async fn find_outcome(executor: impl Executor<'_>, school: SchoolId, id: OutcomeId) -> Result<Option<Outcome>> {
    sqlx::query_as(outcomes!("AND o.id = $2")).bind(school).bind(id).fetch_optional(executor).await
}

/// Adds an outcome. Returns `None` if another one of the school has its code.
pub async fn add_outcome(
    writer: &mut Connection,
    school: SchoolId,
    text: &OutcomeText,
    now: Moment,
) -> Result<Option<OutcomeId>> {
    sqlx::query_scalar(
        "INSERT INTO outcomes (id, school_id, code, title, description, source, made_at) VALUES ($1, $2, $3, $4, $5, $6, $7)
         ON CONFLICT (school_id, code) DO NOTHING RETURNING id",
    )
    .bind(OutcomeId::made_at(now))
    .bind(school)
    .bind(&text.code)
    .bind(&text.title)
    .bind(&text.description)
    .bind(&text.source)
    .bind(now)
    .fetch_optional(writer)
    .await
}

/// Changes the texts of an outcome. Returns false if another one of the school has its code.
pub async fn change_outcome(
    writer: &mut Connection,
    school: SchoolId,
    id: OutcomeId,
    text: &OutcomeText,
) -> Result<bool> {
    sqlx::query(
        "UPDATE outcomes SET code = $3, title = $4, description = $5, source = $6 WHERE school_id = $1 AND id = $2
           AND NOT EXISTS (SELECT 1 FROM outcomes o WHERE o.school_id = $1 AND o.code = $3 AND o.id <> $2)",
    )
    .bind(school)
    .bind(id)
    .bind(&text.code)
    .bind(&text.title)
    .bind(&text.description)
    .bind(&text.source)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Retires an outcome, or offers it again with `None`.
pub async fn retire_outcome(
    writer: &mut Connection,
    school: SchoolId,
    id: OutcomeId,
    retired_at: Option<Moment>,
) -> Result<()> {
    sqlx::query("UPDATE outcomes SET retired_at = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .bind(retired_at)
        .execute(writer)
        .await
        .map(drop)
}

/// A course that leads to an outcome.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct OutcomeCourse {
    /// The outcome.
    pub outcome_id: OutcomeId,
    /// Id of the course.
    pub curriculum_id: String,
}

/// Returns all pairs of outcomes and courses of a school.
pub async fn list_outcome_courses(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<OutcomeCourse>> {
    sqlx::query_as(
        "SELECT outcome_id, curriculum_id FROM outcome_courses WHERE school_id = $1 ORDER BY outcome_id, curriculum_id",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Replaces the courses of an outcome.
pub async fn replace_courses(
    writer: &mut Connection,
    school: SchoolId,
    id: OutcomeId,
    courses: &[String],
) -> Result<()> {
    sqlx::query("DELETE FROM outcome_courses WHERE school_id = $1 AND outcome_id = $2")
        .bind(school)
        .bind(id)
        .execute(&mut *writer)
        .await?;
    for course in courses {
        sqlx::query(
            "INSERT INTO outcome_courses (school_id, outcome_id, curriculum_id) VALUES ($1, $2, $3) ON CONFLICT DO NOTHING",
        )
        .bind(school)
        .bind(id)
        .bind(course)
        .execute(&mut *writer)
        .await?;
    }
    Ok(())
}

/// Returns the names of a school's levels, lowest first; empty if it has set none.
pub async fn list_levels(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<String>> {
    sqlx::query_scalar("SELECT name FROM outcome_levels WHERE school_id = $1 ORDER BY level")
        .bind(school)
        .fetch_all(executor)
        .await
}

/// Replaces the names of a school's levels.
pub async fn replace_levels(writer: &mut Connection, school: SchoolId, names: &[String]) -> Result<()> {
    sqlx::query("DELETE FROM outcome_levels WHERE school_id = $1").bind(school).execute(&mut *writer).await?;
    for (level, name) in (1_i64..).zip(names) {
        sqlx::query("INSERT INTO outcome_levels (school_id, level, name) VALUES ($1, $2, $3)")
            .bind(school)
            .bind(level)
            .bind(name)
            .execute(&mut *writer)
            .await?;
    }
    Ok(())
}

/// Returns the highest level ever entrusted in a school; 0 if there is none.
pub async fn find_highest_level(executor: impl Executor<'_>, school: SchoolId) -> Result<i64> {
    sqlx::query_scalar("SELECT coalesce(max(level), 0) FROM entrustments WHERE school_id = $1")
        .bind(school)
        .fetch_one(executor)
        .await
}

/// A decision on the level of an outcome entrusted to a person.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Entrustment {
    /// The outcome.
    pub outcome_id: OutcomeId,
    /// The person.
    pub person_id: PersonId,
    /// The level, from 1; `None` if the entrustment ended.
    pub level: Option<i64>,
    /// Reason of the decision; may be empty.
    pub note: String,
    /// Name of who decided.
    pub decided_by: String,
    /// Time of the decision.
    pub decided_at: Moment,
}

/// A new decision.
#[derive(Clone, Copy, Debug)]
pub struct NewEntrustment<'a> {
    /// The outcome.
    pub outcome_id: OutcomeId,
    /// The person.
    pub person: PersonKey,
    /// The level, from 1; `None` ends the entrustment.
    pub level: Option<i64>,
    /// Reason of the decision; may be empty.
    pub note: &'a str,
    /// Who decides.
    pub decided_by: PersonId,
}

/// Adds a decision.
pub async fn add_entrustment(writer: &mut Connection, new: NewEntrustment<'_>, now: Moment) -> Result<EntrustmentId> {
    let id = EntrustmentId::made_at(now);
    sqlx::query(
        "INSERT INTO entrustments (id, school_id, outcome_id, person_id, level, note, decided_by, decided_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8)",
    )
    .bind(id)
    .bind(new.person.school_id)
    .bind(new.outcome_id)
    .bind(new.person.person_id)
    .bind(new.level)
    .bind(new.note)
    .bind(new.decided_by)
    .bind(now)
    .execute(writer)
    .await?;
    Ok(id)
}

/// Returns all decisions about a person, oldest first.
pub async fn list_entrustments(executor: impl Executor<'_>, whom: PersonKey) -> Result<Vec<Entrustment>> {
    sqlx::query_as(
        "SELECT e.outcome_id, e.person_id, e.level, e.note, p.display_name AS decided_by, e.decided_at
         FROM entrustments e JOIN people p ON p.school_id = e.school_id AND p.id = e.decided_by
         WHERE e.school_id = $1 AND e.person_id = $2 ORDER BY e.decided_at, e.id",
    )
    .bind(whom.school_id)
    .bind(whom.person_id)
    .fetch_all(executor)
    .await
}

/// Returns all decisions about the trainees of a cohort, oldest first.
pub async fn list_cohort_entrustments(
    executor: impl Executor<'_>,
    school: SchoolId,
    cohort: CohortId,
) -> Result<Vec<Entrustment>> {
    sqlx::query_as(
        "SELECT e.outcome_id, e.person_id, e.level, e.note, p.display_name AS decided_by, e.decided_at
         FROM (SELECT person_id FROM cohort_members WHERE school_id = $1 AND cohort_id = $2 AND role = 'trainee') trained
         CROSS JOIN entrustments e JOIN people p ON p.school_id = e.school_id AND p.id = e.decided_by
         WHERE e.school_id = $1 AND e.person_id = trained.person_id ORDER BY e.decided_at, e.id",
    )
    .bind(school)
    .bind(cohort)
    .fetch_all(executor)
    .await
}

/// Empties the notes of the decisions about a person who is erased.
pub async fn forget_notes(writer: &mut Connection, whom: PersonKey) -> Result<()> {
    sqlx::query("UPDATE entrustments SET note = '' WHERE school_id = $1 AND person_id = $2")
        .bind(whom.school_id)
        .bind(whom.person_id)
        .execute(writer)
        .await
        .map(drop)
}

/// Ratings of a person's attempts at an exercise.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct RatedExercise {
    /// Id of the exercise.
    pub exercise_id: String,
    /// Number of finished ratings.
    #[sqlx(try_from = "i64")]
    pub ratings: u32,
}

/// Returns the number of finished ratings of a person's attempts, by exercise.
pub async fn count_ratings(executor: impl Executor<'_>, whom: PersonKey) -> Result<Vec<RatedExercise>> {
    sqlx::query_as(
        "SELECT s.exercise_id, count(*) AS ratings FROM sessions s CROSS JOIN ratings r
         WHERE s.school_id = $1 AND s.trainee_id = $2 AND r.school_id = s.school_id AND r.session_id = s.id
           AND r.finished_at IS NOT NULL GROUP BY s.exercise_id",
    )
    .bind(whom.school_id)
    .bind(whom.person_id)
    .fetch_all(executor)
    .await
}
