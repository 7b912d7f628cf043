//! A large database of generated people and attempts, to measure pages on. Nothing in it was ever practised.
//!
//! [`found`] makes the people, [`practise`] the attempts of some of them, and [`conclude`] the sums over all: three steps, so
//! that each can be a transaction of a size that the disk bears.

use std::ops::Range;

use model::ids::{SchoolId, SessionId};

use super::{Connection, Result, engine};

/// A statement that selects from `n`, whose `i` counts from 0 up to $2.
macro_rules! counted {
    ($statement:literal) => {
        concat!("WITH RECURSIVE n (i) AS (SELECT 0 UNION ALL SELECT i + 1 FROM n WHERE i + 1 < $2) ", $statement)
    };
}

mod attempts;
mod said;

/// The first ids of each kind, far apart; the numbers in them keep generated rows apart from others.
const TRAINEES: i64 = 1_000_000_000;
const COHORTS: i64 = 2_000_000_000;
const ATTEMPTS: i64 = 3_000_000_000;
const INSTRUCTORS: i64 = 4_000_000_000;
/// How many cohorts an instructor teaches.
const COHORTS_EACH: i64 = 4;

/// What to generate in a school whose course is published.
#[derive(Clone, Copy, Debug)]
pub struct GeneratedCrowd<'a> {
    /// School.
    pub school_id: SchoolId,
    /// How many trainees.
    pub trainees: u32,
    /// How many trainees a cohort has.
    pub cohort_size: u32,
    /// Attempts of each trainee.
    pub attempts_each: u32,
    /// Everybody's password, hashed.
    pub password_hash: &'a str,
    /// The earliest attempt, in µs since 1970 UTC.
    pub from_us: i64,
    /// From an attempt to the next of the same trainee, in µs.
    pub every_us: i64,
    /// A scored attempt whose recording, curve and metrics the generated ones share.
    pub model: SessionId,
}

impl GeneratedCrowd<'_> {
    fn cohorts(&self) -> i64 {
        i64::from(self.trainees.div_ceil(self.cohort_size.max(1)))
    }

    fn instructors(&self) -> i64 {
        (self.cohorts() + COHORTS_EACH - 1) / COHORTS_EACH
    }

    /// The ids of the attempts of some trainees, by their places: the first, and the one after the last.
    fn attempts_of(&self, trainees: &Range<u32>) -> (SessionId, SessionId) {
        let first = |trainee: u32| id(ATTEMPTS + i64::from(trainee) * i64::from(self.attempts_each));
        (first(trainees.start), first(trainees.end))
    }
}

/// The id with a number, as `unhex(printf('%032x', …))` makes it.
fn id(number: i64) -> SessionId {
    SessionId::from_u128(u128::from(number.unsigned_abs()))
}

/// The address of a generated trainee.
#[must_use]
pub fn trainee_email(place: u32) -> String {
    format!("generated{place}@example.org")
}

/// The address of a generated instructor.
#[must_use]
pub fn instructor_email(place: u32) -> String {
    format!("instructor{place}@example.org")
}

/// Generates trainees, cohorts, instructors with four cohorts each, and what these have assigned.
pub async fn found(writer: &mut Connection, crowd: &GeneratedCrowd<'_>) -> Result<()> {
    // The indices grow at random places.
    engine::keep_more_in_memory(writer).await?;
    engine::suspend_triggers(writer).await?;
    trainees(writer, crowd).await?;
    instructors(writer, crowd).await?;
    cohorts(writer, crowd).await?;
    said::assignments(writer, crowd).await?;
    engine::resume_triggers(writer).await
}

/// Generates the attempts of some trainees, by their places, with their scores and metrics, and what was said about them.
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

/// Whether the school is twice as large as when this was last so: then the planner needs to know.
fn is_doubled(trainees: &Range<u32>) -> bool {
    let blocks = trainees.start / (trainees.end - trainees.start).max(1);
    blocks == 0 || blocks.is_power_of_two()
}

/// Sums the school up. The planner is told nothing of its size but what a server finds out by itself.
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
