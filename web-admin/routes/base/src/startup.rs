//! The state of a running service.

use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use acts::Service;
use acts::operations::inspection::Inspection;
use model::Moment;
use platform::clock::Clock;
use platform::config::Config;
use tokio::sync::Mutex;

use crate::examining::examine_draft;
use crate::operations::monitoring::{Counters, Pulse};
use crate::refusals::RefusalLog;

/// State shared by all handlers: the state of `acts`, reachable by `Deref`, and the parts that only
/// requests need.
#[derive(Clone, Debug)]
pub struct AppState {
    /// State of `acts`.
    pub service: Service,
    /// Log of refused requests.
    pub refusals: Arc<RefusalLog>,
    /// Counters of `/metrics`.
    pub counters: Arc<Counters>,
    /// Database probe of `/readyz`.
    pub pulse: Arc<Pulse>,
    /// Whether this service is about to stop and should receive no further requests.
    pub leaving: Arc<AtomicBool>,
    /// Locked while a mail is being sent, and by a shutdown that waits for it.
    pub letter_in_hand: Arc<Mutex<()>>,
    /// Progress of the database check that started with the service.
    pub inspection: Arc<Inspection>,
}

impl AppState {
    /// Creates the folders, opens the database and migrates its schema.
    ///
    /// # Errors
    /// When a folder cannot be created, or the database cannot be opened or migrated.
    pub async fn open(config: Config, clock: Clock) -> anyhow::Result<Self> {
        Ok(Self {
            service: Service { examine_draft, ..Service::open(config, clock).await? },
            refusals: Arc::default(),
            counters: Arc::default(),
            pulse: Arc::default(),
            leaving: Arc::default(),
            letter_in_hand: Arc::default(),
            inspection: Arc::default(),
        })
    }

    /// Returns the same service with its clock fixed at another time.
    #[must_use]
    pub fn at(&self, now: Moment) -> Self {
        Self { service: Service { clock: Clock::fixed(now), ..self.service.clone() }, ..self.clone() }
    }
}

impl Deref for AppState {
    type Target = Service;

    fn deref(&self) -> &Service {
        &self.service
    }
}
