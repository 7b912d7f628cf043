//! Resumable uploads: their progress and results.

use model::Moment;
use model::ids::{PersonId, SchoolId, SessionId, StationId, UploadId};
use sqlx::FromRow;

use crate::recordings::parse_attempts::MAX_CRASHES;
use crate::{Connection, Executor, Result};

/// The person, or the station with its token's id, that started an upload and alone may continue
/// it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UploadOwner {
    /// School.
    pub school_id: SchoolId,
    /// The person, or
    pub person_id: Option<PersonId>,
    /// the station.
    pub station_id: Option<StationId>,
}

/// An upload.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Upload {
    /// Id.
    pub id: UploadId,
    /// School.
    pub school_id: SchoolId,
    /// The person who started it, or
    pub person_id: Option<PersonId>,
    /// the station.
    pub station_id: Option<StationId>,
    /// Total length, in bytes.
    pub length: i64,
    /// Number of stored bytes.
    pub received: i64,
    /// Header `Upload-Metadata`, as received.
    pub metadata: String,
    /// Time at which it is deleted.
    pub expires_at: Moment,
    /// Resulting attempt.
    pub session_id: Option<SessionId>,
    /// Offset of the sender's clock at the start, in µs, positive if it is ahead; `None` if
    /// unknown.
    pub clock_offset_us: Option<i64>,
    /// Number of crashes while it was parsed.
    pub deaths: i64,
}

impl Upload {
    /// Returns whether all bytes have been received.
    #[must_use]
    pub const fn whole(&self) -> bool {
        self.received == self.length
    }

    /// Returns whether it is quarantined; see [`crate::recordings::parse_attempts`].
    #[must_use]
    pub const fn is_set_aside(&self) -> bool {
        self.deaths >= MAX_CRASHES && self.session_id.is_none()
    }
}

/// Stores a new upload.
pub async fn insert_upload(writer: &mut Connection, upload: &Upload) -> Result<()> {
    sqlx::query(
        "INSERT INTO uploads (id, school_id, person_id, station_id, length, metadata, expires_at, clock_offset_us)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8)",
    )
    .bind(upload.id)
    .bind(upload.school_id)
    .bind(upload.person_id)
    .bind(upload.station_id)
    .bind(upload.length)
    .bind(&upload.metadata)
    .bind(upload.expires_at)
    .bind(upload.clock_offset_us)
    .execute(writer)
    .await
    .map(drop)
}

/// Uploads that have not become attempts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct Unfinished {
    /// Number of uploads.
    pub uploads: i64,
    /// Total length in bytes, received or not.
    pub bytes: i64,
}

/// Returns the unfinished uploads of an owner; without a person and a station, those of the whole
/// school.
pub async fn count_unfinished_uploads(executor: impl Executor<'_>, owner: UploadOwner) -> Result<Unfinished> {
    sqlx::query_as(
        "SELECT count(*) AS uploads, CAST(coalesce(sum(length), 0) AS BIGINT) AS bytes FROM uploads
         WHERE school_id = $1 AND session_id IS NULL
         AND ($2 IS NULL OR person_id = $2) AND ($3 IS NULL OR station_id = $3)",
    )
    .bind(owner.school_id)
    .bind(owner.person_id)
    .bind(owner.station_id)
    .fetch_one(executor)
    .await
}

/// Returns the number of bytes that unfinished uploads of all schools may still send.
pub async fn sum_promised(executor: impl Executor<'_>, now: Moment) -> Result<i64> {
    sqlx::query_scalar(
        "SELECT CAST(coalesce(sum(length - received), 0) AS BIGINT) FROM uploads WHERE session_id IS NULL AND expires_at > $1",
    )
    .bind(now)
    .fetch_one(executor)
    .await
}

/// Returns an upload of an owner.
pub async fn find_upload(executor: impl Executor<'_>, owner: UploadOwner, id: UploadId) -> Result<Option<Upload>> {
    sqlx::query_as(
        "SELECT * FROM uploads WHERE school_id = $1 AND id = $2
         AND person_id IS NOT DISTINCT FROM $3 AND station_id IS NOT DISTINCT FROM $4",
    )
    .bind(owner.school_id)
    .bind(id)
    .bind(owner.person_id)
    .bind(owner.station_id)
    .fetch_optional(executor)
    .await
}

/// Stores the number of received bytes and the new expiry time.
pub async fn advance_upload(writer: &mut Connection, upload: &Upload) -> Result<()> {
    sqlx::query("UPDATE uploads SET received = $3, expires_at = $4 WHERE school_id = $1 AND id = $2")
        .bind(upload.school_id)
        .bind(upload.id)
        .bind(upload.received)
        .bind(upload.expires_at)
        .execute(writer)
        .await
        .map(drop)
}

/// Stores a part that is a separate object, and the progress of the upload. Returns false without
/// any change if another request has advanced the upload in the meantime; the object is then
/// unused.
pub async fn add_piece(writer: &mut Connection, upload: &Upload, begins: i64, object: &str) -> Result<bool> {
    let advanced = sqlx::query(
        "UPDATE uploads SET received = $3, expires_at = $4 WHERE school_id = $1 AND id = $2 AND received = $5",
    )
    .bind(upload.school_id)
    .bind(upload.id)
    .bind(upload.received)
    .bind(upload.expires_at)
    .bind(begins)
    .execute(&mut *writer)
    .await?;
    if advanced.rows_affected() == 0 {
        return Ok(false);
    }
    sqlx::query("INSERT INTO upload_pieces (upload_id, begins, object) VALUES ($1, $2, $3)")
        .bind(upload.id)
        .bind(begins)
        .bind(object)
        .execute(writer)
        .await?;
    Ok(true)
}

/// Returns the objects of an upload, in order.
pub async fn list_pieces(executor: impl Executor<'_>, upload: &Upload) -> Result<Vec<String>> {
    sqlx::query_scalar(
        "SELECT p.object FROM upload_pieces p JOIN uploads u ON u.id = p.upload_id
         WHERE u.school_id = $1 AND u.id = $2 ORDER BY p.begins",
    )
    .bind(upload.school_id)
    .bind(upload.id)
    .fetch_all(executor)
    .await
}

/// Records the attempt that an upload has become.
pub async fn finish_upload(writer: &mut Connection, school: SchoolId, id: UploadId, session: SessionId) -> Result<()> {
    sqlx::query("UPDATE uploads SET session_id = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .bind(session)
        .execute(writer)
        .await
        .map(drop)
}

/// Deletes an upload.
pub async fn remove_upload(writer: &mut Connection, school: SchoolId, id: UploadId) -> Result<()> {
    sqlx::query("DELETE FROM uploads WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .execute(writer)
        .await
        .map(drop)
}

/// Returns the ids of the uploads of all schools, for the clean-up.
pub async fn list_uploads(executor: impl Executor<'_>) -> Result<Vec<UploadId>> {
    sqlx::query_scalar("SELECT id FROM uploads ORDER BY id").fetch_all(executor).await
}

/// Returns an upload of any school, for the clean-up.
pub async fn find_upload_by_id(executor: impl Executor<'_>, id: UploadId) -> Result<Option<Upload>> {
    sqlx::query_as("SELECT * FROM uploads WHERE id = $1").bind(id).fetch_optional(executor).await
}

/// Deletes all uploads that have not become attempts, in a copy of the database without their
/// files.
pub async fn forget_unfinished(writer: &mut Connection) -> Result<()> {
    sqlx::query("DELETE FROM uploads WHERE session_id IS NULL").execute(writer).await.map(drop)
}
