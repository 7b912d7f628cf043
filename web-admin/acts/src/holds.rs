//! Letting go of what was held to be read, however long the database does not answer: as long as this service seems to hold it, no other
//! takes it up.

use std::future::Future;
use std::time::Duration;

use crate::error::{Error, tell_in_full};

/// Between two tries.
const AGAIN: Duration = Duration::from_secs(2);

/// Lets go now, or else as soon as the database answers again; `what` is for the log.
///
/// # Errors
/// When it is not let go of yet. Where the database answers and refuses, it never is before the service ends.
pub async fn let_go<Released>(what: &'static str, release: impl Fn() -> Released + Send + 'static) -> Result<(), Error>
where
    Released: Future<Output = Result<(), Error>> + Send,
{
    let done = release().await;
    if matches!(done, Err(Error::DatabaseAway(_))) {
        tokio::spawn(async move {
            loop {
                tokio::time::sleep(AGAIN).await;
                match release().await {
                    Ok(()) => return,
                    Err(Error::DatabaseAway(_)) => {}
                    Err(error) => {
                        tracing::warn!(cause = tell_in_full(&error), "{what} stays held until the service stops");
                        return;
                    }
                }
            }
        });
    }
    done
}

#[cfg(test)]
mod tests {
    //! Fails when what was held stays so after the database is back, or when it is tried for ever what the database refuses.

    use std::sync::Arc;
    use std::sync::atomic::AtomicUsize;
    use std::sync::atomic::Ordering::SeqCst;

    use super::*;

    /// Lets go of something by a database that is away for the first tries, and then says so; how often it was tried.
    async fn tries(away: usize, then: fn() -> Result<(), Error>) -> usize {
        let tried = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&tried);
        let first = let_go("a recording", move || {
            let before = counted.fetch_add(1, SeqCst);
            async move { if before < away { Err(Error::DatabaseAway(anyhow::anyhow!("cut"))) } else { then() } }
        });
        assert_eq!(first.await.is_err(), away > 0 || then().is_err());
        tokio::time::sleep(AGAIN * 4).await;
        tried.load(SeqCst)
    }

    #[tokio::test]
    async fn what_is_held_is_let_go_of_once_the_database_answers() {
        let (at_once, later, refused) =
            tokio::join!(tries(0, || Ok(())), tries(2, || Ok(())), tries(1, || Err(Error::NotFound)),);
        assert_eq!((at_once, later, refused), (1, 3, 2));
    }
}
