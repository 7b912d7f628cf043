//! Several lines about one person: merged if they agree, since some lists have one line per
//! membership, and otherwise refused.

use std::collections::BTreeMap;

use super::{Refusal, RefusedLine, RosterEntry, RosterRow};
use crate::search_key::look_alike_key;

/// Merges the cohorts of a later line into the earlier line about the same person, and refuses
/// lines whose email address or registration number belongs to another person's line.
pub(super) fn join_or_refuse(rows: &mut [RosterRow]) {
    let mut by_email: BTreeMap<String, usize> = BTreeMap::new();
    let mut by_number: BTreeMap<String, usize> = BTreeMap::new();
    for at in 0..rows.len() {
        let Ok(entry) = rows[at].entry.clone() else { continue };
        let number = entry.registrar_id.as_deref().map(look_alike_key);
        let same_email = by_email.get(&entry.email).copied();
        let same_number = number.as_ref().and_then(|number| by_number.get(number)).copied();
        let refusal = match (same_email, same_number) {
            (None, None) => {
                by_email.insert(entry.email, at);
                by_number.extend(number.map(|number| (number, at)));
                continue;
            }
            (Some(first), second) if second.is_none_or(|second| second == first) => {
                let line = rows[first].line;
                match rows[first].entry.as_mut() {
                    Ok(earlier) if agree(earlier, &entry) => {
                        take_over(earlier, &entry);
                        by_number.extend(number.map(|number| (number, first)));
                        Refusal::SamePerson(line)
                    }
                    _ => Refusal::SameEmail(line),
                }
            }
            (Some(first), _) => Refusal::SameEmail(rows[first].line),
            (None, Some(first)) => Refusal::SameRegistrarId(rows[first].line),
        };
        rows[at].entry = Err(Box::new(RefusedLine::of_entry(&entry, refusal)));
    }
}

/// Returns whether two lines about a person are compatible, apart from cohorts and missing values.
fn agree(one: &RosterEntry, other: &RosterEntry) -> bool {
    let number = |entry: &RosterEntry| entry.registrar_id.as_deref().map(look_alike_key);
    look_alike_key(&one.name) == look_alike_key(&other.name)
        && compatible(&number(one), &number(other))
        && compatible(&one.role, &other.role)
        && compatible(&one.standing, &other.standing)
}

fn compatible<T: PartialEq>(one: &Option<T>, other: &Option<T>) -> bool {
    one.is_none() || other.is_none() || one == other
}

fn take_over(earlier: &mut RosterEntry, later: &RosterEntry) {
    for cohort in &later.cohorts {
        if !earlier.cohorts.contains(cohort) {
            earlier.cohorts.push(cohort.clone());
        }
    }
    earlier.registrar_id = earlier.registrar_id.take().or_else(|| later.registrar_id.clone());
    earlier.role = earlier.role.or(later.role);
    earlier.standing = earlier.standing.or(later.standing);
}
