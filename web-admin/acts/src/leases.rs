//! Releases leases on recordings even while the database is unavailable: no other replica takes a
//! recording over while this one appears to hold it.

use std::future::Future;
use std::time::Duration;

use crate::error::{Error, error_chain};

/// Delay between retries.
const AGAIN: Duration = Duration::from_secs(2);

/// Releases a lease now or, if the database is unavailable, in the background as soon as it answers
/// again; `what` names the lease in the log.
///
/// # Errors
/// Fails if the lease has not been released yet. If the database answers with an error, there is no
/// further retry, and the lease lasts until the service stops.
pub async fn release<Released>(what: &'static str, release: impl Fn() -> Released + Send + 'static) -> Result<(), Error>
where
    Released: Future<Output = Result<(), Error>> + Send,
{
    let done = release().await;
    if matches!(done, Err(Error::DatabaseUnavailable(_))) {
        tokio::spawn(async move {
            loop {
                tokio::time::sleep(AGAIN).await;
                match release().await {
                    Ok(()) => return,
                    Err(Error::DatabaseUnavailable(_)) => {}
                    Err(error) => {
                        tracing::warn!(
                            cause = error_chain(&error),
                            "failed to release {what}; held until the service stops"
                        );
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
    //! A lease must not outlast a database outage, and an error from the database must end the
    //! retries.

    use std::sync::Arc;
    use std::sync::atomic::AtomicUsize;
    use std::sync::atomic::Ordering::SeqCst;

    use super::*;

    /// Releases a lease while the database is unavailable for the first `away` attempts and then
    /// returns `then`. Returns the number of attempts.
    async fn tries(away: usize, then: fn() -> Result<(), Error>) -> usize {
        let tried = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&tried);
        let first = release("a recording", move || {
            let before = counted.fetch_add(1, SeqCst);
            async move { if before < away { Err(Error::DatabaseUnavailable(anyhow::anyhow!("cut"))) } else { then() } }
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
