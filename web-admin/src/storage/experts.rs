//! Experts who let their attempts be shown to others, as one curve among at least five.

use sqlx::types::Json;
use sqlx::{SqliteConnection, SqliteExecutor};
use uuid::Uuid;

use super::Result;
use crate::domain::{Curve, Moment};

/// Most experts whose attempts are taken together.
const MOST: u32 = 50;

/// Records that somebody consents. False where they already did.
///
/// # Errors
/// When either is of another school, or the database fails.
pub async fn consent(
    writer: &mut SqliteConnection,
    (school, person): (Uuid, Uuid),
    (recorded_by, note): (Uuid, &str),
    now: Moment,
) -> Result<bool> {
    sqlx::query(
        "INSERT INTO expert_consents (school_id, person_id, given_at, recorded_by, note) VALUES ($1, $2, $3, $4, $5)
         ON CONFLICT (school_id, person_id) DO NOTHING",
    )
    .bind(school)
    .bind(person)
    .bind(now)
    .bind(recorded_by)
    .bind(note)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Takes a consent back. False where there is none.
///
/// # Errors
/// When the database fails.
pub async fn withdraw(writer: &mut SqliteConnection, school: Uuid, person: Uuid) -> Result<bool> {
    sqlx::query("DELETE FROM expert_consents WHERE school_id = $1 AND person_id = $2")
        .bind(school)
        .bind(person)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// When somebody consented, if they do.
///
/// # Errors
/// When the database fails.
pub async fn consented(executor: impl SqliteExecutor<'_>, school: Uuid, person: Uuid) -> Result<Option<Moment>> {
    sqlx::query_scalar("SELECT given_at FROM expert_consents WHERE school_id = $1 AND person_id = $2")
        .bind(school)
        .bind(person)
        .fetch_optional(executor)
        .await
}

/// The newest passed attempt of each consenting expert at an exercise.
///
/// # Errors
/// When the database fails.
pub async fn curves(executor: impl SqliteExecutor<'_>, school: Uuid, exercise: &str) -> Result<Vec<Curve>> {
    let curves: Vec<Json<Curve>> = sqlx::query_scalar(
        "SELECT c.body FROM expert_consents e
         JOIN session_curves c ON c.school_id = e.school_id AND c.session_id = (
           SELECT s.id FROM sessions s JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
           WHERE s.school_id = e.school_id AND s.trainee_id = e.person_id AND s.exercise_id = $2 AND g.passed = 1
           ORDER BY s.started_at DESC LIMIT 1)
         WHERE e.school_id = $1 ORDER BY e.person_id LIMIT $3",
    )
    .bind(school)
    .bind(exercise)
    .bind(MOST)
    .fetch_all(executor)
    .await?;
    Ok(curves.into_iter().map(|json| json.0).collect())
}
