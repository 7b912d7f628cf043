//! A large database of generated people and attempts, to measure pages on. Nothing in it was ever practised.

use sqlx::SqliteConnection;
use uuid::Uuid;

use super::Result;

/// What to generate in a school whose course is published.
#[derive(Clone, Copy, Debug)]
pub struct Crowd<'a> {
    /// School.
    pub school_id: Uuid,
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
}

/// Generates people, cohorts (the first taught by every instructor), attempts, scores, and the sums over them. The numbers in the ids keep them apart.
///
/// # Errors
/// When the database fails.
pub async fn fill(writer: &mut SqliteConnection, crowd: &Crowd<'_>) -> Result<()> {
    people(writer, crowd).await?;
    cohorts(writer, crowd).await?;
    attempts(writer, crowd).await?;
    sums(writer, crowd).await?;
    sqlx::query("ANALYZE").execute(writer).await.map(drop)
}

async fn people(writer: &mut SqliteConnection, crowd: &Crowd<'_>) -> Result<()> {
    sqlx::query(
        "WITH RECURSIVE n (i) AS (SELECT 0 UNION ALL SELECT i + 1 FROM n WHERE i + 1 < $2)
         INSERT INTO people (id, school_id, role, email, display_name, pseudonym, password_hash, created_at)
         SELECT unhex(printf('%032x', 1000000000 + i)), $1, 'trainee', printf('generated%d@example.org', i),
           printf('Generated %05d', i), printf('generated-%d', i), $3, $4 FROM n",
    )
    .bind(crowd.school_id)
    .bind(crowd.trainees)
    .bind(crowd.password_hash)
    .bind(crowd.from_us)
    .execute(writer)
    .await
    .map(drop)
}

async fn cohorts(writer: &mut SqliteConnection, crowd: &Crowd<'_>) -> Result<()> {
    sqlx::query(
        "WITH RECURSIVE n (i) AS (SELECT 0 UNION ALL SELECT i + 1 FROM n WHERE (i + 1) * $3 < $2)
         INSERT INTO cohorts (id, school_id, name, created_at)
         SELECT unhex(printf('%032x', 2000000000 + i)), $1, printf('Generated %03d', i), $4 FROM n",
    )
    .bind(crowd.school_id)
    .bind(crowd.trainees)
    .bind(crowd.cohort_size)
    .bind(crowd.from_us)
    .execute(&mut *writer)
    .await?;
    sqlx::query(
        "WITH RECURSIVE n (i) AS (SELECT 0 UNION ALL SELECT i + 1 FROM n WHERE i + 1 < $2)
         INSERT INTO cohort_members (school_id, cohort_id, person_id, role)
         SELECT $1, unhex(printf('%032x', 2000000000 + i / $3)), unhex(printf('%032x', 1000000000 + i)), 'trainee'
         FROM n",
    )
    .bind(crowd.school_id)
    .bind(crowd.trainees)
    .bind(crowd.cohort_size)
    .execute(&mut *writer)
    .await?;
    sqlx::query(
        "INSERT INTO cohort_members (school_id, cohort_id, person_id, role)
         SELECT $1, unhex(printf('%032x', 2000000000)), id, 'instructor' FROM people
         WHERE school_id = $1 AND role = 'instructor'",
    )
    .bind(crowd.school_id)
    .execute(writer)
    .await
    .map(drop)
}

