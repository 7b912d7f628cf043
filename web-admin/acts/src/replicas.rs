//! Several processes at work on one database: each says that it is alive, and what one had in hand that is not any more goes to the others.
//! What is to be done once for all is done by whoever holds that duty.

use std::collections::BTreeMap;
use std::time::Duration;

use model::ids::ReplicaId;
use store::replicas::{self, ReplicaBeats};
use store::tries::{self, SetAside};

use crate::error::{Error, tell_in_full};
use crate::service::Service;

/// How often a replica says that it is alive, and looks who else is.
const BEAT_EVERY: Duration = Duration::from_secs(5);
/// Looks in a row at which another has not been heard until it is dead: looks, not a time, so that whoever was held up themselves does
/// not take the others for dead.
const MOST_SILENT: u32 = 6;

/// Longest that a look may take: a database that has fallen silent is asked anew.
const LONGEST_LOOK: Duration = Duration::from_secs(20);

/// What one process does for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Duty {
    /// Sends letters.
    Letters,
    /// Queues reminders.
    Reminders,
    /// Queues letters with what is new.
    News,
    /// Looks whom to keep no longer.
    Retention,
    /// States by which hash the audit log ends.
    Statements,
    /// Goes on with attempts that were judged long ago.
    OldAttempts,
}

impl Duty {
    const fn name(self) -> &'static str {
        match self {
            Self::Letters => "letters",
            Self::Reminders => "reminders",
            Self::News => "news",
            Self::Retention => "retention",
            Self::Statements => "statements",
            Self::OldAttempts => "old attempts",
        }
    }
}

/// Whether it is this process that does something for all; it is where nobody has done it yet.
pub async fn is_on_duty(service: &Service, duty: Duty) -> Result<bool, Error> {
    if let Some(holder) = replicas::find_duty_holder(service.db.reader(), duty.name()).await? {
        return Ok(holder == service.replica);
    }
    let mut tx = service.db.write().await?;
    replicas::take_duty(&mut tx, duty.name(), service.replica).await?;
    let holder = replicas::find_duty_holder(&mut *tx, duty.name()).await?;
    tx.commit().await?;
    Ok(holder == Some(service.replica))
}

/// Does something for all, where that is for this process to do.
///
/// # Errors
/// As `act` does.
pub async fn do_duty(service: &Service, duty: Duty, act: impl Future<Output = Result<(), Error>>) -> Result<(), Error> {
    if is_on_duty(service, duty).await? { act.await } else { Ok(()) }
}

/// What a replica was last heard to say.
#[derive(Clone, Copy, Debug)]
struct HeardReplica {
    beats: i64,
    silent: u32,
}

/// Who else is at work, as far as one has heard.
#[derive(Debug, Default)]
pub struct Colleagues(BTreeMap<ReplicaId, HeardReplica>);

impl Colleagues {
    /// Hears everybody; those who have not been heard for so long that they are dead.
    fn hear(&mut self, found: &[ReplicaBeats]) -> Vec<ReplicaId> {
        let before = std::mem::take(&mut self.0);
        for ReplicaBeats { id, beats } in found.iter().copied() {
            let silent = before.get(&id).filter(|heard| heard.beats == beats).map_or(0, |heard| heard.silent + 1);
            self.0.insert(id, HeardReplica { beats, silent });
        }
        self.0.iter().filter(|(_, heard)| heard.silent >= MOST_SILENT).map(|(id, _)| *id).collect()
    }
}

/// Says now and then that this process is alive, and takes over from those that are not.
pub async fn run(service: Service) {
    let mut colleagues = Colleagues::default();
    loop {
        let heard = match tokio::time::timeout(LONGEST_LOOK, look_round(&service, &mut colleagues)).await {
            Ok(heard) => heard,
            Err(silent) => Err(Error::DatabaseAway(silent.into())),
        };
        if let Err(error) = heard {
            tracing::warn!(cause = tell_in_full(&error), "it could not be heard who else is at work");
            // Whoever was not heard themselves cannot say that the others were silent.
            colleagues = Colleagues::default();
        }
        tokio::time::sleep(BEAT_EVERY).await;
    }
}

