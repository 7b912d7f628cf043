//! Logos of schools.

use model::ids::SchoolId;
use sqlx::FromRow;

use super::{Connection, Executor, Result};

/// A logo as a browser is given it.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct SchoolLogo {
    /// Its media type: PNG or JPEG.
    pub media_type: String,
    /// In pixels.
    #[sqlx(try_from = "i64")]
    pub width: u32,
    /// In pixels.
    #[sqlx(try_from = "i64")]
    pub height: u32,
    /// What is in it.
    pub bytes: Vec<u8>,
    /// Changes with what is in it.
    pub version: String,
}

/// The logo of a school, where it has one.
pub async fn find_logo(executor: impl Executor<'_>, school: SchoolId) -> Result<Option<SchoolLogo>> {
    sqlx::query_as("SELECT media_type, width, height, bytes, version FROM school_logos WHERE school_id = $1")
        .bind(school)
        .fetch_optional(executor)
        .await
}

/// Gives a school a logo in place of the one it had.
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

/// Takes a school's logo away. False where it has none.
pub async fn remove_logo(writer: &mut Connection, school: SchoolId) -> Result<bool> {
    sqlx::query("DELETE FROM school_logos WHERE school_id = $1")
        .bind(school)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}
