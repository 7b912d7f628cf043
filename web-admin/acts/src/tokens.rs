//! Tokens for programs of one's own: made with a name and an end, shown once, revoked.

use model::ids::TokenId;
use model::limits::{LONGEST_NAME, TOKEN_LIFETIMES_DAYS};
use model::{CurrentPerson, Moment, line};
use serde_json::json;
use store::audit::AuditEntry;
use store::tokens::{self, NewToken};

use crate::error::Error;
use crate::secret;
use crate::service::Service;

/// Longest that one made on the command line may last, in days.
pub const LONGEST_DAYS: i64 = 365;
/// Most tokens that somebody has at once.
const MOST: usize = 50;
const DAY_S: i64 = 86_400;

/// A token that is asked for.
#[derive(Clone, Copy, Debug)]
pub struct TokenRequest<'a> {
    /// What it is to be called.
    pub name: &'a str,
    /// How long it is to last, in days.
    pub days: i64,
}

/// A token that was made.
#[derive(Clone, Debug)]
pub struct NewTokenSecret {
    /// The token, which nobody sees again.
    pub token: String,
    /// What it is called.
    pub name: String,
    /// When it ends.
    pub expires_at: Moment,
}

/// A name as it was typed, without spaces around it.
///
/// # Errors
/// When it is empty, too long, or no line.
pub fn checked_name(given: &str) -> Result<String, Error> {
    let name = given.trim();
    let count = name.chars().count();
    if count == 0 || count > LONGEST_NAME {
        let why = tr!("name: {count} characters; allowed: 1 to {most}", count = count, most = LONGEST_NAME);
        return Err(Error::Unprocessable(why));
    }
    match line::refusal(tr!("name"), name) {
        Some(why) => Err(Error::Unprocessable(why)),
        None => Ok(name.to_owned()),
    }
}

/// When a token ends that is made now.
#[must_use]
pub const fn end(now: Moment, days: i64) -> Moment {
    now.plus_s(days * DAY_S)
}

/// Makes a token.
///
/// # Errors
/// When the name or the time is not allowed, there are too many, or the database fails.
pub async fn make(state: &Service, person: &CurrentPerson, wanted: TokenRequest<'_>) -> Result<NewTokenSecret, Error> {
    let name = checked_name(wanted.name)?;
    if !TOKEN_LIFETIMES_DAYS.contains(&wanted.days) {
        let allowed = TOKEN_LIFETIMES_DAYS.map(|days| days.to_string()).join(", ");
        return Err(Error::BadRequest(format!("days: {}; allowed are {allowed}", wanted.days)));
    }
    let (now, token) = (state.clock.now(), secret::random_hex()?);
    let expires_at = end(now, wanted.days);
    let mut tx = state.db.write().await?;
    if tokens::list_tokens_of_person(&mut *tx, person.into()).await?.len() >= MOST {
        let why = tr!("there are {most} tokens, the most allowed: revoke one that is not used", most = MOST);
        return Err(Error::Unprocessable(why));
    }
    let new = NewToken { owner: person.into(), name: &name, expires_at };
    let id = tokens::add_personal_token(&mut tx, new, &secret::token_sha256(&token), now).await?;
    let details = json!({ "person": person.id, "expires_at": expires_at });
    AuditEntry::by(person, "token.made", id).with(details).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(NewTokenSecret { token, name, expires_at })
}

/// Revokes one's own token. False where there is none.
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
