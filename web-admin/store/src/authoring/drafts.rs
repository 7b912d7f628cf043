//! Drafts of documents: exercises, courses and instruments.

use model::Moment;
use model::ids::{DraftId, PersonId, RevisionId, SchoolId};
use sqlx::FromRow;

use crate::authoring::pictures::copy_revision_pictures;
use crate::{Connection, Executor, Result};

/// Kind of document.
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

crate::engine::read_natively!(Text: DraftKind);

/// The texts of a draft.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Texts {
    /// Document of the exercise, course or instrument, as TOML.
    pub document: String,
    /// Scene of the exercise, as TOML; empty for other kinds.
    pub scene: String,
}

/// A draft.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct DocumentDraft {
    /// Id.
    pub id: DraftId,
    /// Kind of document.
    pub kind: DraftKind,
    /// Id of the document.
    pub document_id: String,
    /// Exercise revision that provides the meshes.
    pub based_on: Option<RevisionId>,
    /// Text of the draft.
    #[sqlx(flatten)]
    pub texts: Texts,
    /// Version, incremented on each save.
    pub version: i64,
    /// Name of the person who saved it last.
    pub saved_by: String,
    /// Time of the last save.
    pub saved_at: Moment,
}

/// A draft to be created.
#[derive(Clone, Debug)]
pub struct NewDocumentDraft<'a> {
    /// Kind of document.
    pub kind: DraftKind,
    /// Id of the document.
    pub document_id: &'a str,
    /// Exercise revision that provides the meshes.
    pub based_on: Option<RevisionId>,
    /// Initial text.
    pub texts: &'a Texts,
}

/// Author and time of a change.
#[derive(Clone, Copy, Debug)]
pub struct DraftEditor {
    /// School.
    pub school: SchoolId,
    /// Person.
    pub person: PersonId,
    /// Time of the change.
    pub now: Moment,
}

/// Returns the id of the draft of a document, if there is one.
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

/// Creates a draft, with the pictures of the revision that it is based on.
///
/// # Errors
/// If the document already has a draft, or the database fails.
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

/// Returns a draft.
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

/// Returns all drafts of a school, sorted by kind (courses first), then by document id.
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

/// Saves a draft, provided that it still has the version `seen`. Returns false if it was changed in
/// the meantime.
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

/// Sets the revision that provides a draft's meshes, when its scene is taken from that revision.
pub async fn rebase_draft(writer: &mut Connection, school: SchoolId, id: DraftId, revision: RevisionId) -> Result<()> {
    sqlx::query("UPDATE drafts SET based_on = $1 WHERE school_id = $2 AND id = $3")
        .bind(revision)
        .bind(school)
        .bind(id)
        .execute(writer)
        .await?;
    Ok(())
}

/// Deletes a draft that was published or discarded, provided that it still has the version `seen`.
/// Returns false if it was changed or deleted in the meantime.
pub async fn remove_draft(writer: &mut Connection, school: SchoolId, id: DraftId, seen: i64) -> Result<bool> {
    let removed = sqlx::query("DELETE FROM drafts WHERE school_id = $1 AND id = $2 AND version = $3")
        .bind(school)
        .bind(id)
        .bind(seen)
        .execute(writer)
        .await?;
    Ok(removed.rows_affected() == 1)
}
