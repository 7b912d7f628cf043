//! Shared state of all operations.

use std::fs::DirBuilder;
use std::num::NonZeroU32;
use std::os::unix::fs::DirBuilderExt;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use anyhow::Context;
use model::ids::ReplicaId;
use platform::bounded_queue::BoundedQueue;
use platform::clock::Clock;
use platform::config::Config;
use platform::mailer::Mailer;
use platform::openid::AccessTokens;
use platform::outgoing::OutgoingClient;
use platform::rate_limit_log::RateLimitLog;
use platform::recording_store::RecordingStore;
use platform::relying_party::RelyingParty;
use platform::request_pace::RequestPace;
use platform::upload_locks::UploadLocks;
use store::{Database, MigrateError};
use tokio::sync::{Notify, OwnedSemaphorePermit, Semaphore};

use crate::error::Error;
use crate::sandbox_jobs::previews::Previews;
use crate::sandbox_jobs::{DraftExaminer, leave_unexamined};

/// Maximum time in the queue for password hashing.
const LONGEST_WAIT: Duration = Duration::from_secs(2);

/// Maximum number of requests of a directory per second.
const MOST_PROVISIONED: NonZeroU32 = NonZeroU32::new(50).expect("not zero");

/// Shared state of all operations.
#[derive(Clone, Debug)]
pub struct Service {
    /// Database.
    pub db: Database,
    /// Id of this process among the replicas on the database.
    pub replica: ReplicaId,
    /// Clock.
    pub clock: Clock,
    /// Configuration.
    pub config: Arc<Config>,
    /// Recording store.
    pub recordings: RecordingStore,
    /// Whether recordings of erased people may remain in the store and must be deleted later.
    pub erased_left: Arc<AtomicBool>,
    /// Notified when a recording has been queued.
    pub jobs: Arc<Notify>,
    /// Mailer.
    pub mailer: Mailer,
    /// Notified when a mail has been queued.
    pub mails: Arc<Notify>,
    /// Throttle for log lines about rate-limited addresses.
    pub rate_limit_log: Arc<RateLimitLog>,
    /// Relying party for passkeys, if browsers support them for this service's origin.
    pub relying_party: Option<Arc<RelyingParty>>,
    /// Client for requests to providers.
    pub outgoing: OutgoingClient,
    /// Access tokens of learning platforms.
    pub access_tokens: Arc<AccessTokens>,
    /// Limit on the requests of each directory.
    pub provisioning_pace: Arc<RequestPace>,
    /// Write locks on resumable uploads.
    pub turns: UploadLocks,
    /// Queues and cache for previews of drafts.
    pub previews: Arc<Previews>,
    /// Limit on concurrent helpers that read uploads and build replays.
    pub helpers: Arc<BoundedQueue>,
    /// Limit on concurrent exports of all attempts of a school: a million attempts occupy a core
    /// for half a minute.
    pub exports: Arc<BoundedQueue>,
    /// Limit on recordings in memory: one of ten minutes takes 150 MB.
    pub parsing: Arc<Semaphore>,
    /// Limit on concurrent password hashing: each takes 19 MiB and a core.
    pub hashing: Arc<Semaphore>,
    /// The same limit for sign-ins from new addresses.
    pub hashing_strangers: Arc<Semaphore>,
    /// Examines a draft in-process if there is no helper. Programs that render no pages use
    /// [`leave_unexamined`].
    pub examine_draft: DraftExaminer,
}

impl Service {
    /// Creates the folders, opens the database and migrates its schema.
    ///
    /// # Errors
    /// Fails if a folder cannot be created, or the database cannot be opened or migrated.
    pub async fn open(config: Config, clock: Clock) -> anyhow::Result<Self> {
        words::check()?;
        for folder in [&config.data_dir, &config.recordings_dir, &config.uploads_dir(), &config.replays_dir()] {
            DirBuilder::new()
                .recursive(true)
                .mode(0o700)
                .create(folder)
                .with_context(|| format!("cannot create the folder {}", folder.display()))?;
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
            outgoing: OutgoingClient::new(config.outgoing.clone()),
            access_tokens: Arc::default(),
            provisioning_pace: Arc::new(RequestPace::per_second(MOST_PROVISIONED)),
            erased_left: Arc::default(),
            config: Arc::new(config),
            jobs: Arc::default(),
            mailer,
            mails: Arc::default(),
            rate_limit_log: Arc::default(),
            turns: UploadLocks::default(),
            previews: Arc::default(),
            // One school gets at most two of the three, so that another always finds one.
            helpers: Arc::new(BoundedQueue::new(3, 2)),
            exports: Arc::new(BoundedQueue::new(4, 1)),
            parsing: Arc::new(Semaphore::new(2)),
            hashing: Arc::new(Semaphore::new(2)),
            hashing_strangers: Arc::new(Semaphore::new(1)),
            examine_draft: leave_unexamined,
        })
    }

    /// Hashes on the blocking thread pool, after earlier requests.
    ///
    /// # Errors
    /// Returns [`Error::Crowded`] if the queue is too long; fails if the task cannot run.
    pub async fn hash<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Error> {
        soon(&self.hashing, work).await
    }

    /// Hashes for a sign-in from a new address. It has its own queue, so that a flood of unknown
    /// addresses does not delay known users.
    ///
    /// # Errors
    /// As [`Service::hash`].
    pub async fn hash_for_stranger<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Error> {
        soon(&self.hashing_strangers, work).await
    }

    /// Runs work that holds a recording in memory on the blocking thread pool, within the limit on
    /// such work.
    ///
    /// # Errors
    /// Fails if the task cannot run.
    pub async fn parse<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Error> {
        in_turn(&self.parsing, work).await
    }
}

/// Translates the error of a database that was migrated by a newer version of this program.
fn tell_newer(error: MigrateError) -> anyhow::Error {
    match error {
        MigrateError::VersionMissing(step) => anyhow::anyhow!(
            "the database is newer than this program, {}: migration {step} is unknown to it; start the newer program",
            env!("CARGO_PKG_VERSION")
        ),
        error => error.into(),
    }
}

/// Runs blocking work once there is a permit; the wait is bounded.
async fn soon<T: Send + 'static>(
    places: &Arc<Semaphore>,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Error> {
    // Only the wait is bounded, not the hashing.
    let place = tokio::time::timeout(LONGEST_WAIT, Arc::clone(places).acquire_owned()).await;
    let place = place.map_err(|_| Error::Crowded { retry_after_s: LONGEST_WAIT.as_secs() })?;
    block(place.map_err(anyhow::Error::from)?, work).await
}

/// Runs blocking work once there is a permit; the wait is unbounded.
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
