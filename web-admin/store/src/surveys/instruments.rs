//! Published revisions of instruments.

use documents::Wording;
use model::Moment;
use model::ids::{RevisionId, SchoolId};
use model::titles::{StoredTitle, store_wording};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// A revision of an instrument.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct InstrumentRevision {
    /// Id of the revision.
    pub id: RevisionId,
    /// Id of the instrument.
    pub instrument_id: String,
    /// Title, in the reader's language.
    #[sqlx(try_from = "StoredTitle")]
    pub title: String,
    /// SHA-256 of the document.
    pub sha256: String,
    /// The document, byte for byte.
    pub bytes: Vec<u8>,
    /// Time of publication.
    pub published_at: Moment,
}

/// A revision to be published.
#[derive(Clone, Copy, Debug)]
pub struct NewInstrument<'a> {
    /// School.
    pub school_id: SchoolId,
    /// Id of the instrument.
    pub instrument_id: &'a str,
    /// Title, with the instrument's first language first.
    pub title: &'a Wording,
    /// SHA-256 of the document.
    pub sha256: &'a str,
    /// The document, byte for byte.
    pub bytes: &'a [u8],
}

/// Returns the revision with this hash, if there is one.
pub async fn find_instrument_by_hash(
    executor: impl Executor<'_>,
    school: SchoolId,
    sha256: &str,
) -> Result<Option<RevisionId>> {
    sqlx::query_scalar("SELECT id FROM instrument_revisions WHERE school_id = $1 AND sha256 = $2")
        .bind(school)
        .bind(sha256)
        .fetch_optional(executor)
        .await
}

/// Stores a revision.
///
/// # Errors
/// If this document was published before, or the database fails.
pub async fn publish_instrument(writer: &mut Connection, new: &NewInstrument<'_>, now: Moment) -> Result<RevisionId> {
    sqlx::query_scalar(
        "INSERT INTO instrument_revisions (id, school_id, instrument_id, title, sha256, bytes, published_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7) RETURNING id",
    )
    .bind(RevisionId::made_at(now))
    .bind(new.school_id)
    .bind(new.instrument_id)
    .bind(store_wording(new.title))
    .bind(new.sha256)
    .bind(new.bytes)
    .bind(now)
    .fetch_one(writer)
    .await
}

/// Makes a revision the current one, which new surveys use.
///
/// # Errors
/// If there is no such revision, or the database fails.
pub async fn make_current(
    writer: &mut Connection,
    school: SchoolId,
    instrument: &str,
    revision: RevisionId,
) -> Result<()> {
    sqlx::query(
        "INSERT INTO instruments (school_id, instrument_id, revision_id) VALUES ($1, $2, $3)
         ON CONFLICT (school_id, instrument_id) DO UPDATE SET revision_id = excluded.revision_id",
    )
    .bind(school)
    .bind(instrument)
    .bind(revision)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the current revision of an instrument, which new surveys use.
pub async fn find_current_instrument(
    executor: impl Executor<'_>,
    school: SchoolId,
    instrument: &str,
) -> Result<Option<InstrumentRevision>> {
    sqlx::query_as(
        "SELECT r.id, r.instrument_id, r.title, r.sha256, r.bytes, r.published_at FROM instruments i
         JOIN instrument_revisions r ON r.school_id = i.school_id AND r.id = i.revision_id
         WHERE i.school_id = $1 AND i.instrument_id = $2",
    )
    .bind(school)
    .bind(instrument)
    .fetch_optional(executor)
    .await
}

/// Returns the current revisions of all instruments, sorted by title.
pub async fn list_current_instruments(
    executor: impl Executor<'_>,
    school: SchoolId,
) -> Result<Vec<InstrumentRevision>> {
    sqlx::query_as(
        "SELECT r.id, r.instrument_id, r.title, r.sha256, r.bytes, r.published_at FROM instruments i
         JOIN instrument_revisions r ON r.school_id = i.school_id AND r.id = i.revision_id
         WHERE i.school_id = $1 ORDER BY r.title, r.instrument_id",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Returns a revision, current or not.
pub async fn find_instrument_revision(
    executor: impl Executor<'_>,
    school: SchoolId,
    id: RevisionId,
) -> Result<Option<InstrumentRevision>> {
    sqlx::query_as(
        "SELECT id, instrument_id, title, sha256, bytes, published_at FROM instrument_revisions
         WHERE school_id = $1 AND id = $2",
    )
    .bind(school)
    .bind(id)
    .fetch_optional(executor)
    .await
}
