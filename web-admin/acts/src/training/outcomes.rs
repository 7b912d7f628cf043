//! Outcomes of a school, and the levels entrusted to trainees.

use std::collections::BTreeMap;

use model::ids::{OutcomeId, PersonId};
use model::training::outcome::{LONGEST_NOTE, MOST_OUTCOMES, OutcomeText, check_length, read_catalogue, read_levels};
use model::{CurrentPerson, PersonKey, Role, count_i64};
use serde_json::json;
use store::Connection;
use store::audit::AuditEntry;
use store::training::outcomes::{self, NewEntrustment};
use store::training::{curricula, reports};

use crate::error::Error;
use crate::service::Service;

/// Number of default levels, as long as a school has set none.
pub const DEFAULT_LEVELS: usize = 5;

/// An outcome with the courses that lead to it.
#[derive(Clone, Debug)]
pub struct OutcomeSettings {
    /// Texts.
    pub text: OutcomeText,
    /// Ids of courses.
    pub courses: Vec<String>,
    /// Whether it is retired.
    pub is_retired: bool,
}

/// Adds an outcome and returns its id.
///
/// # Errors
/// Returns [`Error::Unprocessable`] if a text is refused, the code is taken, or there are too many
/// outcomes.
pub async fn add_outcome(service: &Service, by: &CurrentPerson, text: OutcomeText) -> Result<OutcomeId, Error> {
    let text = text.checked().map_err(Error::Unprocessable)?;
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    if outcomes::list_outcomes(&mut *tx, by.school_id).await?.len() >= MOST_OUTCOMES {
        return Err(refuse_number());
    }
    let added = outcomes::add_outcome(&mut tx, by.school_id, &text, now).await?;
    let id = added.ok_or_else(|| refuse_code(&text.code))?;
    AuditEntry::by(by, "outcome.added", id).with(json!({ "code": text.code })).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(id)
}

fn refuse_code(code: &str) -> Error {
    Error::Unprocessable(tr!("code: another outcome has “{code}”", code = code))
}

fn refuse_number() -> Error {
    Error::Unprocessable(tr!("a school has at most {most} outcomes", most = MOST_OUTCOMES))
}

/// Changes an outcome and its courses.
///
/// # Errors
/// Returns [`Error::NotFound`] if the school has no such outcome, [`Error::Unprocessable`] if a text
/// is refused, the code is taken or a course is unknown.
pub async fn change_outcome(
    service: &Service,
    by: &CurrentPerson,
    id: OutcomeId,
    settings: OutcomeSettings,
) -> Result<(), Error> {
    let text = settings.text.checked().map_err(Error::Unprocessable)?;
    let taught = curricula::list_taught_curricula(service.db.reader(), by.school_id).await?;
    if let Some(unknown) = settings.courses.iter().find(|id| taught.iter().all(|course| course.curriculum_id != **id)) {
        return Err(Error::Unprocessable(tr!("course: “{course}” is unknown", course = unknown)));
    }
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    let before = outcomes::find_outcome(&mut *tx, by.school_id, id).await?.ok_or(Error::NotFound)?;
    if !outcomes::change_outcome(&mut tx, by.school_id, id, &text).await? {
        return Err(refuse_code(&text.code));
    }
    outcomes::replace_courses(&mut tx, by.school_id, id, &settings.courses).await?;
    if before.retired_at.is_some() != settings.is_retired {
        outcomes::retire_outcome(&mut tx, by.school_id, id, settings.is_retired.then_some(now)).await?;
    }
    let told = json!({ "code": text.code, "courses": settings.courses, "retired": settings.is_retired });
    AuditEntry::by(by, "outcome.changed", id).with(told).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

/// Numbers of outcomes that an import added and changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ImportedOutcomes {
    /// Added.
    pub added: usize,
    /// Changed.
    pub changed: usize,
    /// Unchanged.
    pub unchanged: usize,
}

