//! Changes that a roster would make.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::{AccountStanding, LineMention, Refusal, RefusedLine, Roster, RosterEntry, RosterMapping};
use crate::Role;
use crate::ids::PersonId;
use crate::people::email::normalize_email;
use crate::search_key::look_alike_key;
use crate::single_line_text::tidy;

/// A person of the school.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SchoolPerson {
    /// Id.
    pub id: PersonId,
    /// Registration number.
    pub registrar_id: Option<String>,
    /// Email address, in lower case.
    pub email: String,
    /// Name.
    pub name: String,
    /// Role.
    pub role: Role,
    /// The account is enabled.
    pub enabled: bool,
    /// Names of the cohorts.
    pub cohorts: Vec<String>,
}

/// Options of an import.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RosterRequest {
    /// Cohort of people for whom the file names none.
    pub cohort: Option<String>,
    /// Remove trainees who are not in the file from the cohorts that it contains.
    pub remove_missing: bool,
    /// Meanings of the columns; `None` until they have been confirmed.
    #[serde(default)]
    pub mapping: Option<RosterMapping>,
    /// The roster lists the members of a course of a learning platform, not the lines of a file.
    #[serde(default)]
    pub is_course: bool,
}

/// A change to a person.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RosterChange {
    /// Another name; contains the previous one.
    Name(String),
    /// Another email address; contains the previous one.
    Email(String),
    /// Another registration number; contains the previous one.
    RegistrarId(Option<String>),
    /// Membership of another cohort.
    Joins(String),
    /// The account is enabled.
    Enabled,
    /// The account is disabled.
    Disabled,
    /// Launches of the learning platform find the person from now on.
    Identity,
}

/// Outcome of a line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RosterOutcome {
    /// A person is added.
    New,
    /// A person is changed.
    Changed {
        /// The person.
        person: PersonId,
        /// Changes.
        changes: Vec<RosterChange>,
    },
    /// Nothing changes.
    Unchanged,
    /// The line concerns the person of an earlier line, whose number is given, and was merged with
    /// it.
    Together(u64),
    /// The line is refused.
    Refused(Refusal),
}

/// A line and its outcome.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LineOutcome {
    /// Line number in the file, from 1.
    pub line: u64,
    /// Text that identifies the line.
    pub shown: String,
    /// The person described; `None` if the line could not be read.
    pub entry: Option<RosterEntry>,
    /// Outcome.
    pub outcome: RosterOutcome,
}

/// A person who is removed from a cohort because the file does not contain them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Leaving {
    /// The person.
    pub person: PersonId,
    /// Name of the person.
    pub name: String,
    /// Name of the cohort.
    pub cohort: String,
}

/// Changes that a roster would make.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RosterDifference {
    /// All lines.
    pub lines: Vec<LineOutcome>,
    /// People to be removed from cohorts.
    pub leaving: Vec<Leaving>,
}

impl RosterOutcome {
    /// Returns whether the line causes no change of its own.
    #[must_use]
    pub const fn changes_nothing(&self) -> bool {
        matches!(self, Self::Unchanged | Self::Together(_))
    }
}

impl RosterDifference {
    /// Compares a roster with the people of a school.
    #[must_use]
    pub fn of(roster: &Roster, known: &[SchoolPerson], wanted: &RosterRequest) -> Self {
        let index = Index::new(known);
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

    /// Returns the numbers of lines that add, change, leave unchanged, and are refused.
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

    /// Returns the number of people who would be added, changed or removed from a cohort.
    #[must_use]
    pub fn count_changes(&self) -> usize {
        let [new, changed, ..] = self.counts();
        new + changed + self.leaving.len()
    }

    /// Returns whether the roster would change nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count_changes() == 0
    }
}

/// Index of the people of a school.
struct Index<'a> {
    by_email: BTreeMap<String, &'a SchoolPerson>,
    by_number: BTreeMap<String, &'a SchoolPerson>,
}

impl<'a> Index<'a> {
    fn new(known: &'a [SchoolPerson]) -> Self {
        let numbered =
            known.iter().filter_map(|person| Some((look_alike_key(person.registrar_id.as_deref()?), person)));
        Self {
            by_email: known.iter().map(|person| (normalize_email(&person.email), person)).collect(),
            by_number: numbered.collect(),
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
            return RosterOutcome::New;
        };
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

/// People mentioned in the lines of a file, including refused lines.
#[derive(Default)]
struct NamedPeople {
    emails: BTreeSet<String>,
    numbers: BTreeSet<String>,
    names: BTreeSet<String>,
    /// Local parts of the email addresses in refused lines.
    users: BTreeSet<String>,
}

impl NamedPeople {
    fn add_entry(&mut self, entry: &RosterEntry) {
        self.emails.insert(entry.email.clone());
        self.numbers.extend(entry.registrar_id.as_deref().map(look_alike_key));
    }

    /// Any field of a refused line may be wrong, so that one matching field is sufficient.
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

/// Returns the trainees in the cohorts of the roster whom no line mentions, not even a refused one.
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
