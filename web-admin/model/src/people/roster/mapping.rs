//! Meanings of the columns of a roster: detected from headings and contents, or chosen by the user.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::columns::{is_canvas_gradebook, is_plural, meaning};
use super::{RosterColumn, RosterTable, role, standing};
use crate::search_key::look_alike_key;

/// Notation of several groups in one field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GroupSplit {
    /// A field contains one group.
    #[default]
    One,
    /// Groups are separated by commas.
    Comma,
    /// Groups are separated by semicolons.
    Semicolon,
    /// Groups are listed in a sentence: "A and B", "A, B, and C".
    Sentence,
}

/// Conjunctions before the last group of a sentence, in English and German.
const AND: [&str; 2] = [" and ", " und "];

impl GroupSplit {
    /// Returns the groups in a field, without repetitions.
    pub(super) fn groups(self, field: &str) -> Vec<String> {
        let names: Vec<&str> = match self {
            Self::One => vec![field],
            Self::Comma => field.split(',').collect(),
            Self::Semicolon => field.split(';').collect(),
            Self::Sentence => {
                let last = AND.iter().filter_map(|and| field.rsplit_once(and)).next();
                last.map_or(vec![field], |(rest, last)| rest.split(',').chain([last]).collect())
            }
        };
        let mut groups: Vec<String> = Vec::new();
        for name in names.into_iter().map(str::trim).filter(|name| !name.is_empty()) {
            if !groups.iter().any(|group| look_alike_key(group) == look_alike_key(name)) {
                groups.push(name.to_owned());
            }
        }
        groups
    }
}

/// Meanings of the columns, by their index from 0.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RosterMapping {
    /// Columns that are read.
    pub columns: BTreeMap<RosterColumn, usize>,
    /// Notation of several groups in one field.
    pub split: GroupSplit,
    /// Domain to be appended to addresses without one.
    pub domain: Option<String>,
}

/// Reason why the user has to choose the columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MappingDoubt {
    /// No column contains email addresses.
    NoEmail,
    /// No column contains names.
    NoName,
    /// Two columns may have the same meaning; contains their headings.
    Alike(String, String),
    /// The contents of this column do not match its heading.
    Unclear(String),
}

/// Detected meanings of the columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MappingGuess {
    /// The mapping.
    pub mapping: RosterMapping,
    /// Uncertainties; the mapping can be used without confirmation if this is empty.
    pub doubts: Vec<MappingDoubt>,
}

impl RosterMapping {
    /// Returns whether a column is read.
    #[must_use]
    pub fn reads(&self, index: usize) -> bool {
        self.columns.values().any(|read| *read == index)
    }

    /// Returns whether the mapping provides names.
    #[must_use]
    pub fn names(&self) -> bool {
        let has = |column| self.columns.contains_key(&column);
        has(RosterColumn::Name) || has(RosterColumn::Given) && has(RosterColumn::Family)
    }

    /// Returns whether the mapping provides email addresses.
    #[must_use]
    pub fn addresses(&self) -> bool {
        self.columns.contains_key(&RosterColumn::Email) || self.columns.contains_key(&RosterColumn::Login)
    }

    /// Returns whether the mapping can be used for a table with this number of columns: nothing
    /// required is missing, and no column has two meanings.
    #[must_use]
    pub fn fits(&self, columns: usize) -> bool {
        let mut places: Vec<usize> = self.columns.values().copied().collect();
        places.sort_unstable();
        let apart = places.windows(2).all(|pair| pair[0] != pair[1]);
        self.names() && self.addresses() && apart && places.last().is_none_or(|last| *last < columns)
    }
}

