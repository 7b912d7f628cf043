//! From a configuration to a running service.

use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use acts::Service;
use acts::clock::Clock;
use acts::config::Config;
use acts::inspection::Inspection;
use model::Moment;
use tokio::sync::Mutex;

use crate::examining::examine_draft;
use crate::monitoring::{Counters, Pulse};
use crate::refusals::RefusalLog;

/// What every handler may use: what acts use, reached as if it lay here, and what only requests need.
#[derive(Clone, Debug)]
pub struct AppState {
    /// What acts use.
    pub service: Service,
    /// What somebody was refused that is not theirs, written down.
    pub refusals: Arc<RefusalLog>,
    /// What `/metrics` counts.
    pub counters: Arc<Counters>,
    /// What `/readyz` asks.
    pub pulse: Arc<Pulse>,
    /// Whether this service is about to stop, and wants no further requests.
    pub leaving: Arc<AtomicBool>,
    /// Held while a letter is on its way, and by whoever would have none on its way.
    pub letter_in_hand: Arc<Mutex<()>>,
    /// How far the look through the database is that began with the service.
    pub inspection: Arc<Inspection>,
}

impl AppState {
    /// Makes the folders, opens the database and brings its schema up to date.
    ///
    /// # Errors
    /// When a folder cannot be made, or the database cannot be opened or migrated.
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

    /// The same service at another time.
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
