//! One writer at a time for each upload.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use uuid::Uuid;

/// Uploads that somebody is writing to.
#[derive(Clone, Debug, Default)]
pub struct Turns(Arc<Mutex<BTreeSet<Uuid>>>);

/// The right to write to an upload, until it is dropped.
#[derive(Debug)]
pub struct Turn {
    turns: Turns,
    id: Uuid,
}

impl Turns {
    /// The turn, unless somebody has it.
    #[must_use]
    pub fn take(&self, id: Uuid) -> Option<Turn> {
        self.taken().insert(id).then(|| Turn { turns: self.clone(), id })
    }

    /// Nobody has the turn.
    #[must_use]
    pub fn free(&self, id: Uuid) -> bool {
        !self.taken().contains(&id)
    }

    fn taken(&self) -> MutexGuard<'_, BTreeSet<Uuid>> {
        // Nothing can be half done in a set of ids, so a panic elsewhere spoils nothing.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        self.turns.taken().remove(&self.id);
    }
}
