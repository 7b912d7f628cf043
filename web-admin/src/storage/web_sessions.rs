//! Signed-in browsers. The table keeps the hash of a session's id, so that a copy of the file signs nobody in.

use async_trait::async_trait;
use sha2::{Digest, Sha256};
use sqlx::types::Json;
use tower_sessions::session::{Id, Record};
use tower_sessions::session_store::{Error, Result as StoreResult};
use tower_sessions::{ExpiredDeletion, SessionStore};

use super::{Database, Result};
use crate::clock::Clock;
use crate::domain::Moment;
use crate::routes::auth::session_end;

/// Keeps sessions in the table `web_sessions`.
#[derive(Clone, Debug)]
pub struct WebSessions {
    db: Database,
    clock: Clock,
}

impl WebSessions {
    /// In a database, judging expiry by a clock.
    #[must_use]
    pub const fn new(db: Database, clock: Clock) -> Self {
        Self { db, clock }
    }

    /// Stores a record; a new one only under an id that nobody has.
    async fn put(&self, record: &Record, new: bool) -> Result<bool> {
        let mut tx = self.db.write().await?;
        let done = sqlx::query(
            "INSERT INTO web_sessions (id_sha256, data, expires_at) VALUES ($1, $2, $3)
             ON CONFLICT (id_sha256) DO UPDATE SET data = excluded.data, expires_at = excluded.expires_at
             WHERE NOT $4",
        )
        .bind(key(record.id))
        .bind(Json(&record.data))
        .bind(session_end(&record.data, self.clock.now()))
        .bind(new)
        .execute(&mut *tx)
        .await?;
        tx.commit().await?;
        Ok(done.rows_affected() == 1)
    }

    async fn get(&self, id: Id) -> Result<Option<Record>> {
        let row: Option<(Json<_>, Moment)> =
            sqlx::query_as("SELECT data, expires_at FROM web_sessions WHERE id_sha256 = $1 AND expires_at > $2")
                .bind(key(id))
                .bind(self.clock.now())
                .fetch_optional(self.db.reader())
                .await?;
        Ok(row.map(|(data, expires_at)| Record { id, data: data.0, expiry_date: expires_at.to_utc() }))
    }

    async fn forget(&self, id: Id) -> Result<()> {
        let mut tx = self.db.write().await?;
        sqlx::query("DELETE FROM web_sessions WHERE id_sha256 = $1").bind(key(id)).execute(&mut *tx).await?;
        tx.commit().await
    }

    async fn forget_expired(&self) -> Result<()> {
        let mut tx = self.db.write().await?;
        sqlx::query("DELETE FROM web_sessions WHERE expires_at <= $1").bind(self.clock.now()).execute(&mut *tx).await?;
        tx.commit().await
    }
}

fn key(id: Id) -> Vec<u8> {
    Sha256::digest(id.0.to_be_bytes()).to_vec()
}

fn backend(error: sqlx::Error) -> Error {
    Error::Backend(error.to_string())
}

#[async_trait]
impl SessionStore for WebSessions {
    async fn create(&self, record: &mut Record) -> StoreResult<()> {
        while !self.put(record, true).await.map_err(backend)? {
            record.id = Id::default();
        }
        Ok(())
    }

    async fn save(&self, record: &Record) -> StoreResult<()> {
        self.put(record, false).await.map(drop).map_err(backend)
    }

    async fn load(&self, id: &Id) -> StoreResult<Option<Record>> {
        self.get(*id).await.map_err(backend)
    }

    async fn delete(&self, id: &Id) -> StoreResult<()> {
        self.forget(*id).await.map_err(backend)
    }
}

#[async_trait]
impl ExpiredDeletion for WebSessions {
    async fn delete_expired(&self) -> StoreResult<()> {
        self.forget_expired().await.map_err(backend)
    }
}
