//! What a roster would change.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::{AccountStanding, LineMention, Refusal, RefusedLine, Roster, RosterEntry, RosterMapping};
use crate::Role;
use crate::email::normalize_email;
use crate::folding::look_alike_key;
use crate::ids::PersonId;
use crate::line::tidy;

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
    /// It is about the person of an earlier line, and was read together with it.
    Together(u64),
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

impl RosterOutcome {
    /// Whether the line asks for nothing that is not so already, or that an earlier line does not ask for.
    #[must_use]
    pub const fn changes_nothing(&self) -> bool {
        matches!(self, Self::Unchanged | Self::Together(_))
    }
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
                Err(refused) => {
                    let RefusedLine { shown, refusal, .. } = &**refused;
                    let outcome = match refusal {
                        Refusal::SamePerson(first) => RosterOutcome::Together(*first),
                        refusal => RosterOutcome::Refused(refusal.clone()),
                    };
                    LineOutcome { line, shown: shown.clone(), entry: None, outcome }
                }
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
        let mentions = || roster.rows.iter().filter_map(|row| row.entry.as_ref().err()).map(|refused| &refused.mention);
        let leaving = if wanted.remove_missing { leaving(&lines, mentions(), known) } else { Vec::new() };
        Self { lines, leaving }
    }

    /// How many lines add, change, leave as it is, and are refused.
    #[must_use]
    pub fn counts(&self) -> [usize; 4] {
        let count = |which: fn(&RosterOutcome) -> bool| self.lines.iter().filter(|line| which(&line.outcome)).count();
        [
            count(|outcome| matches!(outcome, RosterOutcome::New)),
            count(|outcome| matches!(outcome, RosterOutcome::Changed { .. })),
            count(|outcome| outcome.changes_nothing()),
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
    by_email: BTreeMap<String, &'a SchoolPerson>,
    by_number: BTreeMap<String, &'a SchoolPerson>,
    unusable: &'a BTreeSet<String>,
}

impl<'a> Index<'a> {
    fn new(known: &'a [SchoolPerson], unusable: &'a BTreeSet<String>) -> Self {
        let numbered =
            known.iter().filter_map(|person| Some((look_alike_key(person.registrar_id.as_deref()?), person)));
        Self {
            by_email: known.iter().map(|person| (normalize_email(&person.email), person)).collect(),
            by_number: numbered.collect(),
            unusable,
        }
    }

    fn outcome(&self, entry: &RosterEntry) -> RosterOutcome {
        let by_number =
            entry.registrar_id.as_deref().and_then(|number| self.by_number.get(&look_alike_key(number))).copied();
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
    if entry.name != tidy(&person.name) {
        changes.push(RosterChange::Name(person.name.clone()));
    }
    if entry.email != normalize_email(&person.email) {
        changes.push(RosterChange::Email(person.email.clone()));
    }
    let number = |number: &Option<String>| number.as_deref().map(look_alike_key);
    if entry.registrar_id.is_some() && number(&entry.registrar_id) != number(&person.registrar_id) {
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

/// Whom the lines of a file name, right or wrong.
#[derive(Default)]
struct NamedPeople {
    emails: BTreeSet<String>,
    numbers: BTreeSet<String>,
    names: BTreeSet<String>,
    /// Of addresses that are wrong, what stands before the @.
    users: BTreeSet<String>,
}

impl NamedPeople {
    fn add_entry(&mut self, entry: &RosterEntry) {
        self.emails.insert(entry.email.clone());
        self.numbers.extend(entry.registrar_id.as_deref().map(look_alike_key));
    }

    /// A refused line may be wrong in whatever it says, so each thing that it says is enough.
    fn add_mention(&mut self, mention: &LineMention) {
        self.emails.insert(mention.email.clone());
        self.numbers.extend(mention.registrar_id.as_deref().map(look_alike_key));
        let user = mention.email.split('@').next().unwrap_or_default();
        self.users.extend(Some(user.to_owned()).filter(|user| !user.is_empty()));
        self.names.extend(Some(look_alike_key(&mention.name)).filter(|name| !name.is_empty()));
    }

    fn names(&self, person: &SchoolPerson) -> bool {
        let email = normalize_email(&person.email);
        let number = person.registrar_id.as_deref().map(look_alike_key);
        number.is_some_and(|number| self.numbers.contains(&number))
            || self.names.contains(&look_alike_key(&person.name))
            || email.split('@').next().is_some_and(|user| self.users.contains(user))
            || self.emails.contains(&email)
    }
}

/// Trainees in the cohorts that the roster fills whom no line names, not even a refused one.
fn leaving<'a>(
    lines: &[LineOutcome],
    mentions: impl Iterator<Item = &'a LineMention>,
    known: &[SchoolPerson],
) -> Vec<Leaving> {
    let mut named = NamedPeople::default();
    mentions.for_each(|mention| named.add_mention(mention));
    let mut filled: BTreeSet<String> = BTreeSet::new();
    for entry in lines.iter().filter_map(|line| line.entry.as_ref()) {
        named.add_entry(entry);
        filled.extend(entry.cohorts.iter().map(|cohort| look_alike_key(cohort)));
    }
    let missing = known.iter().filter(|person| person.role == Role::Trainee && !named.names(person));
    let leaves = missing.flat_map(|person| {
        let from = person.cohorts.iter().filter(|cohort| filled.contains(&look_alike_key(cohort)));
        from.map(|cohort| Leaving { person: person.id, name: person.name.clone(), cohort: cohort.clone() })
    });
    leaves.collect()
}
