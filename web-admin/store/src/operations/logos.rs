//! Logos of schools.

use model::ids::SchoolId;
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// A logo.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct SchoolLogo {
    /// Media type: PNG or JPEG.
    pub media_type: String,
    /// Width, in pixels.
    #[sqlx(try_from = "i64")]
    pub width: u32,
    /// Height, in pixels.
    #[sqlx(try_from = "i64")]
    pub height: u32,
    /// Content of the file.
    pub bytes: Vec<u8>,
    /// Version, which changes with the content.
    pub version: String,
}

/// Returns the logo of a school, if it has one.
pub async fn find_logo(executor: impl Executor<'_>, school: SchoolId) -> Result<Option<SchoolLogo>> {
    sqlx::query_as("SELECT media_type, width, height, bytes, version FROM school_logos WHERE school_id = $1")
        .bind(school)
        .fetch_optional(executor)
        .await
}

/// Sets or replaces the logo of a school.
pub async fn put_logo(writer: &mut Connection, school: SchoolId, logo: &SchoolLogo) -> Result<()> {
    sqlx::query(
        "INSERT INTO school_logos (school_id, media_type, width, height, bytes, version) VALUES ($1, $2, $3, $4, $5, $6)
         ON CONFLICT (school_id) DO UPDATE SET media_type = excluded.media_type, width = excluded.width,
           height = excluded.height, bytes = excluded.bytes, version = excluded.version",
    )
    .bind(school)
    .bind(&logo.media_type)
    .bind(i64::from(logo.width))
    .bind(i64::from(logo.height))
    .bind(&logo.bytes)
    .bind(&logo.version)
    .execute(writer)
    .await
    .map(drop)
}

/// Deletes the logo of a school. Returns false if it has none.
pub async fn remove_logo(writer: &mut Connection, school: SchoolId) -> Result<bool> {
    sqlx::query("DELETE FROM school_logos WHERE school_id = $1")
        .bind(school)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}
