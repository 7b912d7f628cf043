//! Generated assignments, comments and reviews.

use model::ids::SessionId;

use super::{COHORTS, COHORTS_EACH, GeneratedCrowd, INSTRUCTORS};
use crate::{Connection, Result};

/// Generates two assignments per cohort: an exercise that is past its due date, and a course due in
/// a month.
pub(super) async fn assignments(writer: &mut Connection, crowd: &GeneratedCrowd<'_>) -> Result<()> {
    let until_us = crowd.from_us + crowd.every_us * i64::from(crowd.attempts_each);
    for statement in [
        counted!(
            "INSERT INTO assignments (id, school_id, exercise_id, cohort_id, supervised, due_local, time_zone, due_at,
           made_by, made_at)
         SELECT randomblob(16), $1, (SELECT min(exercise_id) FROM exercises WHERE school_id = $1),
           unhex(printf('%032x', $3 + i)), FALSE, strftime('%Y-%m-%dT%H:%M:%S', $7 / 2000000 + $6 / 2000000, 'unixepoch'),
           'UTC', ($7 / 2000000 + $6 / 2000000) * 1000000, unhex(printf('%032x', $4 + i / $5)), $6 FROM n"
        ),
        counted!(
            "INSERT INTO assignments (id, school_id, curriculum_id, cohort_id, supervised, due_local, time_zone, due_at,
           made_by, made_at)
         SELECT randomblob(16), $1, (SELECT min(curriculum_id) FROM curricula WHERE school_id = $1),
           unhex(printf('%032x', $3 + i)), FALSE, strftime('%Y-%m-%dT%H:%M:%S', $7 / 1000000 + 2592000, 'unixepoch'),
           'UTC', ($7 / 1000000 + 2592000) * 1000000, unhex(printf('%032x', $4 + i / $5)), $6 FROM n"
        ),
    ] {
        sqlx::query(statement)
            .bind(crowd.school_id)
            .bind(crowd.cohorts())
            .bind(COHORTS)
            .bind(INSTRUCTORS)
            .bind(COHORTS_EACH)
            .bind(crowd.from_us)
            .bind(until_us)
            .execute(&mut *writer)
            .await?;
    }
    Ok(())
}

/// Generates a trainee's question on each attempt flagged as having one.
pub(super) async fn comments(
    writer: &mut Connection,
    crowd: &GeneratedCrowd<'_>,
    from: SessionId,
    to: SessionId,
) -> Result<()> {
    sqlx::query(
        "INSERT INTO comments (id, school_id, session_id, author_id, kind, from_s, body, made_at)
         SELECT randomblob(16), school_id, id, trainee_id, 'question', 1.0, 'Was this the fascia?', received_at
         FROM sessions WHERE school_id = $1 AND id >= $2 AND id < $3 AND review_rank >= 4",
    )
    .bind(crowd.school_id)
    .bind(from)
    .bind(to)
    .execute(writer)
    .await
    .map(drop)
}

/// Generates the reviews of attempts flagged as reviewed.
pub(super) async fn reviews(
    writer: &mut Connection,
    crowd: &GeneratedCrowd<'_>,
    from: SessionId,
    to: SessionId,
) -> Result<()> {
    sqlx::query(
        "INSERT INTO reviews (school_id, session_id, reviewed_by, reviewed_at)
         SELECT s.school_id, s.id, m.person_id, s.received_at
         FROM sessions s
         JOIN cohort_members l ON l.person_id = s.trainee_id AND l.role = 'trainee'
         JOIN cohort_members m ON m.cohort_id = l.cohort_id AND m.role = 'instructor'
         WHERE s.school_id = $1 AND s.id >= $2 AND s.id < $3 AND s.reviewed",
    )
    .bind(crowd.school_id)
    .bind(from)
    .bind(to)
    .execute(writer)
    .await
    .map(drop)
}
