//! What every act may use.

use std::fs::DirBuilder;
use std::os::unix::fs::DirBuilderExt;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use anyhow::Context;
use model::ids::ReplicaId;
use store::{Database, MigrateError};
use tokio::sync::{Notify, OwnedSemaphorePermit, Semaphore};

use crate::brake_notes::BrakeNotes;
use crate::clock::Clock;
use crate::config::Config;
use crate::error::Error;
use crate::judging::{DraftExaminer, leave_unexamined};
use crate::lines::Lines;
use crate::mailer::Mailer;
use crate::previews::Previews;
use crate::recording_store::RecordingStore;
use crate::relying_party::RelyingParty;
use crate::turns::Turns;

/// Longest wait in the queue for password hashing.
const LONGEST_WAIT: Duration = Duration::from_secs(2);

/// What every act may use.
#[derive(Clone, Debug)]
pub struct Service {
    /// The database.
    pub db: Database,
    /// Who this process is among those that work on the database.
    pub replica: ReplicaId,
    /// The clock.
    pub clock: Clock,
    /// How the service runs.
    pub config: Arc<Config>,
    /// Where recordings lie.
    pub recordings: RecordingStore,
    /// Recordings of somebody erased may be left where recordings lie.
    pub erased_left: Arc<AtomicBool>,
    /// Rung when a recording has been queued.
    pub jobs: Arc<Notify>,
    /// Where mail goes out.
    pub mailer: Mailer,
    /// Rung when a mail has been queued.
    pub mails: Arc<Notify>,
    /// How often it is noted that an address is held up.
    pub brake_notes: Arc<BrakeNotes>,
    /// The relying party for passkeys, where browsers have them for this service.
    pub relying_party: Option<Arc<RelyingParty>>,
    /// Uploads in pieces that somebody is writing to.
    pub turns: Turns,
    /// What drafts come to, and the lines before those who compute it.
    pub previews: Arc<Previews>,
    /// The lines before helpers that read what arrives and make replays.
    pub helpers: Arc<Lines>,
    /// The lines before files of all attempts of a school: a million of them keep a core busy for half a minute.
    pub exports: Arc<Lines>,
    /// How many recordings may be held in memory at once: one of ten minutes takes 150 MB.
    pub parsing: Arc<Semaphore>,
    /// How many passwords may be hashed at once: each takes 19 MiB and a core.
    pub hashing: Arc<Semaphore>,
    /// How many passwords may be hashed at once for sign-ins from new addresses.
    pub hashing_strangers: Arc<Semaphore>,
    /// Looks at a draft where no helper does; whoever has no pages to draw it leaves it.
    pub examine_draft: DraftExaminer,
}

impl Service {
    /// Makes the folders, opens the database and brings its schema up to date.
    ///
    /// # Errors
    /// When a folder cannot be made, or the database cannot be opened or migrated.
    pub async fn open(config: Config, clock: Clock) -> anyhow::Result<Self> {
        words::check()?;
        for folder in [&config.data_dir, &config.recordings_dir, &config.uploads_dir(), &config.replays_dir()] {
            DirBuilder::new()
                .recursive(true)
                .mode(0o700)
                .create(folder)
                .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        }
        let db = Database::open(&config.database).await.context("cannot open the database")?;
        db.migrate().await.map_err(tell_newer).context("cannot bring the database up to date")?;
        let (mailer, recordings) = (Mailer::new(&config)?, RecordingStore::open(&config)?);
        Ok(Self {
            db,
            replica: ReplicaId::random(),
            clock,
            relying_party: RelyingParty::of(&config).map(Arc::new),
            recordings,
            erased_left: Arc::default(),
            config: Arc::new(config),
            jobs: Arc::default(),
            mailer,
            mails: Arc::default(),
            brake_notes: Arc::default(),
            turns: Turns::default(),
            previews: Arc::default(),
            // One school has two of them at most: another finds the third.
            helpers: Arc::new(Lines::new(3, 2)),
            exports: Arc::new(Lines::new(4, 1)),
            parsing: Arc::new(Semaphore::new(2)),
            hashing: Arc::new(Semaphore::new(2)),
            hashing_strangers: Arc::new(Semaphore::new(1)),
            examine_draft: leave_unexamined,
        })
    }

    /// Hashes where blocking is allowed, when those before are done.
    ///
    /// # Errors
    /// [`Error::Crowded`] when too many are before it, or the work could not be run.
    pub async fn hash<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Error> {
        soon(&self.hashing, work).await
    }

    /// Hashes for a sign-in from a new address, in a queue of its own, so that a flood of strangers delays no known user.
    ///
    /// # Errors
    /// As [`Service::hash`].
    pub async fn hash_for_stranger<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Error> {
        soon(&self.hashing_strangers, work).await
    }

    /// Holds a recording in memory where blocking is allowed, when there is room for it.
    ///
    /// # Errors
    /// When the work could not be run.
    pub async fn parse<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Error> {
        in_turn(&self.parsing, work).await
    }
}

/// Says in words that another program has brought the database further than this one knows.
fn tell_newer(error: MigrateError) -> anyhow::Error {
    match error {
        MigrateError::VersionMissing(step) => anyhow::anyhow!(
            "the database is newer than this program, {}: it has had step {step}, which this one does not know; start the newer program",
            env!("CARGO_PKG_VERSION")
        ),
        error => error.into(),
    }
}

/// Runs blocking work once a place is free; the wait is bounded.
async fn soon<T: Send + 'static>(
    places: &Arc<Semaphore>,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Error> {
    // Only the wait is bounded, not the hashing.
    let place = tokio::time::timeout(LONGEST_WAIT, Arc::clone(places).acquire_owned()).await;
    let place = place.map_err(|_| Error::Crowded { retry_after_s: LONGEST_WAIT.as_secs() })?;
    block(place.map_err(anyhow::Error::from)?, work).await
}

/// Works where blocking is allowed, when there is a place for it.
async fn in_turn<T: Send + 'static>(
    places: &Arc<Semaphore>,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Error> {
    block(Arc::clone(places).acquire_owned().await.map_err(anyhow::Error::from)?, work).await
}

async fn block<T: Send + 'static>(
    place: OwnedSemaphorePermit,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Error> {
    let work = tokio::task::spawn_blocking(move || {
        let _place = place;
        work()
    });
    Ok(work.await?)
}