/// Says that this process is alive, and buries those that have been silent for long.
pub async fn look_round(service: &Service, colleagues: &mut Colleagues) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    replicas::beat_replica(&mut tx, service.replica).await?;
    let found = replicas::list_replicas(&mut *tx).await?;
    tx.commit().await?;
    for silent in colleagues.hear(&found).into_iter().filter(|id| *id != service.replica) {
        bury(service, silent).await?;
    }
    Ok(())
}

/// Buries everybody else: nobody but this process can be at work on the database.
pub async fn bury_others(service: &Service) -> Result<(), Error> {
    for ReplicaBeats { id, .. } in replicas::list_replicas(service.db.reader()).await? {
        if id != service.replica {
            bury(service, id).await?;
        }
    }
    Ok(())
}

/// The file of a data folder that says who is at work in it.
const REPLICA_FILE: &str = "replica";

/// Buries whoever was at work in this data folder before, which cannot be alive now that the folder is held: nobody waits until
/// they have been silent for long.
///
/// # Errors
/// When the folder cannot be written to, or the database fails.
pub async fn succeed(service: &Service) -> Result<(), Error> {
    let file = service.config.data_dir.join(REPLICA_FILE);
    let before = tokio::fs::read_to_string(&file).await.unwrap_or_default();
    let at_work = replicas::list_replicas(service.db.reader()).await?;
    if let Some(dead) = at_work.into_iter().find(|replica| replica.id.to_string() == before.trim()) {
        bury(service, dead.id).await?;
    }
    Ok(tokio::fs::write(&file, service.replica.to_string()).await?)
}

/// Releases the work of a dead replica. Its unfinished reads count as crashes only if the replica read recordings in its own process; with a
/// helper, no recording can have ended the service.
async fn bury(service: &Service, dead: ReplicaId) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    match service.config.helper {
        Some(_) => tries::release_replica(&mut tx, dead).await?,
        None => tries::bury_replica(&mut tx, dead).await?,
    }
    tx.commit().await?;
    tracing::warn!(replica = %dead, "a service has ended without a word: what it had in hand is taken over");
    service.jobs.notify_one();
    service.mails.notify_one();
    tell_set_aside(service).await
}

/// Tells of what is tried no more, for it was fatal twice.
pub async fn tell_set_aside(service: &Service) -> Result<(), Error> {
    for SetAside { kind, id } in tries::list_set_aside(service.db.reader()).await? {
        tracing::error!(%id, "the service has died of this {kind} twice: it is set aside; web-admin retry tries it again");
    }
    Ok(())
}

/// Lets go, at the end, of everything in hand: what is cut off now was fatal to nobody.
pub async fn leave(service: &Service) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    tries::release_replica(&mut tx, service.replica).await?;
    Ok(tx.commit().await?)
}

#[cfg(test)]
mod tests {
    //! Whoever takes the living for dead does their work twice; whoever never does leaves the work of the dead undone.

    use super::*;

    fn heard(id: u128, beats: i64) -> ReplicaBeats {
        ReplicaBeats { id: ReplicaId::from_u128(id), beats }
    }

    #[test]
    fn who_is_silent_for_long_is_dead_and_who_says_anything_is_not() {
        let mut colleagues = Colleagues::default();
        for look in 0..=i64::from(MOST_SILENT) {
            let dead = colleagues.hear(&[heard(1, look), heard(2, 7)]);
            let expected: &[ReplicaId] = if look < i64::from(MOST_SILENT) { &[] } else { &[ReplicaId::from_u128(2)] };
            assert_eq!(dead, expected, "at look {look}");
        }
        assert_eq!(colleagues.hear(&[heard(2, 8)]), [], "it was only held up");
        assert_eq!(colleagues.hear(&[heard(2, 8)]), [], "and is given the whole time again");
    }

    #[test]
    fn who_has_been_away_counts_from_when_they_are_back() {
        let mut colleagues = Colleagues::default();
        for _ in 0..MOST_SILENT {
            colleagues.hear(&[heard(2, 7)]);
        }
        colleagues.hear(&[]);
        assert_eq!(colleagues.hear(&[heard(2, 7)]), []);
    }
}
