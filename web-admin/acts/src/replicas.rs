//! Replicas on one database: each sends heartbeats, and the leases of a dead replica are released
//! so that the others take over. Each periodic duty is done by the one replica that holds it.

use std::collections::BTreeMap;
use std::time::Duration;

use model::ids::ReplicaId;
use store::recordings::parse_attempts;
use store::recordings::parse_attempts::QuarantinedItem;
use store::replicas::{self, ReplicaBeats};

use crate::error::{Error, error_chain};
use crate::service::Service;

/// Interval of heartbeats and of checks for the heartbeats of others.
const BEAT_EVERY: Duration = Duration::from_secs(5);
/// Number of consecutive checks without a heartbeat after which a replica is considered dead.
/// Checks are counted instead of time, so that a replica that was itself suspended does not declare
/// the others dead.
const MOST_SILENT: u32 = 6;

/// Time limit of a check, after which an unresponsive database connection is given up.
const LONGEST_LOOK: Duration = Duration::from_secs(20);

/// A periodic task done by one replica for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Duty {
    /// Sends mails.
    Letters,
    /// Queues reminders of deadlines.
    Reminders,
    /// Queues mails about unread notices.
    News,
    /// Applies the retention policy.
    Retention,
    /// Publishes audit checkpoints.
    Statements,
    /// Continues re-gradings and backfills of old attempts.
    OldAttempts,
    /// Revokes badges that are no longer earned.
    Badges,
    /// Sends statements to learning record stores.
    LearningRecords,
    /// Sends grades to learning platforms.
    Grades,
    /// Compares courses of learning platforms with their cohorts.
    Courses,
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
            Self::Badges => "badges",
            Self::LearningRecords => "learning records",
            Self::Grades => "grades",
            Self::Courses => "courses",
        }
    }
}

/// Returns whether this replica holds a duty; takes it if it is free.
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

/// Runs `act` if this replica holds the duty, and does nothing otherwise.
///
/// # Errors
/// As `act`.
pub async fn do_duty(service: &Service, duty: Duty, act: impl Future<Output = Result<(), Error>>) -> Result<(), Error> {
    if is_on_duty(service, duty).await? { act.await } else { Ok(()) }
}

/// Last heartbeat received from a replica.
#[derive(Clone, Copy, Debug)]
struct HeardReplica {
    beats: i64,
    silent: u32,
}

/// The other replicas and their last heartbeats.
#[derive(Debug, Default)]
pub struct Colleagues(BTreeMap<ReplicaId, HeardReplica>);

impl Colleagues {
    /// Records the current heartbeats. Returns the replicas that have missed [`MOST_SILENT`] of
    /// them.
    fn hear(&mut self, found: &[ReplicaBeats]) -> Vec<ReplicaId> {
        let before = std::mem::take(&mut self.0);
        for ReplicaBeats { id, beats } in found.iter().copied() {
            let silent = before.get(&id).filter(|heard| heard.beats == beats).map_or(0, |heard| heard.silent + 1);
            self.0.insert(id, HeardReplica { beats, silent });
        }
        self.0.iter().filter(|(_, heard)| heard.silent >= MOST_SILENT).map(|(id, _)| *id).collect()
    }
}

/// Sends heartbeats and takes over from dead replicas, periodically until the future is dropped.
pub async fn run(service: Service) {
    let mut colleagues = Colleagues::default();
    loop {
        let heard = match tokio::time::timeout(LONGEST_LOOK, look_round(&service, &mut colleagues)).await {
            Ok(heard) => heard,
            Err(silent) => Err(Error::DatabaseUnavailable(silent.into())),
        };
        if let Err(error) = heard {
            tracing::warn!(cause = error_chain(&error), "failed to read the heartbeats of the other replicas");
            // A replica that could not reach the database cannot conclude that the others missed
            // heartbeats.
            colleagues = Colleagues::default();
        }
        tokio::time::sleep(BEAT_EVERY).await;
    }
}

/// Sends a heartbeat, and marks the replicas dead that have missed too many.
pub async fn look_round(service: &Service, colleagues: &mut Colleagues) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    replicas::beat_replica(&mut tx, service.replica).await?;
    let found = replicas::list_replicas(&mut *tx).await?;
    tx.commit().await?;
    for silent in colleagues.hear(&found).into_iter().filter(|id| *id != service.replica) {
        mark_dead(service, silent).await?;
    }
    Ok(())
}

/// Marks all other replicas dead. The caller must hold the database exclusively.
pub async fn mark_others_dead(service: &Service) -> Result<(), Error> {
    for ReplicaBeats { id, .. } in replicas::list_replicas(service.db.reader()).await? {
        if id != service.replica {
            mark_dead(service, id).await?;
        }
    }
    Ok(())
}

/// File in the data folder with the id of the replica that uses it.
const REPLICA_FILE: &str = "replica";

/// Marks the previous replica in this data folder dead. It cannot be running, since this process
/// holds the folder's lock, so there is no need to wait for missed heartbeats.
///
/// # Errors
/// Fails if the folder is not writable, or the database fails.
pub async fn succeed(service: &Service) -> Result<(), Error> {
    let file = service.config.data_dir.join(REPLICA_FILE);
    let before = tokio::fs::read_to_string(&file).await.unwrap_or_default();
    let at_work = replicas::list_replicas(service.db.reader()).await?;
    if let Some(dead) = at_work.into_iter().find(|replica| replica.id.to_string() == before.trim()) {
        mark_dead(service, dead.id).await?;
    }
    Ok(tokio::fs::write(&file, service.replica.to_string()).await?)
}

/// Releases the leases of a dead replica. Its unfinished reads count as crashes only if it read
/// recordings in its own process; with a helper, no recording can have crashed the service.
async fn mark_dead(service: &Service, dead: ReplicaId) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    match service.config.helper {
        Some(_) => parse_attempts::release_replica(&mut tx, dead).await?,
        None => parse_attempts::bury_replica(&mut tx, dead).await?,
    }
    tx.commit().await?;
    tracing::warn!(replica = %dead, "missed heartbeats of a replica; taking over its leases");
    service.jobs.notify_one();
    service.mails.notify_one();
    tell_set_aside(service).await
}

/// Logs everything that is quarantined after two crashes.
pub async fn tell_set_aside(service: &Service) -> Result<(), Error> {
    for QuarantinedItem { kind, id } in parse_attempts::list_quarantined(service.db.reader()).await? {
        tracing::error!(%id, "{kind} quarantined after two crashes; web-admin retry releases it");
    }
    Ok(())
}

/// Releases all leases at shutdown; interrupted work does not count as a crash.
pub async fn leave(service: &Service) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    parse_attempts::release_replica(&mut tx, service.replica).await?;
    Ok(tx.commit().await?)
}

#[cfg(test)]
mod tests {
    //! Declaring a live replica dead would do its work twice; missing a dead one would leave its
    //! work undone.

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
