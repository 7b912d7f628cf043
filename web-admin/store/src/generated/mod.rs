//! A large database of generated people and attempts, for measuring the performance of pages.
//!
//! [`found`] generates the people, [`practise`] the attempts of some of them, and [`conclude`] the
//! sums over all. They are separate steps so that each transaction has a reasonable size.

use std::ops::Range;

use model::ids::{SchoolId, SessionId};

use super::{Connection, Result, engine};

/// Makes a statement that selects from `n`, whose column `i` counts from 0 to `$2` − 1.
macro_rules! counted {
    ($statement:literal) => {
        concat!("WITH RECURSIVE n (i) AS (SELECT 0 UNION ALL SELECT i + 1 FROM n WHERE i + 1 < $2) ", $statement)
    };
}

mod attempts;
mod said;

/// First id of each kind. The ranges are far apart and distinguish generated rows from real ones.
const TRAINEES: i64 = 1_000_000_000;
const COHORTS: i64 = 2_000_000_000;
const ATTEMPTS: i64 = 3_000_000_000;
const INSTRUCTORS: i64 = 4_000_000_000;
/// Number of cohorts per instructor.
const COHORTS_EACH: i64 = 4;

/// Parameters of the data generated for a school with a published course.
#[derive(Clone, Copy, Debug)]
pub struct GeneratedCrowd<'a> {
    /// School.
    pub school_id: SchoolId,
    /// Number of trainees.
    pub trainees: u32,
    /// Number of trainees per cohort.
    pub cohort_size: u32,
    /// Number of attempts per trainee.
    pub attempts_each: u32,
    /// Hash of the password shared by all generated people.
    pub password_hash: &'a str,
    /// Time of the earliest attempt, in µs since 1970 UTC.
    pub from_us: i64,
    /// Interval between the attempts of a trainee, in µs.
    pub every_us: i64,
    /// A scored attempt whose recording, curve and metrics are reused by the generated ones.
    pub model: SessionId,
}

impl GeneratedCrowd<'_> {
    fn cohorts(&self) -> i64 {
        i64::from(self.trainees.div_ceil(self.cohort_size.max(1)))
    }

    fn instructors(&self) -> i64 {
        (self.cohorts() + COHORTS_EACH - 1) / COHORTS_EACH
    }

    /// Returns the first attempt id of a range of trainees, and the id after the last.
    fn attempts_of(&self, trainees: &Range<u32>) -> (SessionId, SessionId) {
        let first = |trainee: u32| id(ATTEMPTS + i64::from(trainee) * i64::from(self.attempts_each));
        (first(trainees.start), first(trainees.end))
    }
}

/// Returns the id with a number, equal to `unhex(printf('%032x', …))` in SQL.
fn id(number: i64) -> SessionId {
    SessionId::from_u128(u128::from(number.unsigned_abs()))
}

/// Returns the email address of a generated trainee.
#[must_use]
pub fn trainee_email(place: u32) -> String {
    format!("generated{place}@example.org")
}

/// Returns the email address of a generated instructor.
#[must_use]
pub fn instructor_email(place: u32) -> String {
    format!("instructor{place}@example.org")
}

/// Generates trainees, cohorts, instructors with four cohorts each, and their assignments.
pub async fn found(writer: &mut Connection, crowd: &GeneratedCrowd<'_>) -> Result<()> {
    // Random keys touch all pages of the indices, which must stay in the cache.
    engine::keep_more_in_memory(writer).await?;
    engine::suspend_triggers(writer).await?;
    trainees(writer, crowd).await?;
    instructors(writer, crowd).await?;
    cohorts(writer, crowd).await?;
    said::assignments(writer, crowd).await?;
    engine::resume_triggers(writer).await
}

/// Generates the attempts of a range of trainees, with scores, metrics, comments and reviews.
pub async fn practise(writer: &mut Connection, crowd: &GeneratedCrowd<'_>, trainees: Range<u32>) -> Result<()> {
    engine::suspend_triggers(writer).await?;
    attempts::add(writer, crowd, &trainees).await?;
    if is_doubled(&trainees) {
        engine::refresh_statistics(writer).await?;
    }
    let (from, to) = crowd.attempts_of(&trainees);
    attempts::score(writer, crowd, from, to).await?;
    attempts::sum_up(writer, crowd, from, to).await?;
    said::comments(writer, crowd, from, to).await?;
    said::reviews(writer, crowd, from, to).await?;
    engine::resume_triggers(writer).await
}

