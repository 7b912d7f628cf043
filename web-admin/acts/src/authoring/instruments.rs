//! Instruments: publication as revisions, and conversion between TOML and JSON.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use anyhow::Context;
use documents::{DocumentError, Instrument, Issue};
use model::ids::{RevisionId, SchoolId, SurveyId};
use model::surveys::{FRESH_HOURS, Identity};
use model::{CurrentPerson, Moment};
use phrase::{Phrase, phrase};
use serde_json::json;
use store::Connection;
use store::audit::{Actor, AuditEntry};
use store::surveys::instruments::NewInstrument;
use store::surveys::{self, NewSurvey, instruments as stored};

use crate::authoring::publishing::{CourseRefused, DocumentPublisher, Published};
use crate::error::Error;
use crate::service::Service;

/// Lists the TOML documents in the subfolder `instruments` of a folder, or in the folder itself if
/// it has that name, sorted.
///
/// # Errors
/// Fails if a folder cannot be read.
pub fn documents_in(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let own = folder.file_name().is_some_and(|name| name == "instruments");
    let folder = if own { folder.to_owned() } else { folder.join("instruments") };
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        found.push(entry?.path());
    }
    found.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    found.sort();
    Ok(found)
}

/// Publishes an instrument from a file. A revision with identical bytes is reused.
///
/// # Errors
/// Fails if the document is invalid, or the database fails.
pub async fn publish(
    writer: &mut Connection,
    school: SchoolId,
    path: &Path,
    now: Moment,
) -> Result<Published, CourseRefused> {
    let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
    let instrument = Instrument::from_bytes(&path.display().to_string(), &bytes)?;
    Ok(publish_text(writer, &DocumentPublisher { school, by: Actor::CommandLine, now }, &instrument, &bytes).await?)
}

/// Publishes a parsed instrument, with the bytes it was parsed from.
pub async fn publish_text(
    writer: &mut Connection,
    publisher: &DocumentPublisher,
    instrument: &Instrument,
    bytes: &[u8],
) -> anyhow::Result<Published> {
    let DocumentPublisher { school, now, .. } = *publisher;
    let known = stored::find_instrument_by_hash(&mut *writer, school, &instrument.sha256).await?;
    let first = instrument.languages.first().map_or("en", String::as_str);
    let new = NewInstrument {
        school_id: school,
        instrument_id: &instrument.id,
        title: &instrument.title.as_wording(first),
        sha256: &instrument.sha256,
        bytes,
    };
    let revision = match known {
        Some(revision) => revision,
        None => stored::publish_instrument(writer, &new, now).await?,
    };
    let before = stored::find_current_instrument(&mut *writer, school, &instrument.id).await?.map(|current| current.id);
    if before != Some(revision) {
        stored::make_current(writer, school, &instrument.id, revision).await?;
        let details = json!({ "revision": revision, "sha256": instrument.sha256, "before": before });
        publisher.did("instrument.published", &instrument.id).with(details).append(writer, now).await?;
    }
    Ok(Published { kind: "instrument", id: instrument.id.clone(), new: known.is_none() })
}

/// Creates the surveys that the courses of a school require after attempts, if they are missing. A
/// survey of an older revision is closed and keeps its answers.
pub async fn course_surveys(writer: &mut Connection, school: SchoolId, now: Moment) -> anyhow::Result<()> {
    let asked = surveys::asked_by_courses(&mut *writer, school).await?;
    let open = surveys::of_course(&mut *writer, school).await?;
    for survey in open.iter().filter(|survey| !asked.iter().any(|(revision, ..)| *revision == survey.revision_id)) {
        surveys::close(writer, school, survey.id, Some(now)).await?;
        entry(school, "survey.closed", survey.id).append(writer, now).await?;
    }
    for same in asked.chunk_by(|a, b| a.0 == b.0) {
        let (revision_id, title, _) = &same[0];
        let known = open.iter().find(|survey| survey.revision_id == *revision_id).map(|survey| survey.id);
        let id = match known {
            Some(id) => id,
            None => make_for_course(writer, school, *revision_id, title, now).await?,
        };
        for (.., exercise) in same {
            surveys::add_exercise(writer, school, id, exercise).await?;
        }
    }
    Ok(())
}

async fn make_for_course(
    writer: &mut Connection,
    school_id: SchoolId,
    revision_id: RevisionId,
    title: &str,
    now: Moment,
) -> anyhow::Result<SurveyId> {
    let new = NewSurvey {
        school_id,
        revision_id,
        title,
        owner_id: None,
        identity: Identity::Pseudonymous,
        after_attempts: true,
        fresh_hours: Some(FRESH_HOURS),
        study: None,
        generated: false,
        opens_at: now,
        closes_at: None,
    };
    let id = surveys::insert(writer, &new, now).await?;
    entry(school_id, "survey.made", id).append(writer, now).await?;
    Ok(id)
}

fn entry(school: SchoolId, action: &str, survey: SurveyId) -> AuditEntry<'_> {
    AuditEntry::new(school, Actor::CommandLine, action, survey).with(json!({ "by": "a course" }))
}

/// Converts a document to JSON.
///
/// # Errors
/// Fails if it is not TOML.
pub fn to_json(bytes: &[u8]) -> anyhow::Result<String> {
    let table: toml::Table = toml::from_str(std::str::from_utf8(bytes)?)?;
    Ok(serde_json::to_string_pretty(&table)?)
}

/// Converts an instrument from JSON to TOML.
///
/// # Errors
/// Fails if it is not JSON, with the place of the error.
pub fn from_json(text: &str) -> Result<String, DocumentError> {
    let table: toml::Table =
        serde_json::from_str(text).map_err(|error| no_document(error.line(), error.column(), error))?;
    toml::to_string_pretty(&table).map_err(|error| no_document(1, 1, error))
}

fn no_document(line: usize, column: usize, error: impl Display) -> DocumentError {
    let [file, field] = ["document", "JSON"].map(str::to_owned);
    Issue { file, line, column, field, found: Phrase::data(error), allowed: phrase!("not well-formed") }.into()
}

/// Publishes an instrument written in the browser. Returns false if `new` is set and its id is in
/// use.
pub async fn publish_written(
    state: &Service,
    by: &CurrentPerson,
    instrument: &Instrument,
    bytes: &[u8],
    new: bool,
) -> Result<bool, Error> {
    let (now, school, mut tx) = (state.clock.now(), by.school_id, state.db.write().await?);
    if new && stored::find_current_instrument(&mut *tx, school, &instrument.id).await?.is_some() {
        return Ok(false);
    }
    publish_text(&mut tx, &DocumentPublisher { school, by: Actor::Person(by.id), now }, instrument, bytes).await?;
    course_surveys(&mut tx, school, now).await?;
    tx.commit().await?;
    Ok(true)
}
