//! Pictures of briefings: of published revisions, which are immutable, and of drafts.

use data_encoding::HEXLOWER;
use documents::picture::PictureFile;
use model::ids::{DraftId, RevisionId, SchoolId};
use sha2::{Digest, Sha256};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// A picture, without its content.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct StoredPicture {
    /// Name used in the exercise.
    pub name: String,
    /// SHA-256 of the content, in lower-case hexadecimal.
    pub sha256: String,
    /// Width in pixels.
    #[sqlx(try_from = "i64")]
    pub width: u32,
    /// Height in pixels.
    #[sqlx(try_from = "i64")]
    pub height: u32,
}

/// A picture with its content.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct PictureBytes {
    /// Name used in the exercise.
    pub name: String,
    /// SHA-256 of the content, in lower-case hexadecimal.
    pub sha256: String,
    /// Content of the file.
    pub bytes: Vec<u8>,
}

/// Stores the pictures of a new revision, in order.
pub(crate) async fn insert_revision_pictures(
    writer: &mut Connection,
    revision: RevisionId,
    pictures: &[PictureFile],
) -> Result<()> {
    for (position, picture) in (0_i64..).zip(pictures) {
        sqlx::query(
            "INSERT INTO exercise_pictures (revision_id, position, name, sha256, width, height, bytes)
             VALUES ($1, $2, $3, $4, $5, $6, $7)",
        )
        .bind(revision)
        .bind(position)
        .bind(&picture.name)
        .bind(HEXLOWER.encode(&Sha256::digest(&picture.bytes)))
        .bind(i64::from(picture.size[0]))
        .bind(i64::from(picture.size[1]))
        .bind(&picture.bytes)
        .execute(&mut *writer)
        .await?;
    }
    Ok(())
}

/// Returns the pictures of a revision, in the order of the briefing.
pub async fn list_revision_pictures(
    executor: impl Executor<'_>,
    school: SchoolId,
    revision: RevisionId,
) -> Result<Vec<StoredPicture>> {
    sqlx::query_as(
        "SELECT p.name, p.sha256, p.width, p.height
         FROM exercise_revisions r JOIN exercise_pictures p ON p.revision_id = r.id
         WHERE r.school_id = $1 AND r.id = $2 ORDER BY p.position",
    )
    .bind(school)
    .bind(revision)
    .fetch_all(executor)
    .await
}

/// Returns a picture of the current revision of an exercise, by its position in the briefing, from
/// 0.
pub async fn read_current_picture(
    executor: impl Executor<'_>,
    school: SchoolId,
    exercise_id: &str,
    position: i64,
) -> Result<Option<PictureBytes>> {
    sqlx::query_as(
        "SELECT p.name, p.sha256, p.bytes FROM exercises e JOIN exercise_pictures p ON p.revision_id = e.revision_id
         WHERE e.school_id = $1 AND e.exercise_id = $2 AND p.position = $3",
    )
    .bind(school)
    .bind(exercise_id)
    .bind(position)
    .fetch_optional(executor)
    .await
}

/// Copies the pictures of a revision to a new draft that is based on it.
pub(crate) async fn copy_revision_pictures(
    writer: &mut Connection,
    draft: DraftId,
    revision: RevisionId,
) -> Result<()> {
    sqlx::query(
        "INSERT INTO draft_pictures (draft_id, name, sha256, width, height, bytes)
         SELECT $1, name, sha256, width, height, bytes FROM exercise_pictures WHERE revision_id = $2",
    )
    .bind(draft)
    .bind(revision)
    .execute(writer)
    .await
    .map(drop)
}

/// Adds a picture to a draft.
///
/// # Errors
/// If the draft has a picture with this name, or the database fails.
pub async fn add_draft_picture(writer: &mut Connection, draft: DraftId, picture: &PictureFile) -> Result<()> {
    sqlx::query(
        "INSERT INTO draft_pictures (draft_id, name, sha256, width, height, bytes) VALUES ($1, $2, $3, $4, $5, $6)",
    )
    .bind(draft)
    .bind(&picture.name)
    .bind(HEXLOWER.encode(&Sha256::digest(&picture.bytes)))
    .bind(i64::from(picture.size[0]))
    .bind(i64::from(picture.size[1]))
    .bind(&picture.bytes)
    .execute(writer)
    .await
    .map(drop)
}

/// Deletes a picture of a draft.
pub async fn drop_draft_picture(writer: &mut Connection, draft: DraftId, name: &str) -> Result<()> {
    sqlx::query("DELETE FROM draft_pictures WHERE draft_id = $1 AND name = $2")
        .bind(draft)
        .bind(name)
        .execute(writer)
        .await
        .map(drop)
}

/// Returns the pictures of a draft, sorted by name. Its text may not use all of them.
pub async fn list_draft_pictures(
    executor: impl Executor<'_>,
    school: SchoolId,
    draft: DraftId,
) -> Result<Vec<StoredPicture>> {
    sqlx::query_as(
        "SELECT p.name, p.sha256, p.width, p.height FROM drafts d JOIN draft_pictures p ON p.draft_id = d.id
         WHERE d.school_id = $1 AND d.id = $2 ORDER BY p.name",
    )
    .bind(school)
    .bind(draft)
    .fetch_all(executor)
    .await
}

/// Returns the pictures of a draft with their content.
pub async fn read_draft_pictures(
    executor: impl Executor<'_>,
    school: SchoolId,
    draft: DraftId,
) -> Result<Vec<PictureBytes>> {
    sqlx::query_as(
        "SELECT p.name, p.sha256, p.bytes FROM drafts d JOIN draft_pictures p ON p.draft_id = d.id
         WHERE d.school_id = $1 AND d.id = $2 ORDER BY p.name",
    )
    .bind(school)
    .bind(draft)
    .fetch_all(executor)
    .await
}

/// Returns a picture of a draft, by name.
pub async fn read_draft_picture(
    executor: impl Executor<'_>,
    school: SchoolId,
    draft: DraftId,
    name: &str,
) -> Result<Option<PictureBytes>> {
    sqlx::query_as(
        "SELECT p.name, p.sha256, p.bytes FROM drafts d JOIN draft_pictures p ON p.draft_id = d.id
         WHERE d.school_id = $1 AND d.id = $2 AND p.name = $3",
    )
    .bind(school)
    .bind(draft)
    .bind(name)
    .fetch_optional(executor)
    .await
}