/// Imports a catalogue: adds new outcomes and changes known ones, which have the same identifier or
/// code. Outcomes that are not in the file stay.
///
/// # Errors
/// Returns [`Error::Unprocessable`] if the file is refused, a code is taken, or there are too many
/// outcomes; then nothing has changed.
pub async fn import_catalogue(service: &Service, by: &CurrentPerson, file: &[u8]) -> Result<ImportedOutcomes, Error> {
    let catalogue = read_catalogue(file).map_err(Error::Unprocessable)?;
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    let known = outcomes::list_outcomes(&mut *tx, by.school_id).await?;
    let by_code: BTreeMap<&str, usize> = known.iter().enumerate().map(|(at, one)| (one.code.as_str(), at)).collect();
    let by_source: BTreeMap<&str, usize> = known
        .iter()
        .enumerate()
        .filter(|(_, one)| !one.source.is_empty())
        .map(|(at, one)| (one.source.as_str(), at))
        .collect();
    let mut imported = ImportedOutcomes::default();
    for text in catalogue {
        // An outcome of another catalogue with the same code is another outcome.
        let same_code = by_code.get(text.code.as_str()).map(|at| &known[*at]);
        let same_code = same_code.filter(|one| one.source.is_empty() || text.source.is_empty());
        let Some(one) = by_source.get(text.source.as_str()).map(|at| &known[*at]).or(same_code) else {
            let added = outcomes::add_outcome(&mut tx, by.school_id, &text, now).await?;
            added.ok_or_else(|| refuse_code(&text.code))?;
            imported.added += 1;
            continue;
        };
        let source = if text.source.is_empty() { one.source.clone() } else { text.source };
        let text = OutcomeText { source, ..text };
        if is_same(one, &text) {
            imported.unchanged += 1;
        } else if outcomes::change_outcome(&mut tx, by.school_id, one.id, &text).await? {
            imported.changed += 1;
        } else {
            return Err(refuse_code(&text.code));
        }
    }
    if known.len() + imported.added > MOST_OUTCOMES {
        return Err(refuse_number());
    }
    let told = json!({ "added": imported.added, "changed": imported.changed });
    AuditEntry::by(by, "outcome.imported", by.school_id).with(told).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(imported)
}

fn is_same(one: &outcomes::Outcome, text: &OutcomeText) -> bool {
    (&one.code, &one.title, &one.description, &one.source) == (&text.code, &text.title, &text.description, &text.source)
}

/// Sets the names of the levels, one per line, lowest first.
///
/// # Errors
/// Returns [`Error::Unprocessable`] if a name is refused, or there are fewer levels than the highest
/// one that is entrusted.
pub async fn set_levels(service: &Service, by: &CurrentPerson, text: &str) -> Result<(), Error> {
    let names = read_levels(text).map_err(Error::Unprocessable)?;
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    let highest = outcomes::find_highest_level(&mut *tx, by.school_id).await?;
    if count_i64(names.len()) < highest {
        return Err(Error::Unprocessable(tr!(
            "levels: {count} names; level {highest} is entrusted already",
            count = names.len(),
            highest = highest
        )));
    }
    outcomes::replace_levels(&mut tx, by.school_id, &names).await?;
    AuditEntry::by(by, "outcome.levels_set", by.school_id)
        .with(json!({ "levels": names }))
        .append(&mut tx, now)
        .await?;
    Ok(tx.commit().await?)
}

/// Returns whether a person decides on levels of others, if they see them: staff, but not about
/// themselves.
#[must_use]
pub fn may_decide(by: &CurrentPerson, trainee: PersonId) -> bool {
    matches!(by.role, Role::Instructor | Role::Administrator) && by.id != trainee
}

/// A decision to entrust.
#[derive(Clone, Copy, Debug)]
pub struct Decision<'a> {
    /// The outcome.
    pub outcome_id: OutcomeId,
    /// Level, from 1; `None` ends the entrustment.
    pub level: Option<i64>,
    /// Reason; may be empty.
    pub note: &'a str,
}

/// Entrusts a level of an outcome to a trainee whom the person teaches. Only a person decides:
/// nothing in the program calls this by itself.
///
/// # Errors
/// Returns [`Error::NotFound`] if the trainee or outcome is not theirs to see, [`Error::Forbidden`]
/// if they are not staff or decide about themselves, [`Error::Unprocessable`] for an unknown level
/// or too long a note.
pub async fn entrust_level(
    service: &Service,
    by: &CurrentPerson,
    whom: PersonKey,
    decision: Decision<'_>,
) -> Result<(), Error> {
    if !may_decide(by, whom.person_id) {
        return Err(Error::Forbidden(tr!("only an instructor of the trainee decides on a level")));
    }
    let note = decision.note.trim();
    check_length(tr!("note"), note, 0, LONGEST_NOTE).map_err(Error::Unprocessable)?;
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    reports::trainee(&mut *tx, by, whom.person_id).await?.ok_or(Error::NotFound)?;
    let outcome = outcomes::find_outcome(&mut *tx, by.school_id, decision.outcome_id).await?;
    let outcome = outcome.ok_or(Error::NotFound)?;
    let levels = count_levels(&mut tx, by).await?;
    if let Some(level) = decision.level
        && !(1..=levels).contains(&level)
    {
        return Err(Error::Unprocessable(tr!("level: {level}; allowed: 1 to {most}", level = level, most = levels)));
    }
    let new = NewEntrustment { outcome_id: outcome.id, person: whom, level: decision.level, note, decided_by: by.id };
    outcomes::add_entrustment(&mut tx, new, now).await?;
    let told = json!({ "outcome": outcome.code, "level": decision.level });
    AuditEntry::by(by, "outcome.entrusted", whom.person_id).with(told).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

async fn count_levels(tx: &mut Connection, by: &CurrentPerson) -> Result<i64, Error> {
    let set = outcomes::list_levels(tx, by.school_id).await?.len();
    Ok(count_i64(if set == 0 { DEFAULT_LEVELS } else { set }))
}
