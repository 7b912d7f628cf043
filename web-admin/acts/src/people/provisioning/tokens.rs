//! Tokens of directories, made by administrators.

use model::CurrentPerson;
use model::ids::ProvisioningTokenId;
use platform::secret;
use serde_json::json;
use store::audit::AuditEntry;
use store::people::provisioning::{self, ProvisioningToken};

use crate::auth::tokens::checked_name;
use crate::error::Error;
use crate::service::Service;

/// Lifetime of a token, in s.
const LIFETIME_S: i64 = 365 * 86_400;
/// Maximum number of tokens of a school.
const MOST: usize = 20;
/// Resolution of the time of the last use, in s.
const HOUR_S: i64 = 3600;

/// Creates a token, and returns it; only its hash is stored.
///
/// # Errors
/// Fails if the name is not allowed, there are too many tokens, or the database fails.
pub async fn make_token(
    service: &Service,
    by: &CurrentPerson,
    name: &str,
    may_disable_staff: bool,
) -> Result<String, Error> {
    let (now, token) = (service.clock.now(), secret::random_hex()?);
    let new = ProvisioningToken {
        id: ProvisioningTokenId::made_at(now),
        school_id: by.school_id,
        name: checked_name(name)?,
        may_disable_staff,
        made_at: now,
        expires_at: now.plus_s(LIFETIME_S),
        last_used_at: None,
    };
    let mut tx = service.db.write().await?;
    if provisioning::list_tokens(&mut *tx, by.school_id).await?.len() >= MOST {
        return Err(Error::Unprocessable(tr!("at most {most} tokens are allowed", most = MOST)));
    }
    provisioning::add_token(&mut tx, &new, &secret::token_sha256(&token)).await?;
    AuditEntry::by(by, "provisioning_token.made", new.id)
        .with(json!({ "may_disable_staff": may_disable_staff }))
        .append(&mut tx, now)
        .await?;
    tx.commit().await?;
    Ok(token)
}

/// Revokes a token.
///
/// # Errors
/// Fails if there is no such token, or the database fails.
pub async fn revoke_token(service: &Service, by: &CurrentPerson, id: ProvisioningTokenId) -> Result<(), Error> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    if !provisioning::revoke_token(&mut tx, by.school_id, id, now).await? {
        return Err(Error::NotFound);
    }
    AuditEntry::by(by, "provisioning_token.revoked", id).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

/// Returns the valid token of a request, and counts the request.
///
/// # Errors
/// Returns [`Error::Unauthorized`] for an unknown, revoked or expired token, and
/// [`Error::TooMany`] for more than 50 requests per second.
pub async fn admit_directory(service: &Service, token: &str) -> Result<ProvisioningToken, Error> {
    let now = service.clock.now();
    let found = provisioning::find_token(service.db.reader(), &secret::token_sha256(token)).await?;
    let found = found.filter(|found| found.expires_at > now).ok_or(Error::Unauthorized)?;
    if !service.provisioning_pace.take(found.id.uuid()) {
        return Err(Error::TooMany { retry_after_s: 1 });
    }
    if found.last_used_at.is_none_or(|at| at.plus_s(HOUR_S) <= now) {
        let mut tx = service.db.write().await?;
        provisioning::note_token_use(&mut tx, found.id, now).await?;
        tx.commit().await?;
    }
    Ok(found)
}
