//! Locks on the data: exclusive for processes that need it to themselves, shared for replicas that
//! serve it.

use model::Moment;
use store::locks::{FileLock, LockError};
use store::{Database, DatabaseAddress, DatabaseLock};

use crate::config::Config;

/// Lock on database and recordings, held until dropped. A recordings folder is locked by a file; a
/// bucket is protected by the lock of its database.
#[derive(Debug)]
pub struct DataLock {
    database: DatabaseLock,
    address: DatabaseAddress,
    holder: String,
    _folder: FileLock,
}

impl DataLock {
    /// Takes an exclusive lock on database and recordings. `purpose` is shown to processes that
    /// fail to get the lock.
    ///
    /// # Errors
    /// Fails if another process holds one of them, or a lock cannot be taken.
    pub async fn take(config: &Config, purpose: &str, now: Moment) -> anyhow::Result<Self> {
        let holder = name_holder(purpose, now);
        let database = Database::hold(&config.database, &holder).await?;
        Self::with_folder(config, database, holder)
    }

    /// Takes a shared lock, together with other replicas on the same database, if the engine
    /// supports several.
    ///
    /// # Errors
    /// Fails if another process holds an exclusive lock, or a lock cannot be taken.
    pub async fn join(config: &Config, purpose: &str, now: Moment) -> anyhow::Result<Self> {
        let holder = name_holder(purpose, now);
        let database = Database::join(&config.database, &holder).await?;
        Self::with_folder(config, database, holder)
    }

    fn with_folder(config: &Config, database: DatabaseLock, holder: String) -> anyhow::Result<Self> {
        let folder = hold_folder(config, &holder)?;
        Ok(Self { database, address: config.database.clone(), holder, _folder: folder })
    }

    /// Takes the shared lock again after a restart of the database server has dropped it.
    ///
    /// # Errors
    /// Fails if another process has taken an exclusive lock in the meantime, or the server does not
    /// respond.
    pub async fn rejoin_if_lost(&mut self) -> Result<(), LockError> {
        if !self.database.is_held().await {
            self.database = Database::join(&self.address, &self.holder).await?;
            tracing::warn!("database lock was lost and has been taken again");
        }
        Ok(())
    }
}

/// Describes the lock holder to other processes: purpose, process id, and start time.
pub fn name_holder(purpose: &str, now: Moment) -> String {
    format!("{purpose} (process {}, since {now})", std::process::id())
}

/// Takes an exclusive lock on the recordings folder of a configuration.
pub fn hold_folder(config: &Config, holder: &str) -> Result<FileLock, LockError> {
    FileLock::take(&config.recordings_dir.with_extension("lock"), holder)
}

#[cfg(test)]
mod tests {
    //! Two services on one folder would score everything twice and destroy each other's uploads.

    use super::*;

    #[tokio::test]
    async fn data_lock_names_its_holder_and_is_free_after_release() {
        let folder = tempfile::tempdir().unwrap();
        let config = Config::in_folder(&folder.path().join("data"));
        let now = Moment::from_micros(0);
        let first = DataLock::take(&config, "web-admin serve", now).await.unwrap();
        let refused = DataLock::take(&config, "web-admin restore", now).await.unwrap_err().to_string();
        let us = std::process::id().to_string();
        assert!(refused.contains("web-admin serve") && refused.contains(&us), "{refused}");
        drop(first);
        DataLock::take(&config, "web-admin restore", now).await.unwrap();
    }

    #[tokio::test]
    async fn recordings_folder_locks_even_with_another_database() {
        let folder = tempfile::tempdir().unwrap();
        let config = Config::in_folder(folder.path());
        let other = Config { database: DatabaseAddress::in_folder(&folder.path().join("other")), ..config.clone() };
        let _first = DataLock::take(&config, "web-admin serve", Moment::from_micros(0)).await.unwrap();
        assert!(DataLock::take(&other, "web-admin serve", Moment::from_micros(0)).await.is_err());
    }
}
