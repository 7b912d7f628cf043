//! Write locks on uploads. The holder can be asked to release its lock for a new request.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use model::ids::UploadId;
use tokio::sync::watch;

/// How long a request waits for the current holder to release a lock.
const PATIENCE: Duration = Duration::from_secs(5);

/// The locked uploads, each with the channel that asks its holder to release the lock.
#[derive(Clone, Debug, Default)]
pub struct UploadLocks(Arc<Mutex<BTreeMap<UploadId, Arc<watch::Sender<bool>>>>>);

/// The write lock on an upload, released on drop.
#[derive(Debug)]
pub struct UploadLock {
    turns: UploadLocks,
    id: UploadId,
    /// The channel closes when the lock is released, which wakes waiting requests.
    wanted: watch::Receiver<bool>,
}

impl UploadLocks {
    /// Takes the lock; returns `None` if it is held.
    #[must_use]
    pub fn take(&self, id: UploadId) -> Option<UploadLock> {
        let mut taken = self.taken();
        if taken.contains_key(&id) {
            return None;
        }
        let (tell, wanted) = watch::channel(false);
        taken.insert(id, Arc::new(tell));
        Some(UploadLock { turns: self.clone(), id, wanted })
    }

    /// Takes the lock, asking its holder to release it. Returns `None` if the holder does not do so
    /// in time.
    pub async fn take_over(&self, id: UploadId) -> Option<UploadLock> {
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

    /// Returns whether the lock is free.
    #[must_use]
    pub fn free(&self, id: UploadId) -> bool {
        !self.taken().contains_key(&id)
    }

    fn taken(&self) -> MutexGuard<'_, BTreeMap<UploadId, Arc<watch::Sender<bool>>>> {
        // A poisoned lock is harmless: each operation leaves the map valid.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl UploadLock {
    /// Waits until another request wants the lock.
    pub async fn wanted(&mut self) {
        if self.wanted.wait_for(|wanted| *wanted).await.is_err() {
            // The sender lives as long as the lock, so this is unreachable.
            std::future::pending::<()>().await;
        }
    }
}

impl Drop for UploadLock {
    fn drop(&mut self) {
        self.turns.taken().remove(&self.id);
    }
}
