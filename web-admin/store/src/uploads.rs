//! Uploads that arrive in pieces: how far each has come, and what became of it.

use model::Moment;
use model::ids::{PersonId, SchoolId, SessionId, StationId, UploadId};
use sqlx::FromRow;

use super::tries::MOST_DEATHS;
use super::{Connection, Executor, Result};

/// Who began an upload, and alone may go on with it: a person, or a station by its token's id.
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
    /// The person who began it, or
    pub person_id: Option<PersonId>,
    /// the station that did.
    pub station_id: Option<StationId>,
    /// Length of the whole, in bytes.
    pub length: i64,
    /// Bytes that are on the disk.
    pub received: i64,
    /// `Upload-Metadata` as it was sent.
    pub metadata: String,
    /// When it is thrown away.
    pub expires_at: Moment,
    /// The attempt it has become.
    pub session_id: Option<SessionId>,
    /// How far the sender's clock was ahead of ours when it began, in µs, where it was told.
    pub clock_offset_us: Option<i64>,
    /// How often whoever read it as a recording has died of it.
    pub deaths: i64,
}

impl Upload {
    /// Every byte is there.
    #[must_use]
    pub const fn whole(&self) -> bool {
        self.received == self.length
    }

    /// It is read no more: [`super::tries`].
    #[must_use]
    pub const fn is_set_aside(&self) -> bool {
        self.deaths >= MOST_DEATHS && self.session_id.is_none()
    }
}

/// Begins an upload.
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

/// What is announced and has not become an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct Unfinished {
    /// Uploads.
    pub uploads: i64,
    /// Bytes in all, whether they have arrived or not.
    pub bytes: i64,
}

/// What an owner has begun, or with neither person nor station what all of a school have.
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

/// Bytes that uploads which have begun, of all schools, may still bring.
pub async fn sum_promised(executor: impl Executor<'_>, now: Moment) -> Result<i64> {
    sqlx::query_scalar(
        "SELECT CAST(coalesce(sum(length - received), 0) AS BIGINT) FROM uploads WHERE session_id IS NULL AND expires_at > $1",
    )
    .bind(now)
    .fetch_one(executor)
    .await
}

/// An upload of an owner.
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

/// Notes how many bytes are on the disk, and the new time limit.
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

/// Notes a piece that is an object of its own, and how far the upload has come with it. False where somebody else has brought it
/// further meanwhile: nothing is changed then, and the object counts as nothing.
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

/// The objects that are an upload, in order.
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

/// Notes which attempt an upload has become.
pub async fn finish_upload(writer: &mut Connection, school: SchoolId, id: UploadId, session: SessionId) -> Result<()> {
    sqlx::query("UPDATE uploads SET session_id = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .bind(session)
        .execute(writer)
        .await
        .map(drop)
}

/// Forgets an upload.
pub async fn remove_upload(writer: &mut Connection, school: SchoolId, id: UploadId) -> Result<()> {
    sqlx::query("DELETE FROM uploads WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .execute(writer)
        .await
        .map(drop)
}

/// Ids of every school's uploads: for tidying.
pub async fn list_uploads(executor: impl Executor<'_>) -> Result<Vec<UploadId>> {
    sqlx::query_scalar("SELECT id FROM uploads ORDER BY id").fetch_all(executor).await
}

/// An upload of any school: for tidying.
pub async fn find_upload_by_id(executor: impl Executor<'_>, id: UploadId) -> Result<Option<Upload>> {
    sqlx::query_as("SELECT * FROM uploads WHERE id = $1").bind(id).fetch_optional(executor).await
}

/// Forgets every upload that has not become an attempt: in a copy of the database, whose pieces are not beside it.
pub async fn forget_unfinished(writer: &mut Connection) -> Result<()> {
    sqlx::query("DELETE FROM uploads WHERE session_id IS NULL").execute(writer).await.map(drop)
}
