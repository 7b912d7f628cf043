//! Origins whose pages may upload to a school from a browser (CORS).

use model::ids::SchoolId;

use crate::{Connection, Executor, Result};

/// Returns the origins that a school allows, sorted.
pub async fn list_school_origins(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<String>> {
    sqlx::query_scalar("SELECT origin FROM school_origins WHERE school_id = $1 ORDER BY origin")
        .bind(school)
        .fetch_all(executor)
        .await
}

/// Returns whether any school allows an origin. The school is unknown in a preflight request, which
/// carries no token.
pub async fn is_origin_allowed(executor: impl Executor<'_>, origin: &str) -> Result<bool> {
    sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM school_origins WHERE origin = $1)")
        .bind(origin)
        .fetch_one(executor)
        .await
}

/// Replaces the allowed origins of a school.
pub async fn replace_origins(writer: &mut Connection, school: SchoolId, origins: &[String]) -> Result<()> {
    sqlx::query("DELETE FROM school_origins WHERE school_id = $1").bind(school).execute(&mut *writer).await?;
    for origin in origins {
        sqlx::query("INSERT INTO school_origins (school_id, origin) VALUES ($1, $2) ON CONFLICT DO NOTHING")
            .bind(school)
            .bind(origin)
            .execute(&mut *writer)
            .await?;
    }
    Ok(())
}
