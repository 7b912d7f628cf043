//! Documents being written.

use model::Moment;
use model::ids::{DraftId, PersonId, RevisionId, SchoolId};
use sqlx::FromRow;

use super::pictures::copy_revision_pictures;
use super::{Connection, Executor, Result};

/// What a draft will be a revision of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, sqlx::Type)]
#[sqlx(type_name = "text", rename_all = "lowercase")]
pub enum DraftKind {
    /// An exercise with its scene.
    Exercise,
    /// A course.
    Course,
    /// An instrument.
    Instrument,
}

/// The texts of a draft.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Texts {
    /// The exercise, the course or the instrument, TOML.
    pub document: String,
    /// The exercise's scene, TOML; empty for any other.
    pub scene: String,
}

/// A draft.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct DocumentDraft {
    /// Its id.
    pub id: DraftId,
    /// What it will be a revision of …
    pub kind: DraftKind,
    /// … by the document's id.
    pub document_id: String,
    /// The revision of an exercise that its meshes come from.
    pub based_on: Option<RevisionId>,
    /// What is written.
    #[sqlx(flatten)]
    pub texts: Texts,
    /// Grows with each save.
    pub version: i64,
    /// Name of who saved it last.
    pub saved_by: String,
    /// When.
    pub saved_at: Moment,
}

/// A draft to be begun.
#[derive(Clone, Debug)]
pub struct NewDocumentDraft<'a> {
    /// What it will be a revision of …
    pub kind: DraftKind,
    /// … by the document's id.
    pub document_id: &'a str,
    /// The revision of an exercise that its meshes come from.
    pub based_on: Option<RevisionId>,
    /// What is written.
    pub texts: &'a Texts,
}

/// Somebody of a school, at a moment.
#[derive(Clone, Copy, Debug)]
pub struct DraftEditor {
    /// School.
    pub school: SchoolId,
    /// Person.
    pub person: PersonId,
    /// When.
    pub now: Moment,
}

/// The draft of a document, if somebody has begun one.
pub async fn find_draft_of(
    executor: impl Executor<'_>,
    school: SchoolId,
    kind: DraftKind,
    document_id: &str,
) -> Result<Option<DraftId>> {
    sqlx::query_scalar("SELECT id FROM drafts WHERE school_id = $1 AND kind = $2 AND document_id = $3")
        .bind(school)
        .bind(kind)
        .bind(document_id)
        .fetch_optional(executor)
        .await
}

/// Begins a draft, with the pictures of the revision that it is based on.
///
/// # Errors
/// When the document has one already, or the database fails.
pub async fn begin_draft(writer: &mut Connection, by: DraftEditor, draft: &NewDocumentDraft<'_>) -> Result<DraftId> {
    let id = DraftId::made_at(by.now);
    sqlx::query(
        "INSERT INTO drafts (id, school_id, kind, document_id, based_on, document, scene, version, saved_by, saved_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, 1, $8, $9)",
    )
    .bind(id)
    .bind(by.school)
    .bind(draft.kind)
    .bind(draft.document_id)
    .bind(draft.based_on)
    .bind(&draft.texts.document)
    .bind(&draft.texts.scene)
    .bind(by.person)
    .bind(by.now)
    .execute(&mut *writer)
    .await?;
    if let Some(revision) = draft.based_on {
        copy_revision_pictures(writer, id, revision).await?;
    }
    Ok(id)
}

/// A draft.
pub async fn find_draft(executor: impl Executor<'_>, school: SchoolId, id: DraftId) -> Result<Option<DocumentDraft>> {
    sqlx::query_as(
        "SELECT d.id, d.kind, d.document_id, d.based_on, d.document, d.scene, d.version, p.display_name AS saved_by,
         d.saved_at
         FROM drafts d JOIN people p ON p.id = d.saved_by WHERE d.school_id = $1 AND d.id = $2",
    )
    .bind(school)
    .bind(id)
    .fetch_optional(executor)
    .await
}

/// Every draft of a school, courses first, by the document's id.
pub async fn list_drafts(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<DocumentDraft>> {
    sqlx::query_as(
        "SELECT d.id, d.kind, d.document_id, d.based_on, d.document, d.scene, d.version, p.display_name AS saved_by,
         d.saved_at
         FROM drafts d JOIN people p ON p.id = d.saved_by WHERE d.school_id = $1 ORDER BY d.kind, d.document_id",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Saves a draft over the version that was seen; false when it is another by now.
pub async fn save_draft(
    writer: &mut Connection,
    by: DraftEditor,
    id: DraftId,
    seen: i64,
    texts: &Texts,
) -> Result<bool> {
    let saved = sqlx::query(
        "UPDATE drafts SET document = $1, scene = $2, version = version + 1, saved_by = $3, saved_at = $4
         WHERE school_id = $5 AND id = $6 AND version = $7",
    )
    .bind(&texts.document)
    .bind(&texts.scene)
    .bind(by.person)
    .bind(by.now)
    .bind(by.school)
    .bind(id)
    .bind(seen)
    .execute(writer)
    .await?;
    Ok(saved.rows_affected() == 1)
}

/// Says that a draft's meshes come from another revision: its scene does.
pub async fn rebase_draft(writer: &mut Connection, school: SchoolId, id: DraftId, revision: RevisionId) -> Result<()> {
    sqlx::query("UPDATE drafts SET based_on = $1 WHERE school_id = $2 AND id = $3")
        .bind(revision)
        .bind(school)
        .bind(id)
        .execute(writer)
        .await?;
    Ok(())
}

/// Removes a draft in the version that was seen: it has been published, or is not wanted any more. False when it is another
/// by now, or none.
pub async fn remove_draft(writer: &mut Connection, school: SchoolId, id: DraftId, seen: i64) -> Result<bool> {
    let removed = sqlx::query("DELETE FROM drafts WHERE school_id = $1 AND id = $2 AND version = $3")
        .bind(school)
        .bind(id)
        .bind(seen)
        .execute(writer)
        .await?;
    Ok(removed.rows_affected() == 1)
}
