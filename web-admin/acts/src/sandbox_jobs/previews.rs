//! Previews of exercise drafts: examined in the helper within limits, cancelled when the client
//! goes away, with one queue per school. Verdicts are cached.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use model::authoring::draft::DraftVerdict;
use model::ids::SchoolId;
use platform::bounded_queue::{BoundedQueue, QueuePlace};

use crate::error::Error;

/// Maximum time in the queue.
const PATIENCE: Duration = Duration::from_secs(5);
/// Maximum number of cached verdicts; the cache is cleared when it is full.
const MOST: usize = 64;

/// The queues and the cache.
#[derive(Debug)]
pub struct Previews {
    lines: BoundedQueue,
    known: Mutex<BTreeMap<[u8; 32], DraftVerdict>>,
}

impl Default for Previews {
    /// Allows as many concurrent previews as there are cores, but at least two, so that one school
    /// does not block another.
    fn default() -> Self {
        let cores = thread::available_parallelism().map_or(1, Into::into);
        Self { lines: BoundedQueue::new(cores.max(2), 1), known: Mutex::default() }
    }
}

impl Previews {
    /// Waits for a permit to preview a draft.
    ///
    /// # Errors
    /// Returns [`Error::Busy`] if the wait is too long.
    pub async fn enter(&self, school: SchoolId) -> Result<QueuePlace, Error> {
        Ok(self.lines.enter(school, PATIENCE).await?)
    }

    pub(crate) fn told(&self, key: &[u8; 32]) -> Option<DraftVerdict> {
        self.known().get(key).cloned()
    }

    pub(crate) fn keep(&self, key: [u8; 32], verdict: &DraftVerdict) {
        let mut known = self.known();
        if known.len() >= MOST {
            known.clear();
        }
        known.insert(key, verdict.clone());
    }

    /// Locks the cache. A poisoned lock is harmless: each operation leaves the map valid.
    fn known(&self) -> MutexGuard<'_, BTreeMap<[u8; 32], DraftVerdict>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
