//! Personal API tokens: created with a name and an expiry, shown once, revocable.

use model::ids::TokenId;
use model::limits::{LONGEST_NAME, TOKEN_LIFETIMES_DAYS};
use model::{CurrentPerson, Moment, single_line_text};
use platform::secret;
use serde_json::json;
use store::audit::AuditEntry;
use store::auth::tokens;
use store::auth::tokens::NewToken;

use crate::error::Error;
use crate::service::Service;

/// Maximum lifetime of a token created on the command line, in days.
pub const LONGEST_DAYS: i64 = 365;
/// Maximum number of tokens per person.
const MOST: usize = 50;
const DAY_S: i64 = 86_400;

/// A token to create.
#[derive(Clone, Copy, Debug)]
pub struct TokenRequest<'a> {
    /// Name.
    pub name: &'a str,
    /// Lifetime, in days.
    pub days: i64,
}

/// A new token.
#[derive(Clone, Debug)]
pub struct NewTokenSecret {
    /// The token; only its hash is stored.
    pub token: String,
    /// Name.
    pub name: String,
    /// Expiry.
    pub expires_at: Moment,
}

/// Checks a token's name and trims it.
///
/// # Errors
/// Fails if it is empty, too long, or not a single line.
pub fn checked_name(given: &str) -> Result<String, Error> {
    let name = given.trim();
    let count = name.chars().count();
    if count == 0 || count > LONGEST_NAME {
        let why = tr!("name: {count} characters; allowed: 1 to {most}", count = count, most = LONGEST_NAME);
        return Err(Error::Unprocessable(why));
    }
    match single_line_text::refusal(tr!("name"), name) {
        Some(why) => Err(Error::Unprocessable(why)),
        None => Ok(name.to_owned()),
    }
}

/// Returns when a token created now expires.
#[must_use]
pub const fn end(now: Moment, days: i64) -> Moment {
    now.plus_s(days * DAY_S)
}

/// Creates a token.
///
/// # Errors
/// Fails if the name or the lifetime is not allowed, there are too many tokens, or the database
/// fails.
pub async fn make(state: &Service, person: &CurrentPerson, wanted: TokenRequest<'_>) -> Result<NewTokenSecret, Error> {
    let name = checked_name(wanted.name)?;
    if !TOKEN_LIFETIMES_DAYS.contains(&wanted.days) {
        let allowed = TOKEN_LIFETIMES_DAYS.map(|days| days.to_string()).join(", ");
        return Err(Error::BadRequest(format!("days: {}; allowed: {allowed}", wanted.days)));
    }
    let (now, token) = (state.clock.now(), secret::random_hex()?);
    let expires_at = end(now, wanted.days);
    let mut tx = state.db.write().await?;
    if tokens::list_tokens_of_person(&mut *tx, person.into()).await?.len() >= MOST {
        let why = tr!(
            "this account already has {most} tokens, the most allowed: revoke one that you no longer use",
            most = MOST
        );
        return Err(Error::Unprocessable(why));
    }
    let new = NewToken { owner: person.into(), name: &name, expires_at };
    let id = tokens::add_personal_token(&mut tx, new, &secret::token_sha256(&token), now).await?;
    let details = json!({ "person": person.id, "expires_at": expires_at });
    AuditEntry::by(person, "token.made", id).with(details).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(NewTokenSecret { token, name, expires_at })
}

/// Revokes a person's own token. Returns false if it does not exist.
pub async fn revoke(state: &Service, person: &CurrentPerson, id: TokenId) -> Result<bool, Error> {
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    let revoked = tokens::revoke_token(&mut tx, person.into(), id, now).await?;
    if revoked {
        AuditEntry::by(person, "token.revoked", id).with(json!({ "person": person.id })).append(&mut tx, now).await?;
    }
    tx.commit().await?;
    Ok(revoked)
}
