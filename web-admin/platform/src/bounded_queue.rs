//! Bounded concurrency for expensive work, with a lower limit per school than in total, so that one
//! school cannot block the others.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use model::ids::SchoolId;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Semaphores for one kind of work: one for all schools and one per school.
#[derive(Debug)]
pub struct BoundedQueue {
    all: Arc<Semaphore>,
    of_each: usize,
    schools: Mutex<BTreeMap<SchoolId, Arc<Semaphore>>>,
}

/// A permit to do the work, released on drop.
#[derive(Debug)]
pub struct QueuePlace {
    _of_school: OwnedSemaphorePermit,
    _of_all: OwnedSemaphorePermit,
}

/// No permit was free in time; contains the time that was waited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no place in the queue within {0:?}")]
pub struct QueueTimeout(pub Duration);

impl BoundedQueue {
    /// Creates a limit of `all` concurrent permits in total and `of_each` per school.
    #[must_use]
    pub fn new(all: usize, of_each: usize) -> Self {
        Self { all: Arc::new(Semaphore::new(all)), of_each, schools: Mutex::default() }
    }

    /// Waits for a permit.
    ///
    /// # Errors
    /// Returns [`QueueTimeout`] after `patience`.
    pub async fn enter(&self, school: SchoolId, patience: Duration) -> Result<QueuePlace, QueueTimeout> {
        let line = self.of(school);
        let wait = async {
            let of_school = line.acquire_owned().await.ok()?;
            let of_all = Arc::clone(&self.all).acquire_owned().await.ok()?;
            Some(QueuePlace { _of_school: of_school, _of_all: of_all })
        };
        tokio::time::timeout(patience, wait).await.ok().flatten().ok_or(QueueTimeout(patience))
    }

    fn of(&self, school: SchoolId) -> Arc<Semaphore> {
        // A poisoned lock is harmless: each operation leaves the map valid.
        let mut schools = self.schools.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(schools.entry(school).or_insert_with(|| Arc::new(Semaphore::new(self.of_each))))
    }
}

#[cfg(test)]
mod tests {
    //! A school must wait for its own work only.

    use super::*;

    const SHORT: Duration = Duration::from_millis(50);

    #[tokio::test]
    async fn a_school_waits_for_itself_and_no_other_does() {
        let (lines, [north, south, east]) = (BoundedQueue::new(2, 1), [1, 2, 3].map(SchoolId::from_u128));
        let first = lines.enter(north, SHORT).await;
        assert!(first.is_ok());
        assert!(lines.enter(north, SHORT).await.is_err(), "one at a time");
        let other = lines.enter(south, SHORT).await;
        assert!(other.is_ok(), "another school has a place");
        assert!(lines.enter(east, SHORT).await.is_err(), "but there are two in all");
        drop(other);
        assert!(lines.enter(east, SHORT).await.is_ok());
        drop(first);
        assert!(lines.enter(north, SHORT).await.is_ok());
    }
}
