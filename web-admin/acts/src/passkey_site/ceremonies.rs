//! What was asked of passkeys and not answered yet: kept here alone, in memory, each good once and for a while.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use model::Moment;
use model::ids::{CeremonyId, PersonId};
use webauthn_rs::prelude::{PasskeyAuthentication, PasskeyRegistration};

/// How long an answer is waited for, in s.
const WAIT_S: i64 = 5 * 60;
/// Most that are waited for of one person: a page in as many windows.
const MOST_OF_PERSON: usize = 8;
/// Most that are waited for in all, some 2 kB each.
const MOST: usize = 20_000;

/// What an answer is held to.
#[derive(Clone, Debug)]
pub enum PasskeyChallenge {
    /// A new passkey is to be made.
    ToMake {
        /// What it is to be called.
        name: String,
        /// What it is held to.
        state: Box<PasskeyRegistration>,
    },
    /// A known passkey is to sign.
    ToSign(Box<PasskeyAuthentication>),
}

#[derive(Clone, Debug)]
struct PendingCeremony {
    person_id: PersonId,
    until: Moment,
    asked: PasskeyChallenge,
}

/// Everything that is waited for.
#[derive(Debug, Default)]
pub struct Ceremonies(Mutex<BTreeMap<CeremonyId, PendingCeremony>>);

impl Ceremonies {
    /// Waits for somebody's answer; the id by which it is taken. In place of their oldest where there are too many.
    #[must_use]
    pub fn begin(&self, person_id: PersonId, asked: PasskeyChallenge, now: Moment) -> CeremonyId {
        let mut waiting = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.retain(|_, one| one.until > now);
        let own = waiting.values().filter(|one| one.person_id == person_id).count();
        if own >= MOST_OF_PERSON {
            forget_oldest(&mut waiting, |one| one.person_id == person_id);
        } else if waiting.len() >= MOST {
            forget_oldest(&mut waiting, |_| true);
        }
        let id = CeremonyId::random();
        waiting.insert(id, PendingCeremony { person_id, until: now.plus_s(WAIT_S), asked });
        id
    }

    /// What somebody was asked by an id, this once. None where it is too late, it was answered, or somebody else was asked.
    #[must_use]
    pub fn take(&self, id: CeremonyId, person_id: PersonId, now: Moment) -> Option<PasskeyChallenge> {
        let mut waiting = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let taken = waiting.remove(&id)?;
        (taken.person_id == person_id && taken.until > now).then_some(taken.asked)
    }
}

fn forget_oldest(waiting: &mut BTreeMap<CeremonyId, PendingCeremony>, whose: impl Fn(&PendingCeremony) -> bool) {
    let oldest = waiting.iter().filter(|(_, one)| whose(one)).min_by_key(|(_, one)| one.until).map(|(id, _)| *id);
    if let Some(id) = oldest {
        waiting.remove(&id);
    }
}

#[cfg(test)]
mod tests {
    //! An answer that is good twice, late, or for somebody else is one that can be stolen.

    use super::super::tests::asked_to_make;
    use super::*;

    fn begin(all: &Ceremonies, person: PersonId, at_s: i64) -> CeremonyId {
        all.begin(person, asked_to_make(), Moment::from_micros(0).plus_s(at_s))
    }

    fn take(all: &Ceremonies, id: CeremonyId, person: PersonId, at_s: i64) -> bool {
        all.take(id, person, Moment::from_micros(0).plus_s(at_s)).is_some()
    }

    #[test]
    fn each_is_good_once_for_a_while_and_for_whom_it_was_made() {
        let (all, ada, ben) = (Ceremonies::default(), PersonId::from_u128(1), PersonId::from_u128(2));
        let id = begin(&all, ada, 0);
        assert!(take(&all, id, ada, WAIT_S - 1), "in time");
        assert!(!take(&all, id, ada, WAIT_S - 1), "once");
        let id = begin(&all, ada, 0);
        assert!(!take(&all, id, ada, WAIT_S), "too late");
        let id = begin(&all, ada, 0);
        assert!(!take(&all, id, ben, 1), "somebody else's");
        assert!(!take(&all, id, ada, 1), "whoever tried has used it up");
    }

    #[test]
    fn one_person_takes_no_room_from_others() {
        let (all, ada, ben) = (Ceremonies::default(), PersonId::from_u128(1), PersonId::from_u128(2));
        let of_ben = begin(&all, ben, 0);
        let of_ada: Vec<CeremonyId> = (1..=12).map(|at_s| begin(&all, ada, at_s)).collect();
        let kept = of_ada.iter().filter(|id| take(&all, **id, ada, 20)).count();
        assert_eq!(kept, MOST_OF_PERSON);
        assert!(!take(&all, of_ada[0], ada, 20), "the oldest went first");
        assert!(take(&all, of_ben, ben, 20));
    }
}