/// Each trainee goes through the school's exercises in turn, half an hour apart each day, and fails less and less.
async fn attempts(writer: &mut SqliteConnection, crowd: &Crowd<'_>) -> Result<()> {
    sqlx::query(
        "WITH RECURSIVE t (i) AS (SELECT 0 UNION ALL SELECT i + 1 FROM t WHERE i + 1 < $2),
           a (j) AS (SELECT 0 UNION ALL SELECT j + 1 FROM a WHERE j + 1 < $3),
           e AS (SELECT row_number() OVER (ORDER BY x.exercise_id) - 1 AS k, count(*) OVER () AS of, x.exercise_id,
                   x.revision_id, r.exercise_sha256, r.scene_sha256
                 FROM exercises x JOIN exercise_revisions r ON r.id = x.revision_id WHERE x.school_id = $1)
         INSERT INTO sessions (school_id, id, trainee_id, exercise_id, exercise_sha256, scene_sha256, revision_id,
           started_at, received_at, duration_s, complete, device, simulator_version, seed, state, recording_path,
           recording_sha256, recording_size, verify_deviation_n, verify_event_differences, verify_flagged)
         SELECT $1, unhex(printf('%032x', 3000000000 + i * $3 + j)), unhex(printf('%032x', 1000000000 + i)),
           e.exercise_id, e.exercise_sha256, e.scene_sha256, e.revision_id, $4 + (j * 86400 + (i % 16) * 1800) * 1000000,
           $4 + (j * 86400 + (i % 16) * 1800) * 1000000, 30.0, 1, 'generated', '0', '0', 'scored', 'generated', '', 0,
           0.0, 0, 0
         FROM t CROSS JOIN a JOIN e ON e.k = min(j * e.of / $3, e.of - 1)",
    )
    .bind(crowd.school_id)
    .bind(crowd.trainees)
    .bind(crowd.attempts_each)
    .bind(crowd.from_us)
    .execute(&mut *writer)
    .await?;
    sqlx::query(
        "INSERT INTO scores (id, school_id, session_id, score, passed, rubric_id, rubric_sha256, deductions, hard_fails,
           simulator_version, computed_at)
         SELECT s.id, s.school_id, s.id, 40 + abs(random()) % 60, abs(random()) % 5 < 4, s.exercise_id, '',
           '[{\"metric\":\"overshoot_mm\",\"points\":8.5,\"why\":\"overshoot 1.9 mm: −8.5 points\"}]', '[]', '0',
           s.received_at
         FROM sessions s WHERE s.school_id = $1 AND s.device = 'generated'",
    )
    .bind(crowd.school_id)
    .execute(writer)
    .await
    .map(drop)
}

async fn sums(writer: &mut SqliteConnection, crowd: &Crowd<'_>) -> Result<()> {
    sqlx::query(
        "INSERT INTO practice (school_id, trainee_id, exercise_id, attempts, passes, points, history)
         SELECT s.school_id, s.trainee_id, s.exercise_id, count(*), sum(c.passed), sum(c.score),
           json_group_array(json_array(lower(hex(s.id)), s.started_at, c.score,
             json(iif(c.passed, 'true', 'false')), lower(hex(s.revision_id))))
         FROM sessions s JOIN scores c ON c.school_id = s.school_id AND c.session_id = s.id
         WHERE s.school_id = $1 GROUP BY s.school_id, s.trainee_id, s.exercise_id",
    )
    .bind(crowd.school_id)
    .execute(&mut *writer)
    .await?;
    sqlx::query(
        "INSERT INTO tallies (school_id, cohort_id, month, attempts, passes, points)
         SELECT $1, coalesce(cohort_id, zeroblob(16)), month, count(*), sum(passed), sum(score)
         FROM (SELECT m.cohort_id, c.passed, c.score,
                 12 * CAST(strftime('%Y', s.started_at / 1000000, 'unixepoch') AS INTEGER)
                 + CAST(strftime('%m', s.started_at / 1000000, 'unixepoch') AS INTEGER) - 1 AS month
               FROM sessions s JOIN scores c ON c.school_id = s.school_id AND c.session_id = s.id
               JOIN (SELECT person_id, cohort_id FROM cohort_members WHERE role = 'trainee'
                     UNION ALL SELECT id, NULL FROM people WHERE role = 'trainee') m ON m.person_id = s.trainee_id
               WHERE s.school_id = $1)
         GROUP BY cohort_id, month",
    )
    .bind(crowd.school_id)
    .execute(writer)
    .await
    .map(drop)
}
