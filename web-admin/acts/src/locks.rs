//! Who has the data: a process that needs everything to itself, or those that serve it.

use model::Moment;
use store::locks::{FileLock, LockError};
use store::{Database, DatabaseAddress, DatabaseLock};

use crate::config::Config;

/// Database and recordings, held by this process until it is dropped. A folder is held by one; a bucket by whoever has its database.
#[derive(Debug)]
pub struct DataLock {
    database: DatabaseLock,
    address: DatabaseAddress,
    holder: String,
    _folder: FileLock,
}

impl DataLock {
    /// Takes database and recordings, wherever each lies, for this process alone; `purpose` tells others what for.
    ///
    /// # Errors
    /// When another process has one of them, or one cannot be locked.
    pub async fn take(config: &Config, purpose: &str, now: Moment) -> anyhow::Result<Self> {
        let holder = name_holder(purpose, now);
        let database = Database::hold(&config.database, &holder).await?;
        Self::with_folder(config, database, holder)
    }

    /// Takes them beside others that serve the same database, where it may have several.
    ///
    /// # Errors
    /// When a process has one of them to itself, or one cannot be locked.
    pub async fn join(config: &Config, purpose: &str, now: Moment) -> anyhow::Result<Self> {
        let holder = name_holder(purpose, now);
        let database = Database::join(&config.database, &holder).await?;
        Self::with_folder(config, database, holder)
    }

    fn with_folder(config: &Config, database: DatabaseLock, holder: String) -> anyhow::Result<Self> {
        let folder = hold_folder(config, &holder)?;
        Ok(Self { database, address: config.database.clone(), holder, _folder: folder })
    }

    /// Joins those that serve the database once more, where the server has been started anew and knows of nobody.
    ///
    /// # Errors
    /// When a process has the database to itself by now, or the server does not answer.
    pub async fn rejoin_if_lost(&mut self) -> Result<(), LockError> {
        if !self.database.is_held().await {
            self.database = Database::join(&self.address, &self.holder).await?;
            tracing::warn!("the database had forgotten that it is served, and has been told again");
        }
        Ok(())
    }
}

/// What others are told of whoever has the data: what for, which process, and since when.
pub(crate) fn name_holder(purpose: &str, now: Moment) -> String {
    format!("{purpose} (process {}, since {now})", std::process::id())
}

/// Takes the folder of a configuration's recordings for this process alone.
pub(crate) fn hold_folder(config: &Config, holder: &str) -> Result<FileLock, LockError> {
    FileLock::take(&config.recordings_dir.with_extension("lock"), holder)
}

#[cfg(test)]
mod tests {
    //! Two services on one folder score everything twice and destroy each other's uploads.

    use super::*;

    #[tokio::test]
    async fn who_comes_second_is_told_who_was_first_and_gets_it_when_they_have_gone() {
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
    async fn the_same_recordings_beside_another_database_are_not_to_be_had() {
        let folder = tempfile::tempdir().unwrap();
        let config = Config::in_folder(folder.path());
        let other = Config { database: DatabaseAddress::in_folder(&folder.path().join("other")), ..config.clone() };
        let _first = DataLock::take(&config, "web-admin serve", Moment::from_micros(0)).await.unwrap();
        assert!(DataLock::take(&other, "web-admin serve", Moment::from_micros(0)).await.is_err());
    }
}
