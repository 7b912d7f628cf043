//! Surveys: publishes instruments, creates surveys and links, and stores answers.

pub mod answering;
mod making;
mod taking;
mod themes;

use documents::Instrument;
pub use making::{SurveyLink, SurveyRequest, close, letters_left, link_expiry, mail_links, make, make_links};
use model::ids::{RevisionId, SchoolId};
use model::search_key::fold_text;
use model::surveys::Survey;
use store::surveys::instruments as stored;
use store::surveys::instruments::InstrumentRevision;
pub use taking::{AnsweredSheet, take};
pub use themes::{Theme, set_theme};

use crate::error::Error;
use crate::service::Service;

/// Returns the instrument of a survey, in the revision with which the survey was created.
pub async fn instrument_of(state: &Service, survey: &Survey) -> Result<Instrument, Error> {
    revision(state, survey.school_id, survey.revision_id).await?.ok_or(Error::NotFound)
}

/// Lists the current revision of each instrument, sorted by its title in the current language.
///
/// # Errors
/// Fails if the database fails.
pub async fn list_titled_instruments(state: &Service, school: SchoolId) -> Result<Vec<InstrumentRevision>, Error> {
    let mut known = stored::list_current_instruments(state.db.reader(), school).await?;
    known.sort_by_cached_key(|revision| (fold_text(&revision.title), revision.instrument_id.clone()));
    Ok(known)
}

/// Returns a revision of an instrument. It was validated when published, so a parse error is an
/// internal error.
pub async fn revision(state: &Service, school: SchoolId, id: RevisionId) -> Result<Option<Instrument>, Error> {
    Ok(document(state, school, id).await?.map(|(instrument, _)| instrument))
}

/// Returns a revision of an instrument, with the document it was parsed from.
pub async fn document(
    state: &Service,
    school: SchoolId,
    id: RevisionId,
) -> Result<Option<(Instrument, Vec<u8>)>, Error> {
    let Some(found) = stored::find_instrument_revision(state.db.reader(), school, id).await? else { return Ok(None) };
    Ok(Some((read(&found.bytes)?, found.bytes)))
}

/// Parses a published instrument.
///
/// # Errors
/// Fails if this version does not accept it.
pub fn read(document: &[u8]) -> Result<Instrument, Error> {
    let parsed = Instrument::from_bytes("published instrument", document);
    Ok(parsed.map_err(|refused| anyhow::Error::new(refused).context("published questionnaire is invalid"))?)
}
