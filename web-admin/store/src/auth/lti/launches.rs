//! Launches that the learning platform has not confirmed yet.

use model::Moment;
use model::ids::{PlatformId, SchoolId};
use sqlx::FromRow;

use crate::{Connection, Result};

/// A launch that was sent to the learning platform.
#[derive(Clone, Debug, FromRow)]
pub struct BegunLaunch {
    /// School.
    pub school_id: SchoolId,
    /// Learning platform.
    pub platform_id: PlatformId,
    /// SHA-256 of the token of the browser in which it was begun.
    pub browser_sha256: Vec<u8>,
    /// SHA-256 of the nonce.
    pub nonce_sha256: Vec<u8>,
    /// The user, for the platform.
    pub login_hint: String,
    /// The message, for the platform.
    pub message_hint: Option<String>,
    /// Address of this service to open.
    pub target_link_uri: String,
    /// Expiry.
    pub expires_at: Moment,
}

/// Stores a launch under the hash of its state, and deletes expired ones.
pub async fn add_launch(
    writer: &mut Connection,
    state_sha256: &[u8; 32],
    launch: &BegunLaunch,
    now: Moment,
) -> Result<()> {
    sqlx::query("DELETE FROM launches WHERE expires_at < $1").bind(now).execute(&mut *writer).await?;
    sqlx::query(
        "INSERT INTO launches (state_sha256, school_id, platform_id, browser_sha256, nonce_sha256, login_hint, message_hint,
           target_link_uri, expires_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9)",
    )
    .bind(state_sha256.as_slice())
    .bind(launch.school_id)
    .bind(launch.platform_id)
    .bind(&launch.browser_sha256)
    .bind(&launch.nonce_sha256)
    .bind(&launch.login_hint)
    .bind(&launch.message_hint)
    .bind(&launch.target_link_uri)
    .bind(launch.expires_at)
    .execute(writer)
    .await
    .map(drop)
}

/// Removes and returns a launch, so that it can be confirmed only once.
pub async fn take_launch(writer: &mut Connection, state_sha256: &[u8; 32]) -> Result<Option<BegunLaunch>> {
    sqlx::query_as(
        "DELETE FROM launches WHERE state_sha256 = $1
         RETURNING school_id, platform_id, browser_sha256, nonce_sha256, login_hint, message_hint, target_link_uri,
           expires_at",
    )
    .bind(state_sha256.as_slice())
    .fetch_optional(writer)
    .await
}
