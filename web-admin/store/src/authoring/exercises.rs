//! Published exercises. Revisions are immutable.

use std::collections::BTreeMap;

use documents::Wording;
use documents::picture::PictureFile;
use model::Moment;
use model::ids::{RevisionId, SchoolId};
use model::titles::{StoredTitle, store_wording};
use serde::{Deserialize, Serialize};
use sqlx::FromRow;

use crate::authoring::pictures::insert_revision_pictures;
use crate::{Connection, Executor, Pool, Result};

/// A revision to be published.
#[derive(Clone, Debug)]
pub struct NewRevision<'a> {
    /// Exercise id.
    pub exercise_id: &'a str,
    /// Title shown to people.
    pub title: &'a Wording,
    /// Difficulty, 1–5.
    pub difficulty: u8,
    /// Score needed to pass, 0–100.
    pub pass_mark: f64,
    /// SHA-256 of the exercise document.
    pub exercise_sha256: &'a str,
    /// SHA-256 of the scene document.
    pub scene_sha256: &'a str,
    /// SHA-256 over the exercise, the scene, all meshes and all pictures.
    pub bundle_sha256: &'a str,
    /// The exercise document, byte for byte.
    pub exercise_bytes: &'a [u8],
    /// The scene document, byte for byte.
    pub scene_bytes: &'a [u8],
    /// Meshes: name in the scene, and content.
    pub meshes: &'a [(String, Vec<u8>)],
    /// Pictures of the briefing, in order.
    pub pictures: &'a [PictureFile],
}

/// A published revision, without its documents.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct Revision {
    /// Id of the revision.
    pub id: RevisionId,
    /// Exercise id.
    pub exercise_id: String,
    /// Title shown to people.
    #[sqlx(try_from = "StoredTitle")]
    pub title: String,
    /// Difficulty, 1–5.
    #[sqlx(try_from = "i64")]
    pub difficulty: u8,
    /// Score needed to pass, 0–100.
    pub pass_mark: f64,
    /// SHA-256 of the exercise document.
    pub exercise_sha256: String,
    /// SHA-256 of the scene document.
    pub scene_sha256: String,
    /// Time of publication.
    pub published_at: Moment,
}

/// Documents and meshes of a revision, byte for byte.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RevisionBytes {
    /// The exercise document.
    pub exercise: Vec<u8>,
    /// The scene document.
    pub scene: Vec<u8>,
    /// Meshes: name in the scene, and content.
    pub meshes: Vec<(String, Vec<u8>)>,
}

/// Returns the revision with this bundle hash, if it was ever published.
pub async fn find_revision_by_bundle(
    executor: impl Executor<'_>,
    school: SchoolId,
    bundle_sha256: &str,
) -> Result<Option<RevisionId>> {
    sqlx::query_scalar("SELECT id FROM exercise_revisions WHERE school_id = $1 AND bundle_sha256 = $2")
        .bind(school)
        .bind(bundle_sha256)
        .fetch_optional(executor)
        .await
}

/// Returns the newest revision with the exercise id and the two document hashes of a recording's
/// metadata.
pub async fn by_documents(
    executor: impl Executor<'_>,
    school: SchoolId,
    session: &recording::Session,
) -> Result<Option<RevisionId>> {
    // `rowid` is the order of insertion, which does not depend on the clock.
    sqlx::query_scalar(
        "SELECT id FROM exercise_revisions
         WHERE school_id = $1 AND exercise_sha256 = $2 AND scene_sha256 = $3 AND exercise_id = $4
         ORDER BY rowid DESC LIMIT 1",
    )
    .bind(school)
    .bind(&session.exercise_sha256)
    .bind(&session.scene_sha256)
    .bind(&session.exercise_id)
    .fetch_optional(executor)
    .await
}

/// Stores a revision with its meshes and pictures.
///
/// # Errors
/// If this revision was published before, or the database fails.
pub async fn publish_exercise(
    writer: &mut Connection,
    school: SchoolId,
    revision: &NewRevision<'_>,
    now: Moment,
) -> Result<RevisionId> {
    let id = RevisionId::made_at(now);
    sqlx::query(
        "INSERT INTO exercise_revisions (id, school_id, exercise_id, title, difficulty, pass_mark, exercise_sha256,
         scene_sha256, bundle_sha256, exercise_bytes, scene_bytes, published_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12)",
    )
    .bind(id)
    .bind(school)
    .bind(revision.exercise_id)
    .bind(store_wording(revision.title))
    .bind(i64::from(revision.difficulty))
    .bind(revision.pass_mark)
    .bind(revision.exercise_sha256)
    .bind(revision.scene_sha256)
    .bind(revision.bundle_sha256)
    .bind(revision.exercise_bytes)
    .bind(revision.scene_bytes)
    .bind(now)
    .execute(&mut *writer)
    .await?;
    for (position, (name, bytes)) in (0_i64..).zip(revision.meshes) {
        insert_mesh(writer, id, position, name, bytes).await?;
    }
    insert_revision_pictures(writer, id, revision.pictures).await?;
    Ok(id)
}

async fn insert_mesh(
    writer: &mut Connection,
    revision_id: RevisionId,
    position: i64,
    name: &str,
    bytes: &[u8],
) -> Result<()> {
    sqlx::query("INSERT INTO exercise_meshes (revision_id, position, name, bytes) VALUES ($1, $2, $3, $4)")
        .bind(revision_id)
        .bind(position)
        .bind(name)
        .bind(bytes)
        .execute(writer)
        .await
        .map(drop)
}

