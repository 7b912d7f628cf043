//! Pending WebAuthn challenges: each is valid once, and for a limited time.

use model::ids::{CeremonyId, PersonId};
use platform::relying_party::{AssertionRequest, Challenge};
use serde::{Deserialize, Serialize};
use store::Json;
use store::auth::webauthn_challenges;
use store::auth::webauthn_challenges::PendingCeremony;

use crate::error::Error;
use crate::service::Service;

/// Lifetime of a challenge, in s.
const WAIT_S: i64 = 5 * 60;
/// Maximum number of pending challenges per person, for example in several windows.
const MOST_OF_PERSON: i64 = 8;

/// A pending request to a passkey.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum PasskeyChallenge {
    /// Registration of a new passkey.
    ToMake {
        /// Its name.
        name: String,
        /// The challenge that the response must repeat.
        challenge: Challenge,
    },
    /// A signature by a registered passkey.
    ToSign(AssertionRequest),
}

/// Stores a challenge and returns its id. If the person has too many, their oldest one is dropped.
///
/// # Errors
/// Fails if the database fails.
pub async fn begin(service: &Service, person_id: PersonId, asked: PasskeyChallenge) -> Result<CeremonyId, Error> {
    let id = CeremonyId::random();
    let until = service.clock.now().plus_s(WAIT_S);
    let mut tx = service.db.write().await?;
    webauthn_challenges::add_ceremony(
        &mut tx,
        id,
        &PendingCeremony { person_id, until, asked: Json(asked) },
        MOST_OF_PERSON,
    )
    .await?;
    tx.commit().await?;
    Ok(id)
}

/// Takes a person's challenge by its id. Returns `None` if it is unknown, used or expired, or
/// belongs to another person; each call consumes it.
///
/// # Errors
/// Fails if the database fails.
pub async fn take(service: &Service, id: CeremonyId, person_id: PersonId) -> Result<Option<PasskeyChallenge>, Error> {
    let mut tx = service.db.write().await?;
    let taken = webauthn_challenges::take_ceremony::<PasskeyChallenge>(&mut tx, id).await?;
    tx.commit().await?;
    let is_theirs = |taken: &PendingCeremony<_>| taken.person_id == person_id && taken.until > service.clock.now();
    Ok(taken.filter(is_theirs).map(|taken| taken.asked.0))
}

#[cfg(test)]
mod tests {
    //! A challenge must not be accepted twice, too late, or from another person.

    use std::path::Path;

    use model::{Moment, Role};
    use platform::clock::Clock;
    use platform::config::Config;
    use store::operations::schools;
    use store::people;
    use store::people::NewPerson;

    use super::*;

    fn asked_to_make() -> PasskeyChallenge {
        PasskeyChallenge::ToMake { name: "Key".to_owned(), challenge: Challenge::random().unwrap() }
    }

    async fn service(folder: &Path) -> (Service, [PersonId; 2]) {
        let clock = Clock::fixed(Moment::from_micros(1_700_000_000_000_000));
        let service = Service::open(Config::in_folder(folder), clock).await.unwrap();
        let mut tx = service.db.write().await.unwrap();
        let now = service.clock.now();
        let school_id = schools::find_or_create(&mut tx, "North", now).await.unwrap().id;
        let mut added = Vec::new();
        for name in ["Ada", "Ben"] {
            let email = format!("{name}@example.org");
            let new =
                NewPerson { school_id, role: Role::Trainee, display_name: name, email: &email, password_hash: "" };
            added.push(people::add_person(&mut tx, &new, now).await.unwrap().id);
        }
        tx.commit().await.unwrap();
        (service, [added[0], added[1]])
    }

    #[tokio::test]
    async fn each_is_good_once_for_a_while_and_for_whom_it_was_made() {
        let folder = tempfile::tempdir().unwrap();
        let (service, [ada, ben]) = service(folder.path()).await;
        let begin = async || begin(&service, ada, asked_to_make()).await.unwrap();
        let take = async |id, person| take(&service, id, person).await.unwrap().is_some();
        let id = begin().await;
        service.clock.advance(WAIT_S - 1);
        assert!(take(id, ada).await, "in time");
        assert!(!take(id, ada).await, "once");
        let id = begin().await;
        service.clock.advance(WAIT_S);
        assert!(!take(id, ada).await, "too late");
        let id = begin().await;
        assert!(!take(id, ben).await, "somebody else's");
        assert!(!take(id, ada).await, "whoever tried has used it up");
    }

    #[tokio::test]
    async fn one_person_takes_no_room_from_others() {
        let folder = tempfile::tempdir().unwrap();
        let (service, [ada, ben]) = service(folder.path()).await;
        let of_ben = begin(&service, ben, asked_to_make()).await.unwrap();
        let mut of_ada = Vec::new();
        for _ in 0..12 {
            service.clock.advance(1);
            of_ada.push(begin(&service, ada, asked_to_make()).await.unwrap());
        }
        let mut kept = Vec::new();
        for id in &of_ada {
            kept.push(take(&service, *id, ada).await.unwrap().is_some());
        }
        assert_eq!(kept, [[false; 4].as_slice(), &[true; 8]].concat(), "the oldest went first");
        assert!(take(&service, of_ben, ben).await.unwrap().is_some());
    }
}
