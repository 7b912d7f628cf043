//! A person's credentials in their data export, without the secrets.

use model::auth::federation::IdentityOrigin;
use model::{Moment, PersonKey};
use serde::Serialize;
use sqlx::FromRow;

use super::{Pool, Result};
use crate::auth::federation::identities;
use crate::auth::federation::identities::Identity;
use crate::auth::passkeys::KeptPasskey;
use crate::auth::{passkeys, second_factors};

/// Credentials other than the password.
#[derive(Clone, Debug, Serialize)]
pub struct AccessFacts {
    second_factor_since: Option<Moment>,
    recovery_codes_left: i64,
    passkeys: Vec<PasskeyFacts>,
    identities: Vec<IdentityFacts>,
    tokens: Vec<TokenFacts>,
}

/// An API token.
#[derive(Clone, Debug, Serialize, FromRow)]
pub struct TokenFacts {
    name: Option<String>,
    created_at: Moment,
    last_used_at: Option<Moment>,
    expires_at: Option<Moment>,
    revoked_at: Option<Moment>,
}

/// A passkey. Its public key is left out, because the person has no use for it.
#[derive(Clone, Debug, Serialize)]
pub struct PasskeyFacts {
    name: String,
    made_at: Moment,
    last_used_at: Option<Moment>,
}

impl PasskeyFacts {
    fn of(kept: KeptPasskey) -> Self {
        Self { name: kept.name, made_at: kept.made_at, last_used_at: kept.last_used_at }
    }
}

/// An account at a provider.
#[derive(Clone, Debug, Serialize)]
pub struct IdentityFacts {
    issuer: String,
    subject: String,
    how: IdentityOrigin,
    made_at: Moment,
    last_used_at: Option<Moment>,
}

impl IdentityFacts {
    fn of(kept: Identity) -> Self {
        let Identity { issuer, subject, how, made_at, last_used_at, .. } = kept;
        Self { issuer, subject, how, made_at, last_used_at }
    }
}

pub(super) async fn of(reader: &Pool, key: PersonKey) -> Result<AccessFacts> {
    let tokens = sqlx::query_as(
        "SELECT name, created_at, last_seen_at AS last_used_at, expires_at, revoked_at FROM api_tokens
         WHERE person_id = $1 AND school_id = $2 ORDER BY created_at, id",
    );
    Ok(AccessFacts {
        second_factor_since: second_factors::find_second_factor(reader, key)
            .await?
            .and_then(|factor| factor.confirmed_at),
        recovery_codes_left: second_factors::recovery_codes_left(reader, key).await?,
        passkeys: passkeys::list_passkeys(reader, key).await?.into_iter().map(PasskeyFacts::of).collect(),
        identities: identities::list_identities(reader, key).await?.into_iter().map(IdentityFacts::of).collect(),
        tokens: tokens.bind(key.person_id).bind(key.school_id).fetch_all(reader).await?,
    })
}
