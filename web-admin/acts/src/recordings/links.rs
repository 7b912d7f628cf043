//! Short-lived URLs by which the browser's viewer opens a recording without a session.

use model::CurrentPerson;
use platform::secret;
use serde_json::json;
use store::audit::AuditEntry;
use store::recordings::links;
use store::recordings::links::NewRecordingLink;
use store::recordings::sessions::Session;

use crate::error::Error;
use crate::service::Service;

/// Lifetime of a URL, in s.
pub const LINK_LIFETIME_S: i64 = 15 * 60;

/// Creates a URL for a recording and returns the secret in it.
///
/// # Errors
/// Fails if the database or the random source fails.
pub async fn make_recording_link(service: &Service, by: &CurrentPerson, session: &Session) -> Result<String, Error> {
    let (now, token) = (service.clock.now(), secret::random_hex()?);
    let until = now.plus_s(LINK_LIFETIME_S);
    let mut tx = service.db.write().await?;
    let hash = secret::token_sha256(&token);
    let link = NewRecordingLink { session: session.key(), made_by: by.id, token_sha256: &hash, expires_at: until };
    links::add_recording_link(&mut tx, link, now).await?;
    AuditEntry::by(by, "recording.linked", session.id).with(json!({ "until": until })).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(token)
}
