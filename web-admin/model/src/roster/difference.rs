//! What a roster would change.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::{AccountStanding, Refusal, Roster, RosterEntry, RosterMapping};
use crate::Role;
use crate::ids::PersonId;

/// A person of the school.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SchoolPerson {
    /// Id.
    pub id: PersonId,
    /// What the registrar knows them by.
    pub registrar_id: Option<String>,
    /// In lower case.
    pub email: String,
    /// As it is shown.
    pub name: String,
    /// What they are.
    pub role: Role,
    /// May sign in.
    pub enabled: bool,
    /// Names of their cohorts.
    pub cohorts: Vec<String>,
}

/// What is asked of an import.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RosterRequest {
    /// The cohort of everybody for whom the file names none.
    pub cohort: Option<String>,
    /// Trainees who are not in the file leave the cohorts that it fills.
    pub remove_missing: bool,
    /// Which column tells what; absent until somebody has said it.
    #[serde(default)]
    pub mapping: Option<RosterMapping>,
}

/// One thing that changes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RosterChange {
    /// The name, from what.
    Name(String),
    /// The address, from what.
    Email(String),
    /// The registrar's number, from what.
    RegistrarId(Option<String>),
    /// They join a cohort.
    Joins(String),
    /// They may sign in again.
    Enabled,
    /// They may no longer sign in.
    Disabled,
}

/// What comes of a line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RosterOutcome {
    /// Somebody is added.
    New,
    /// Somebody is changed.
    Changed {
        /// Who.
        person: PersonId,
        /// In what.
        changes: Vec<RosterChange>,
    },
    /// Everything is so already.
    Unchanged,
    /// The line is left out.
    Refused(Refusal),
}

/// A line and what comes of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LineOutcome {
    /// In the file, from 1.
    pub line: u64,
    /// What is shown of it.
    pub shown: String,
    /// Who it is about; absent where it could not be read.
    pub entry: Option<RosterEntry>,
    /// What comes of it.
    pub outcome: RosterOutcome,
}

/// Somebody who leaves a cohort since the file does not name them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Leaving {
    /// Who.
    pub person: PersonId,
    /// Their name.
    pub name: String,
    /// The cohort.
    pub cohort: String,
}

/// What a roster would change.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RosterDifference {
    /// Every line.
    pub lines: Vec<LineOutcome>,
    /// Who leaves a cohort.
    pub leaving: Vec<Leaving>,
}

impl RosterDifference {
    /// Compares a roster with the people of a school. `unusable` holds the addresses that cannot be used here.
    #[must_use]
    pub fn of(roster: &Roster, known: &[SchoolPerson], unusable: &BTreeSet<String>, wanted: &RosterRequest) -> Self {
        let index = Index::new(known, unusable);
        let mut lines = Vec::with_capacity(roster.rows.len());
        for row in &roster.rows {
            let line = row.line;
            lines.push(match &row.entry {
                Err((shown, refusal)) => LineOutcome {
                    line,
                    shown: shown.clone(),
                    entry: None,
                    outcome: RosterOutcome::Refused(refusal.clone()),
                },
                Ok(entry) => {
                    let mut entry = entry.clone();
                    if entry.cohorts.is_empty() {
                        entry.cohorts.extend(wanted.cohort.clone());
                    }
                    let shown = format!("{} <{}>", entry.name, entry.email);
                    LineOutcome { line, shown, outcome: index.outcome(&entry), entry: Some(entry) }
                }
            });
        }
        let leaving = if wanted.remove_missing { leaving(&lines, known) } else { Vec::new() };
        Self { lines, leaving }
    }

    /// How many lines add, change, leave as it is, and are refused.
    #[must_use]
    pub fn counts(&self) -> [usize; 4] {
        let count = |which: fn(&RosterOutcome) -> bool| self.lines.iter().filter(|line| which(&line.outcome)).count();
        [
            count(|outcome| matches!(outcome, RosterOutcome::New)),
            count(|outcome| matches!(outcome, RosterOutcome::Changed { .. })),
            count(|outcome| matches!(outcome, RosterOutcome::Unchanged)),
            count(|outcome| matches!(outcome, RosterOutcome::Refused(_))),
        ]
    }

