//! Generated attempts with their metrics and scores, and the sums over them.

use std::ops::Range;

use model::ids::SessionId;

use super::{ATTEMPTS, GeneratedCrowd, TRAINEES};
use crate::{Connection, Result};

/// Generates sessions: each trainee goes through the school's exercises in turn, with start times
/// spread over eight hours of a day and never equal. One re-simulation in a thousand differs, one
/// attempt in five fails, nine of ten are reviewed, and one in fifty has a question. Only the flags
/// are set here; the matching rows are inserted later.
pub(super) async fn add(writer: &mut Connection, crowd: &GeneratedCrowd<'_>, trainees: &Range<u32>) -> Result<()> {
    sqlx::query(
        "WITH RECURSIVE t (i) AS (SELECT CAST($7 AS BIGINT) UNION ALL SELECT i + 1 FROM t WHERE i + 1 < $2),
           a (j) AS (SELECT 0 UNION ALL SELECT j + 1 FROM a WHERE j + 1 < $3),
           e AS (SELECT row_number() OVER (ORDER BY x.exercise_id) - 1 AS k, count(*) OVER () AS of, x.exercise_id,
                   x.revision_id, r.exercise_sha256, r.scene_sha256
                 FROM exercises x JOIN exercise_revisions r ON r.id = x.revision_id WHERE x.school_id = $1)
         INSERT INTO sessions (school_id, id, trainee_id, exercise_id, exercise_sha256, scene_sha256, revision_id,
           started_at, received_at, duration_s, complete, device, simulator_version, seed, state, recording_path,
           recording_sha256, recording_size, verify_deviation_n, verify_event_differences, verify_flagged, reviewed, review_rank)
         SELECT $1, unhex(printf('%032x', $8 + i * $3 + j)), unhex(printf('%032x', $9 + i)),
           e.exercise_id, e.exercise_sha256, e.scene_sha256, e.revision_id, $4 + j * $5 + (i % 16) * 1800000000 + i * 1000,
           $4 + j * $5 + (i % 16) * 1800000000 + i * 1000, m.duration_s, TRUE, 'generated', m.simulator_version, '0', 'scored',
           m.recording_path, m.recording_sha256, m.recording_size, 0.0, 0, (i * $3 + j) % 1000 = 999, (i * $3 + j) % 10 <> 0,
           CASE WHEN (i * $3 + j) % 50 = 0 THEN 4 ELSE 0 END + CASE WHEN (i * $3 + j) % 1000 = 999 THEN 2 ELSE 0 END
             + CASE WHEN (i * $3 + j) * 2246822519 % 4294967296 / 65536 % 5 = 4 THEN 1 ELSE 0 END
         FROM sessions m CROSS JOIN t CROSS JOIN a JOIN e ON e.k = min(j * e.of / $3, e.of - 1)
         WHERE m.school_id = $1 AND m.id = $6",
    )
    .bind(crowd.school_id)
    .bind(i64::from(trainees.end))
    .bind(i64::from(crowd.attempts_each))
    .bind(crowd.from_us)
    .bind(crowd.every_us)
    .bind(crowd.model)
    .bind(i64::from(trainees.start))
    .bind(ATTEMPTS)
    .bind(TRAINEES)
    .execute(writer)
    .await
    .map(drop)
}

