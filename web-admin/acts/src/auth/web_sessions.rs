//! Web sessions: the signed-in person and the expiry.

use async_trait::async_trait;
use model::Moment;
use model::ids::PersonId;
use platform::clock::Clock;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use store::auth::web_sessions;
use store::auth::web_sessions::{SessionData, WebSessionRow};
use store::{Database, Result};
use tower_sessions::session::{Id, Record};
use tower_sessions::session_store::{Error, Result as StoreResult};
use tower_sessions::{ExpiredDeletion, SessionStore};

use crate::error::AWAY;

/// Key of the signed-in person in a session.
pub const SIGNED_IN_KEY: &str = "person";

/// Lifetime of an anonymous session after its last write, in s.
const STRANGER_S: i64 = 30 * 60;

/// Data of a signed-in session.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct SignedInSession {
    /// The person.
    pub person_id: PersonId,
    /// Version of the password used; a newer one ends the session.
    pub credential_version: i64,
    /// Absolute expiry. Missing in sessions written by earlier versions.
    #[serde(default)]
    pub until: Option<Moment>,
    /// A provider that the school trusts has seen a second factor: none is owed here.
    #[serde(default)]
    pub has_factor_elsewhere: bool,
}

/// Returns the expiry of a session: the absolute one if it has one, else half an hour after this
/// write. Anonymous sessions, which only earlier versions created, have none.
fn session_end(data: &SessionData, now: Moment) -> Moment {
    let signed_in = data.get(SIGNED_IN_KEY).and_then(|held| SignedInSession::deserialize(held).ok());
    signed_in.and_then(|held| held.until).unwrap_or(now.plus_s(STRANGER_S))
}

/// Session store in the table `web_sessions`.
#[derive(Clone, Debug)]
pub struct WebSessions {
    db: Database,
    clock: Clock,
}

impl WebSessions {
    /// Creates a store that judges expiry by `clock`.
    #[must_use]
    pub const fn new(db: Database, clock: Clock) -> Self {
        Self { db, clock }
    }

    /// Stores a record; with `new`, only if its id is unused, and returns whether it did.
    async fn put(&self, record: &Record, new: bool) -> Result<bool> {
        let expires_at = session_end(&record.data, self.clock.now());
        let row = WebSessionRow { id_sha256: &key(record.id), data: &record.data, expires_at };
        let mut tx = self.db.write().await?;
        let kept = web_sessions::put_session(&mut tx, row, new).await?;
        tx.commit().await?;
        Ok(kept)
    }

    async fn find(&self, id: Id) -> Result<Option<Record>> {
        let found = web_sessions::find_session(self.db.reader(), &key(id), self.clock.now()).await?;
        Ok(found.map(|(data, expires_at)| Record { id, data, expiry_date: expires_at.to_utc() }))
    }

    async fn forget(&self, id: Id) -> Result<()> {
        let mut tx = self.db.write().await?;
        web_sessions::forget_session(&mut tx, &key(id)).await?;
        tx.commit().await
    }

    async fn forget_ended(&self) -> Result<()> {
        let mut tx = self.db.write().await?;
        web_sessions::forget_ended_sessions(&mut tx, self.clock.now()).await?;
        tx.commit().await
    }
}

fn key(id: Id) -> Vec<u8> {
    Sha256::digest(id.0.to_be_bytes()).to_vec()
}

fn backend(error: store::Error) -> Error {
    match store::is_database_unavailable(&error) {
        true => Error::Backend(format!("{AWAY}: {error}")),
        false => Error::Backend(error.to_string()),
    }
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
        self.find(*id).await.map_err(backend)
    }

    async fn delete(&self, id: &Id) -> StoreResult<()> {
        self.forget(*id).await.map_err(backend)
    }
}

#[async_trait]
impl ExpiredDeletion for WebSessions {
    async fn delete_expired(&self) -> StoreResult<()> {
        self.forget_ended().await.map_err(backend)
    }
}
