//! One writer at a time for each upload, who gives way to the next.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use model::ids::UploadId;
use tokio::sync::watch;

/// How long who wants a turn waits for whoever has it.
const PATIENCE: Duration = Duration::from_secs(5);

/// Uploads that somebody is writing to, and how to tell them that another wants to.
#[derive(Clone, Debug, Default)]
pub struct Turns(Arc<Mutex<BTreeMap<UploadId, Arc<watch::Sender<bool>>>>>);

/// The right to write to an upload, until it is dropped.
#[derive(Debug)]
pub struct Turn {
    turns: Turns,
    id: UploadId,
    /// Closed with the turn, so that whoever waits knows.
    wanted: watch::Receiver<bool>,
}

impl Turns {
    /// The turn, unless somebody has it.
    #[must_use]
    pub fn take(&self, id: UploadId) -> Option<Turn> {
        let mut taken = self.taken();
        if taken.contains_key(&id) {
            return None;
        }
        let (tell, wanted) = watch::channel(false);
        taken.insert(id, Arc::new(tell));
        Some(Turn { turns: self.clone(), id, wanted })
    }

    /// The turn; whoever has it is told to give way. None where they do not in time.
    pub async fn take_over(&self, id: UploadId) -> Option<Turn> {
        let wait = async {
            loop {
                if let Some(turn) = self.take(id) {
                    return turn;
                }
                let holder = self.taken().get(&id).cloned();
                if let Some(holder) = holder {
                    holder.send_replace(true);
                    holder.closed().await;
                }
            }
        };
        tokio::time::timeout(PATIENCE, wait).await.ok()
    }

    /// Nobody has the turn.
    #[must_use]
    pub fn free(&self, id: UploadId) -> bool {
        !self.taken().contains_key(&id)
    }

    fn taken(&self) -> MutexGuard<'_, BTreeMap<UploadId, Arc<watch::Sender<bool>>>> {
        // Nothing can be half done in a map of ids, so a panic elsewhere spoils nothing.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Turn {
    /// Waits until somebody else wants the turn.
    pub async fn wanted(&mut self) {
        if self.wanted.wait_for(|wanted| *wanted).await.is_err() {
            // Who could tell is there for as long as the turn.
            std::future::pending::<()>().await;
        }
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        self.turns.taken().remove(&self.id);
    }
}
