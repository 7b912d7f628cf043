//! The keys with which this service authenticates as a client: created when first needed, replaced
//! every year.

use model::Moment;
use platform::openid::{ClientKey, NewClientKey};
use platform::sealing;
use platform::secret::token_sha256;
use serde_json::Value;
use store::Json;
use store::auth::client_keys;
use store::auth::client_keys::StoredClientKey;

use crate::error::Error;
use crate::service::Service;

const DAY_S: i64 = 24 * 3600;
/// How long a key signs, in s.
const LIFETIME_S: i64 = 365 * DAY_S;
/// How long the next key is published before it signs, in s: providers keep key sets for a day or so.
const ANNOUNCED_S: i64 = 7 * DAY_S;
/// How long a key stays published after the next one signs, in s.
const RETIRED_S: i64 = 30 * DAY_S;

/// Returns the address of the public keys.
#[must_use]
pub fn keys_uri(service: &Service) -> String {
    format!("{}/.well-known/jwks.json", service.config.address())
}

/// Returns the public keys, for providers (a JSON Web Key Set's `keys`).
///
/// # Errors
/// Fails if the database fails.
pub async fn list_public_keys(service: &Service) -> Result<Vec<Value>, Error> {
    let keys = client_keys::list_client_keys(service.db.reader()).await?;
    Ok(keys.into_iter().map(|key| key.public_jwk.0).collect())
}

/// Returns the key that signs now; creates the first one.
///
/// # Errors
/// Fails if the key file or the database fails.
pub(in crate::auth) async fn read_signing_key(service: &Service) -> Result<ClientKey, Error> {
    let now = service.clock.now();
    let signing = async || {
        let mut keys = client_keys::list_client_keys(service.db.reader()).await?.into_iter();
        Ok::<_, Error>(keys.rfind(|key| key.signs_from <= now))
    };
    let key = match signing().await? {
        Some(key) => key,
        None => {
            add_key(service, now, Moment::from_micros(0)).await?;
            signing().await?.ok_or(Error::Busy { retry_after_s: 1 })?
        }
    };
    let private = sealing::open(&service.config.keys_dir, &owner_of(&key.kid), &key.private_sealed)?;
    Ok(ClientKey::read(&key.kid, &private)?)
}

/// Replaces an old key, and deletes those that were replaced long ago.
///
/// # Errors
/// Fails if the key file or the database fails.
pub(crate) async fn renew_keys(service: &Service) -> Result<(), Error> {
    let now = service.clock.now();
    let keys = client_keys::list_client_keys(service.db.reader()).await?;
    let Some(last) = keys.last() else { return Ok(()) };
    if last.signs_from <= now.plus_s(ANNOUNCED_S - LIFETIME_S) {
        add_key(service, now.plus_s(ANNOUNCED_S), now).await?;
    }
    let is_retired = |next: &StoredClientKey| next.signs_from < now.plus_s(-RETIRED_S);
    let retired = keys.iter().zip(keys.iter().skip(1)).filter(|(_, next)| is_retired(next));
    for (key, _) in retired {
        let mut tx = service.db.write().await?;
        client_keys::delete_client_key(&mut tx, &key.kid).await?;
        tx.commit().await?;
    }
    Ok(())
}

/// Adds a key, unless another one signs from `after` on or later.
async fn add_key(service: &Service, signs_from: Moment, after: Moment) -> Result<(), Error> {
    let new = tokio::task::spawn_blocking(NewClientKey::generate).await??;
    let key = StoredClientKey {
        private_sealed: sealing::seal(&service.config.keys_dir, &owner_of(&new.kid), &new.private)?,
        kid: new.kid,
        public_jwk: Json(new.public),
        signs_from,
    };
    let mut tx = service.db.write().await?;
    client_keys::add_client_key(&mut tx, &key, after).await?;
    Ok(tx.commit().await?)
}

/// Returns the id to which the private key is sealed.
fn owner_of(kid: &str) -> [u8; 16] {
    let mut owner = [0; 16];
    owner.copy_from_slice(&token_sha256(kid)[..16]);
    owner
}
