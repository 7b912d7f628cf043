//! Terms of a school: an administrator names them, and says which cohort belongs to which.

use model::ids::{CohortId, TermId};
use model::training::due;
use model::{CurrentPerson, single_line_text};
use serde_json::json;
use store::audit::AuditEntry;
use store::operations::schools;
use store::training::terms;
use store::training::terms::NewTerm;

use crate::error::Error;
use crate::service::Service;

/// Adds a term; `starts_on` is its first day in the school's time zone, as 2026-10-12.
///
/// # Errors
/// [`Error::Unprocessable`] for an invalid name or day, or the name of another term.
pub async fn add_term(state: &Service, by: &CurrentPerson, name: &str, starts_on: &str) -> Result<(), Error> {
    let name = single_line_text::title(name).map_err(Error::Unprocessable)?;
    let zone = schools::find_time_zone(state.db.reader(), by.school_id).await?;
    let starts_at = due::find_day_start(starts_on, &zone, 0).ok_or_else(|| {
        Error::Unprocessable(tr!("first day: “{day}”; enter a date like 2026-10-12", day = starts_on))
    })?;
    let (now, mut tx) = (state.clock.now(), state.db.write().await?);
    let new = NewTerm { name, starts_on, starts_at };
    let Some(id) = terms::add_term(&mut tx, by.school_id, new, now).await? else {
        return Err(Error::Unprocessable(tr!("there is a term “{name}” already", name = name)));
    };
    AuditEntry::by(by, "school.term_added", id).with(json!({ "starts_on": starts_on })).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

/// Removes a term; its cohorts then belong to none.
///
/// # Errors
/// [`Error::NotFound`] if the school has no such term.
pub async fn remove_term(state: &Service, by: &CurrentPerson, id: TermId) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    if !terms::remove_term(&mut tx, by.school_id, id).await? {
        return Err(Error::NotFound);
    }
    AuditEntry::by(by, "school.term_removed", id).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// Sets the term of a cohort, or removes it.
///
/// # Errors
/// [`Error::NotFound`] if the school has no such term.
pub async fn set_cohort_term(
    state: &Service,
    by: &CurrentPerson,
    cohort: CohortId,
    term: Option<TermId>,
) -> Result<(), Error> {
    let known = terms::list_terms(state.db.reader(), by.school_id).await?;
    if term.is_some_and(|term| !known.iter().any(|of| of.id == term)) {
        return Err(Error::NotFound);
    }
    let mut tx = state.db.write().await?;
    terms::put_cohort_term(&mut tx, by.school_id, cohort, term).await?;
    AuditEntry::by(by, "cohort.term_set", cohort)
        .with(json!({ "term": term }))
        .append(&mut tx, state.clock.now())
        .await?;
    Ok(tx.commit().await?)
}
