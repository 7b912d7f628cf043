//! Lines for work that takes long: fewer places for a school than there are in all, so that nobody waits for one other school.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use model::ids::SchoolId;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Lines before a kind of work.
#[derive(Debug)]
pub struct Lines {
    all: Arc<Semaphore>,
    of_each: usize,
    schools: Mutex<BTreeMap<SchoolId, Arc<Semaphore>>>,
}

/// A place where work may be done, until it is dropped.
#[derive(Debug)]
pub struct WorkPlace {
    _of_school: OwnedSemaphorePermit,
    _of_all: OwnedSemaphorePermit,
}

impl Lines {
    /// Lines before so many places in all, of which a school may have so many.
    #[must_use]
    pub fn new(all: usize, of_each: usize) -> Self {
        Self { all: Arc::new(Semaphore::new(all)), of_each, schools: Mutex::default() }
    }

    /// Waits in the line of a school; none where its turn does not come in time.
    pub async fn enter(&self, school: SchoolId, patience: Duration) -> Option<WorkPlace> {
        let line = self.of(school);
        let wait = async {
            let of_school = line.acquire_owned().await.ok()?;
            let of_all = Arc::clone(&self.all).acquire_owned().await.ok()?;
            Some(WorkPlace { _of_school: of_school, _of_all: of_all })
        };
        tokio::time::timeout(patience, wait).await.ok().flatten()
    }

    fn of(&self, school: SchoolId) -> Arc<Semaphore> {
        // Nothing can be half done in a map of lines, so a panic elsewhere spoils nothing.
        let mut schools = self.schools.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(schools.entry(school).or_insert_with(|| Arc::new(Semaphore::new(self.of_each))))
    }
}

#[cfg(test)]
mod tests {
    //! Who waits must wait for its own school alone.

    use super::*;

    const SHORT: Duration = Duration::from_millis(50);

    #[tokio::test]
    async fn a_school_waits_for_itself_and_no_other_does() {
        let (lines, [north, south, east]) = (Lines::new(2, 1), [1, 2, 3].map(SchoolId::from_u128));
        let first = lines.enter(north, SHORT).await;
        assert!(first.is_some());
        assert!(lines.enter(north, SHORT).await.is_none(), "one at a time");
        let other = lines.enter(south, SHORT).await;
        assert!(other.is_some(), "another school has a place");
        assert!(lines.enter(east, SHORT).await.is_none(), "but there are two in all");
        drop(other);
        assert!(lines.enter(east, SHORT).await.is_some());
        drop(first);
        assert!(lines.enter(north, SHORT).await.is_some());
    }
}
