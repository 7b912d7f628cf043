//! What drafts of exercises come to, computed where it harms nobody: in the process that judges, within a budget, ended when nobody waits
//! any more, in a line of its own for each school. What is known is told again at once.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use model::draft::DraftVerdict;
use model::ids::SchoolId;

use crate::error::Error;
use crate::lines::{Lines, WorkPlace};

/// Longest wait for one's turn.
const PATIENCE: Duration = Duration::from_secs(5);
/// Most answers that are kept.
const MOST: usize = 64;

/// The lines, and what is known.
#[derive(Debug)]
pub struct Previews {
    lines: Lines,
    known: Mutex<BTreeMap<[u8; 32], DraftVerdict>>,
}

impl Default for Previews {
    /// As many at once as there are cores, two at least: one school's must leave room for another's.
    fn default() -> Self {
        let cores = thread::available_parallelism().map_or(1, Into::into);
        Self { lines: Lines::new(cores.max(2), 1), known: Mutex::default() }
    }
}

impl Previews {
    /// A place to look what a draft comes to, of the few that a school has.
    ///
    /// # Errors
    /// [`Error::Busy`] when the school's turn does not come in time.
    pub async fn enter(&self, school: SchoolId) -> Result<WorkPlace, Error> {
        let place = self.lines.enter(school, PATIENCE).await;
        place.ok_or(Error::Busy { retry_after_s: PATIENCE.as_secs() })
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

    /// Whoever panicked has left nothing half-written here.
    fn known(&self) -> MutexGuard<'_, BTreeMap<[u8; 32], DraftVerdict>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
