//! Sign-ins at providers that have not come back yet.

use model::Moment;
use model::auth::federation::FlowPurpose;
use model::ids::{PersonId, ProviderId, SchoolId};
use sqlx::FromRow;

use crate::{Connection, Result};

/// A sign-in at a provider.
#[derive(Clone, Debug, FromRow)]
pub struct SignInFlow {
    /// School.
    pub school_id: SchoolId,
    /// Provider.
    pub provider_id: ProviderId,
    /// SHA-256 of the token of the browser in which it was begun.
    pub browser_sha256: Vec<u8>,
    /// SHA-256 of the nonce.
    pub nonce_sha256: Vec<u8>,
    /// The PKCE code verifier, encrypted.
    pub pkce_sealed: Vec<u8>,
    /// Purpose.
    pub purpose: FlowPurpose,
    /// The signed-in person; `None` for a stranger.
    pub person_id: Option<PersonId>,
    /// Path to open afterwards.
    pub next: String,
    /// Expiry.
    pub expires_at: Moment,
}

/// Stores a flow under the hash of its state, and deletes expired ones.
pub async fn add_flow(writer: &mut Connection, state_sha256: &[u8; 32], flow: &SignInFlow, now: Moment) -> Result<()> {
    sqlx::query("DELETE FROM sign_in_flows WHERE expires_at < $1").bind(now).execute(&mut *writer).await?;
    sqlx::query(
        "INSERT INTO sign_in_flows (state_sha256, school_id, provider_id, browser_sha256, nonce_sha256, pkce_sealed, purpose,
           person_id, next, expires_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)",
    )
    .bind(state_sha256.as_slice())
    .bind(flow.school_id)
    .bind(flow.provider_id)
    .bind(&flow.browser_sha256)
    .bind(&flow.nonce_sha256)
    .bind(&flow.pkce_sealed)
    .bind(flow.purpose)
    .bind(flow.person_id)
    .bind(&flow.next)
    .bind(flow.expires_at)
    .execute(writer)
    .await
    .map(drop)
}

/// Removes and returns a flow, so that it can be answered only once.
pub async fn take_flow(writer: &mut Connection, state_sha256: &[u8; 32]) -> Result<Option<SignInFlow>> {
    sqlx::query_as(
        "DELETE FROM sign_in_flows WHERE state_sha256 = $1
         RETURNING school_id, provider_id, browser_sha256, nonce_sha256, pkce_sealed, purpose, person_id, next, expires_at",
    )
    .bind(state_sha256.as_slice())
    .fetch_optional(writer)
    .await
}