/// Makes a revision the current one, which trainees are given from `now` on. Records when the
/// previous revision was replaced.
pub async fn make_current(
    writer: &mut Connection,
    school: SchoolId,
    exercise_id: &str,
    revision: RevisionId,
    now: Moment,
) -> Result<()> {
    sqlx::query(
        "INSERT INTO replaced_revisions (revision_id, replaced_at)
         SELECT revision_id, $3 FROM exercises WHERE school_id = $1 AND exercise_id = $2",
    )
    .bind(school)
    .bind(exercise_id)
    .bind(now)
    .execute(&mut *writer)
    .await?;
    sqlx::query("DELETE FROM replaced_revisions WHERE revision_id = $1").bind(revision).execute(&mut *writer).await?;
    sqlx::query(
        "INSERT INTO exercises (school_id, exercise_id, revision_id) VALUES ($1, $2, $3)
         ON CONFLICT (school_id, exercise_id) DO UPDATE SET revision_id = excluded.revision_id",
    )
    .bind(school)
    .bind(exercise_id)
    .bind(revision)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the time at which a revision was replaced by another, if it was.
pub async fn find_replacement_time(
    executor: impl Executor<'_>,
    school: SchoolId,
    revision: RevisionId,
) -> Result<Option<Moment>> {
    sqlx::query_scalar(
        "SELECT p.replaced_at FROM replaced_revisions p JOIN exercise_revisions r ON r.id = p.revision_id
         WHERE r.school_id = $1 AND r.id = $2",
    )
    .bind(school)
    .bind(revision)
    .fetch_optional(executor)
    .await
}

/// Returns the current revision of an exercise, which trainees are given.
pub async fn find_current_revision(
    executor: impl Executor<'_>,
    school: SchoolId,
    exercise_id: &str,
) -> Result<Option<Revision>> {
    sqlx::query_as(
        "SELECT r.id, r.exercise_id, r.title, r.difficulty, r.pass_mark, r.exercise_sha256, r.scene_sha256,
         r.published_at
         FROM exercises e JOIN exercise_revisions r ON r.id = e.revision_id
         WHERE e.school_id = $1 AND e.exercise_id = $2",
    )
    .bind(school)
    .bind(exercise_id)
    .fetch_optional(executor)
    .await
}

/// Returns all revisions of an exercise, newest first.
pub async fn list_exercise_revisions(
    executor: impl Executor<'_>,
    school: SchoolId,
    exercise_id: &str,
) -> Result<Vec<Revision>> {
    // `rowid` is the order of insertion, which does not depend on the clock.
    sqlx::query_as(
        "SELECT id, exercise_id, title, difficulty, pass_mark, exercise_sha256, scene_sha256, published_at
         FROM exercise_revisions WHERE school_id = $1 AND exercise_id = $2 ORDER BY rowid DESC",
    )
    .bind(school)
    .bind(exercise_id)
    .fetch_all(executor)
    .await
}

/// Returns the current revisions of a school, sorted by difficulty, then by title.
pub async fn list_current_exercises(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<Revision>> {
    sqlx::query_as(
        "SELECT r.id, r.exercise_id, r.title, r.difficulty, r.pass_mark, r.exercise_sha256, r.scene_sha256,
         r.published_at
         FROM exercises e JOIN exercise_revisions r ON r.id = e.revision_id
         WHERE e.school_id = $1 ORDER BY r.difficulty, r.title, r.exercise_id",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Returns the documents and meshes of a revision.
pub async fn read_exercise_bytes(
    reader: &Pool,
    school: SchoolId,
    revision: RevisionId,
) -> Result<Option<RevisionBytes>> {
    let documents: Option<(Vec<u8>, Vec<u8>)> =
        sqlx::query_as("SELECT exercise_bytes, scene_bytes FROM exercise_revisions WHERE school_id = $1 AND id = $2")
            .bind(school)
            .bind(revision)
            .fetch_optional(reader)
            .await?;
    let Some((exercise, scene)) = documents else { return Ok(None) };
    let meshes = sqlx::query_as("SELECT name, bytes FROM exercise_meshes WHERE revision_id = $1 ORDER BY position")
        .bind(revision)
        .fetch_all(reader)
        .await?;
    Ok(Some(RevisionBytes { exercise, scene, meshes }))
}

/// Returns the documents and meshes of all current revisions of a school, by exercise. It takes two
/// queries, independently of the number of exercises.
pub async fn all_documents(reader: &Pool, school: SchoolId) -> Result<BTreeMap<String, RevisionBytes>> {
    let documents: Vec<(String, Vec<u8>, Vec<u8>)> = sqlx::query_as(
        "SELECT e.exercise_id, r.exercise_bytes, r.scene_bytes
         FROM exercises e JOIN exercise_revisions r ON r.id = e.revision_id WHERE e.school_id = $1",
    )
    .bind(school)
    .fetch_all(reader)
    .await?;
    let meshes: Vec<(String, String, Vec<u8>)> = sqlx::query_as(
        "SELECT e.exercise_id, m.name, m.bytes FROM exercises e JOIN exercise_meshes m ON m.revision_id = e.revision_id
         WHERE e.school_id = $1 ORDER BY e.exercise_id, m.position",
    )
    .bind(school)
    .fetch_all(reader)
    .await?;
    let own = |(id, exercise, scene)| (id, RevisionBytes { exercise, scene, meshes: Vec::new() });
    let mut all: BTreeMap<String, RevisionBytes> = documents.into_iter().map(own).collect();
    for (id, name, bytes) in meshes {
        if let Some(revision) = all.get_mut(&id) {
            revision.meshes.push((name, bytes));
        }
    }
    Ok(all)
}