/// Returns whether the number of attempts has doubled since the planner's statistics were last
/// updated.
fn is_doubled(trainees: &Range<u32>) -> bool {
    let blocks = trainees.start / (trainees.end - trainees.start).max(1);
    blocks == 0 || blocks.is_power_of_two()
}

/// Computes the monthly sums of the school. It does not update the planner's statistics; PostgreSQL
/// does so by itself.
pub async fn conclude(writer: &mut Connection, crowd: &GeneratedCrowd<'_>) -> Result<()> {
    sqlx::query("DELETE FROM tallies WHERE school_id = $1").bind(crowd.school_id).execute(&mut *writer).await?;
    attempts::tally(writer, crowd).await
}

async fn trainees(writer: &mut Connection, crowd: &GeneratedCrowd<'_>) -> Result<()> {
    sqlx::query(counted!(
        "INSERT INTO people (id, school_id, role, email, display_name, pseudonym, password_hash, created_at, search, sort_name)
         SELECT unhex(printf('%032x', $5 + i)), $1, 'trainee', 'generated' || i || '@example.org',
           'Generated ' || substr(CAST(100000 + i AS TEXT), 2), 'generated-' || i, $3, $4,
           'generated ' || substr(CAST(100000 + i AS TEXT), 2) || ' generated' || i || '@example.org',
           'generated ' || substr(CAST(100000 + i AS TEXT), 2) FROM n"
    ))
    .bind(crowd.school_id)
    .bind(i64::from(crowd.trainees))
    .bind(crowd.password_hash)
    .bind(crowd.from_us)
    .bind(TRAINEES)
    .execute(writer)
    .await
    .map(drop)
}

async fn instructors(writer: &mut Connection, crowd: &GeneratedCrowd<'_>) -> Result<()> {
    sqlx::query(counted!(
        "INSERT INTO people (id, school_id, role, email, display_name, pseudonym, password_hash, created_at, search, sort_name)
         SELECT unhex(printf('%032x', $5 + i)), $1, 'instructor', 'instructor' || i || '@example.org',
           'Instructor ' || substr(CAST(10000 + i AS TEXT), 2), 'instructor-' || i, $3, $4,
           'instructor ' || substr(CAST(10000 + i AS TEXT), 2) || ' instructor' || i || '@example.org',
           'instructor ' || substr(CAST(10000 + i AS TEXT), 2) FROM n"
    ))
    .bind(crowd.school_id)
    .bind(crowd.instructors())
    .bind(crowd.password_hash)
    .bind(crowd.from_us)
    .bind(INSTRUCTORS)
    .execute(writer)
    .await
    .map(drop)
}

async fn cohorts(writer: &mut Connection, crowd: &GeneratedCrowd<'_>) -> Result<()> {
    sqlx::query(counted!(
        "INSERT INTO cohorts (id, school_id, name, created_at)
         SELECT unhex(printf('%032x', $4 + i)), $1, 'Generated ' || substr(CAST(10000 + i AS TEXT), 2), $3 FROM n"
    ))
    .bind(crowd.school_id)
    .bind(crowd.cohorts())
    .bind(crowd.from_us)
    .bind(COHORTS)
    .execute(&mut *writer)
    .await?;
    sqlx::query(counted!(
        "INSERT INTO cohort_members (school_id, cohort_id, person_id, role)
         SELECT $1, unhex(printf('%032x', $4 + i / $3)), unhex(printf('%032x', $5 + i)), 'trainee' FROM n"
    ))
    .bind(crowd.school_id)
    .bind(i64::from(crowd.trainees))
    .bind(i64::from(crowd.cohort_size))
    .bind(COHORTS)
    .bind(TRAINEES)
    .execute(&mut *writer)
    .await?;
    sqlx::query(counted!(
        "INSERT INTO cohort_members (school_id, cohort_id, person_id, role)
         SELECT $1, unhex(printf('%032x', $4 + i)), unhex(printf('%032x', $5 + i / $3)), 'instructor' FROM n"
    ))
    .bind(crowd.school_id)
    .bind(crowd.cohorts())
    .bind(COHORTS_EACH)
    .bind(COHORTS)
    .bind(INSTRUCTORS)
    .execute(writer)
    .await
    .map(drop)
}