/// Generates pseudo-random scores and the grades derived from them; the model's metrics, varied,
/// for each trainee's latest attempt at each exercise and for one in ten of the others; and the
/// model's curve for one attempt in fifty.
pub(super) async fn score(
    writer: &mut Connection,
    crowd: &GeneratedCrowd<'_>,
    from: SessionId,
    to: SessionId,
) -> Result<()> {
    for statement in [
        "INSERT INTO scores (id, school_id, session_id, score, passed, rubric_id, rubric_sha256, deductions, hard_fails,
           simulator_version, computed_at)
         SELECT s.id, s.school_id, s.id, 40 + s.rowid * 2654435761 % 4294967296 / 65536 % 60,
           (s.review_rank & 1) = 0, s.exercise_id, c.rubric_sha256,
           c.deductions, '[]', s.simulator_version, s.received_at
         FROM sessions s JOIN scores c ON c.id = (SELECT id FROM scores WHERE school_id = $1 AND session_id = $2 LIMIT 1)
         WHERE s.school_id = $1 AND s.id >= $3 AND s.id < $4",
        "INSERT INTO grades (school_id, session_id, score_id, score, passed)
         SELECT c.school_id, c.session_id, c.id, c.score, c.passed FROM scores c
         WHERE c.school_id = $1 AND c.session_id <> $2 AND c.session_id >= $3 AND c.session_id < $4
         ON CONFLICT (school_id, session_id) DO NOTHING",
        "INSERT INTO metrics (school_id, session_id, id, version, position, value, unit, direction, applies, label, absent)
         SELECT s.school_id, s.id, m.id, m.version, m.position,
           m.value * (0.5 + (s.rowid * 37 + m.position) * 2654435761 % 4294967296 / 65536 % 1000 / 1000.0),
           m.unit, m.direction, m.applies, m.label, m.absent
         FROM sessions s JOIN metrics m ON m.school_id = s.school_id AND m.session_id = $2
         WHERE s.school_id = $1 AND s.id >= $3 AND s.id < $4 AND (s.rowid % 10 = 0 OR NOT EXISTS (
           SELECT 1 FROM sessions l WHERE l.school_id = $1 AND l.trainee_id = s.trainee_id
             AND l.exercise_id = s.exercise_id AND l.started_at > s.started_at))",
        "INSERT INTO session_curves (school_id, session_id, body)
         SELECT s.school_id, s.id, c.body
         FROM sessions s JOIN session_curves c ON c.school_id = s.school_id AND c.session_id = $2
         WHERE s.school_id = $1 AND s.id >= $3 AND s.id < $4 AND s.rowid % 50 = 0",
    ] {
        sqlx::query(statement)
            .bind(crowd.school_id)
            .bind(crowd.model)
            .bind(from)
            .bind(to)
            .execute(&mut *writer)
            .await?;
    }
    Ok(())
}

/// Inserts a practice row for each trainee and exercise.
pub(super) async fn sum_up(
    writer: &mut Connection,
    crowd: &GeneratedCrowd<'_>,
    from: SessionId,
    to: SessionId,
) -> Result<()> {
    sqlx::query(
        "INSERT INTO practice (school_id, trainee_id, exercise_id, attempts, passes, points, history)
         SELECT s.school_id, s.trainee_id, s.exercise_id, count(*), sum(g.passed), sum(g.score),
           json_group_array(json_array(lower(hex(s.id)), s.started_at, g.score,
             json(iif(g.passed, 'true', 'false')), lower(hex(s.revision_id))))
         FROM sessions s JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
         WHERE s.school_id = $1 AND s.id >= $2 AND s.id < $3 GROUP BY s.school_id, s.trainee_id, s.exercise_id",
    )
    .bind(crowd.school_id)
    .bind(from)
    .bind(to)
    .execute(writer)
    .await
    .map(drop)
}

/// Inserts the monthly sums of each cohort and of the school.
pub(super) async fn tally(writer: &mut Connection, crowd: &GeneratedCrowd<'_>) -> Result<()> {
    sqlx::query(
        "INSERT INTO tallies (school_id, cohort_id, month, attempts, passes, points)
         SELECT $1, coalesce(cohort_id, zeroblob(16)), month, count(*), sum(passed), sum(score)
         FROM (SELECT m.cohort_id, g.passed, g.score,
                 12 * CAST(strftime('%Y', s.started_at / 1000000, 'unixepoch') AS INTEGER)
                 + CAST(strftime('%m', s.started_at / 1000000, 'unixepoch') AS INTEGER) - 1 AS month
               FROM sessions s JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
               JOIN (SELECT person_id, cohort_id FROM cohort_members WHERE role = 'trainee'
                     UNION ALL SELECT id, NULL FROM people WHERE school_id = $1) m ON m.person_id = s.trainee_id
               WHERE s.school_id = $1) counted
         GROUP BY cohort_id, month",
    )
    .bind(crowd.school_id)
    .execute(writer)
    .await
    .map(drop)
}