    /// Nothing would happen.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let [new, changed, ..] = self.counts();
        new + changed + self.leaving.len() == 0
    }
}

/// The people of a school, to be found.
struct Index<'a> {
    by_email: BTreeMap<&'a str, &'a SchoolPerson>,
    by_number: BTreeMap<&'a str, &'a SchoolPerson>,
    unusable: &'a BTreeSet<String>,
}

impl<'a> Index<'a> {
    fn new(known: &'a [SchoolPerson], unusable: &'a BTreeSet<String>) -> Self {
        let numbered = known.iter().filter_map(|person| Some((person.registrar_id.as_deref()?, person)));
        Self {
            by_email: known.iter().map(|person| (person.email.as_str(), person)).collect(),
            by_number: numbered.collect(),
            unusable,
        }
    }

    fn outcome(&self, entry: &RosterEntry) -> RosterOutcome {
        let by_number = entry.registrar_id.as_deref().and_then(|number| self.by_number.get(number)).copied();
        let by_email = self.by_email.get(entry.email.as_str()).copied();
        if let (Some(one), Some(another)) = (by_number, by_email)
            && one.id != another.id
        {
            return RosterOutcome::Refused(Refusal::EmailOfAnother);
        }
        let Some(person) = by_number.or(by_email) else {
            if entry.standing == Some(AccountStanding::Gone) {
                return RosterOutcome::Refused(Refusal::GoneElsewhere);
            }
            let usable = !self.unusable.contains(&entry.email);
            return if usable { RosterOutcome::New } else { RosterOutcome::Refused(Refusal::EmailUnusable) };
        };
        if by_email.is_none() && self.unusable.contains(&entry.email) {
            return RosterOutcome::Refused(Refusal::EmailUnusable);
        }
        if person.role == Role::Administrator || entry.role.is_some_and(|role| role != person.role) {
            return RosterOutcome::Refused(Refusal::OtherRole(person.role));
        }
        match changes(entry, person) {
            changes if changes.is_empty() => RosterOutcome::Unchanged,
            changes => RosterOutcome::Changed { person: person.id, changes },
        }
    }
}

fn changes(entry: &RosterEntry, person: &SchoolPerson) -> Vec<RosterChange> {
    let mut changes = Vec::new();
    if entry.name != person.name {
        changes.push(RosterChange::Name(person.name.clone()));
    }
    if entry.email != person.email {
        changes.push(RosterChange::Email(person.email.clone()));
    }
    if entry.registrar_id.is_some() && entry.registrar_id != person.registrar_id {
        changes.push(RosterChange::RegistrarId(person.registrar_id.clone()));
    }
    let joined = entry.cohorts.iter().filter(|cohort| !person.cohorts.contains(cohort));
    changes.extend(joined.map(|cohort| RosterChange::Joins(cohort.clone())));
    match (entry.standing, person.enabled) {
        (Some(AccountStanding::Active), false) => changes.push(RosterChange::Enabled),
        (Some(AccountStanding::Gone), true) => changes.push(RosterChange::Disabled),
        _ => {}
    }
    changes
}

/// Trainees in the cohorts that the roster fills whom no line names, not even a refused one that was readable.
fn leaving(lines: &[LineOutcome], known: &[SchoolPerson]) -> Vec<Leaving> {
    let entries = || lines.iter().filter_map(|line| line.entry.as_ref());
    let filled: BTreeSet<&str> = entries().flat_map(|entry| entry.cohorts.iter().map(String::as_str)).collect();
    let addresses: BTreeSet<&str> = entries().map(|entry| entry.email.as_str()).collect();
    let numbers: BTreeSet<&str> = entries().filter_map(|entry| entry.registrar_id.as_deref()).collect();
    let named = |person: &SchoolPerson| {
        let by_number = person.registrar_id.as_deref().is_some_and(|number| numbers.contains(number));
        by_number || addresses.contains(person.email.as_str())
    };
    let missing = known.iter().filter(|person| person.role == Role::Trainee && !named(person));
    let leaves = missing.flat_map(|person| {
        let from = person.cohorts.iter().filter(|cohort| filled.contains(cohort.as_str()));
        from.map(|cohort| Leaving { person: person.id, name: person.name.clone(), cohort: cohort.clone() })
    });
    leaves.collect()
}