impl RosterTable {
    /// Detects the meanings of the columns, with uncertainties.
    #[must_use]
    pub fn guess(&self) -> MappingGuess {
        let (mut columns, mut doubts) = self.recognise();
        self.settle_status(&mut columns, &mut doubts);
        self.settle_names(&mut columns);
        let split = columns.get(&RosterColumn::Cohort).map_or(GroupSplit::One, |at| self.split_of(*at));
        let mapping = RosterMapping { columns, split, domain: None };
        if !mapping.names() {
            doubts.push(MappingDoubt::NoName);
        }
        let login = mapping.columns.get(&RosterColumn::Login);
        // The test student of a course has a login and no email address.
        let addresses = |at: &usize| {
            let (all, whole) = (self.column(*at).count(), self.column(*at).filter(|text| text.contains('@')).count());
            2 * whole > all
        };
        if !mapping.columns.contains_key(&RosterColumn::Email) && !login.is_some_and(addresses) {
            doubts.push(MappingDoubt::NoEmail);
        }
        MappingGuess { mapping, doubts }
    }

    /// Detects meanings from the headings. Of two columns with the same meaning, the more certain
    /// one that is not empty is used.
    fn recognise(&self) -> (BTreeMap<RosterColumn, usize>, Vec<MappingDoubt>) {
        let mut found: BTreeMap<RosterColumn, Vec<(bool, usize, usize)>> = BTreeMap::new();
        for (index, heading) in self.headings.iter().enumerate() {
            if let Some((column, rank)) = meaning(heading) {
                found.entry(column).or_default().push((self.sample_of(index).is_none(), rank, index));
            }
        }
        let (mut columns, mut doubts) = (BTreeMap::new(), Vec::new());
        for (column, mut places) in found {
            places.sort_unstable();
            let [(empty, rank, first), rest @ ..] = places.as_slice() else { continue };
            columns.insert(column, *first);
            if let Some((_, _, second)) = rest.iter().find(|(e, r, _)| (e, r) == (empty, rank)) {
                doubts.push(MappingDoubt::Alike(self.headings[*first].clone(), self.headings[*second].clone()));
            }
        }
        (columns, doubts)
    }

    /// In Stud.IP, a column "status" contains the role in a course.
    fn settle_status(&self, columns: &mut BTreeMap<RosterColumn, usize>, doubts: &mut Vec<MappingDoubt>) {
        let Some(&at) = columns.get(&RosterColumn::Status) else { return };
        let count = |known: fn(&str) -> bool| self.column(at).filter(|text| known(text)).count();
        let standings = count(|text| standing(text).is_some());
        let roles = count(|text| role(text).is_some());
        if standings > 0 || self.sample_of(at).is_none() {
            return;
        }
        columns.remove(&RosterColumn::Status);
        if roles == 0 {
            doubts.push(MappingDoubt::Unclear(self.headings[at].clone()));
        } else {
            columns.entry(RosterColumn::Role).or_insert(at);
        }
    }

    /// Next to a given name, the German heading "Name" means the family name, unless the column
    /// contains the given name.
    fn settle_names(&self, columns: &mut BTreeMap<RosterColumn, usize>) {
        let (Some(&given), Some(&name), None) =
            (columns.get(&RosterColumn::Given), columns.get(&RosterColumn::Name), columns.get(&RosterColumn::Family))
        else {
            return;
        };
        let whole = self.rows.iter().any(|(_, row)| {
            let (given, name) = (row.get(given).unwrap_or_default(), row.get(name).unwrap_or_default());
            !given.is_empty() && name.split([' ', ',']).any(|word| word == given)
        });
        if !whole {
            columns.remove(&RosterColumn::Name);
            columns.insert(RosterColumn::Family, name);
        }
    }

    fn split_of(&self, at: usize) -> GroupSplit {
        if self.column(at).any(|text| text.contains(';')) {
            GroupSplit::Semicolon
        } else if self.headings.get(at).is_some_and(|heading| is_plural(heading)) {
            GroupSplit::Comma
        } else if is_canvas_gradebook(&self.headings) {
            GroupSplit::Sentence
        } else {
            GroupSplit::One
        }
    }
}
