//! Links by which somebody sets their password, once: only their hashes are here.

use model::Moment;
use model::email::normalize_email;
use model::ids::{PersonId, SchoolId};
use sqlx::FromRow;

use super::{Connection, Executor, Result};

/// What a link is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, sqlx::Type)]
#[sqlx(type_name = "text", rename_all = "lowercase")]
pub enum Purpose {
    /// A first password.
    Invitation,
    /// Another one.
    Reset,
}

/// A link that is good.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct AccountLink {
    /// School.
    pub school_id: SchoolId,
    /// Whose password it sets.
    pub person_id: PersonId,
    /// What it is for.
    pub purpose: Purpose,
    /// Their name.
    pub name: String,
    /// Their address.
    pub email: String,
    /// Their school's name.
    pub school: String,
}

/// Whose link, for what, and how long.
#[derive(Clone, Copy, Debug)]
pub struct NewLink {
    /// School.
    pub school_id: SchoolId,
    /// Whose password it sets.
    pub person_id: PersonId,
    /// What it is for.
    pub purpose: Purpose,
    /// Until when.
    pub expires_at: Moment,
}

/// Ends every link of a person for a purpose.
pub async fn end_links_for(writer: &mut Connection, person: PersonId, purpose: Purpose) -> Result<()> {
    sqlx::query("DELETE FROM account_links WHERE person_id = $1 AND purpose = $2")
        .bind(person)
        .bind(purpose)
        .execute(writer)
        .await
        .map(drop)
}

/// Keeps the hash of a new link, beside those that there are.
pub async fn add_account_link(writer: &mut Connection, link: NewLink, token_sha256: &[u8; 32]) -> Result<()> {
    sqlx::query(
        "INSERT INTO account_links (token_sha256, school_id, person_id, purpose, expires_at) VALUES ($1, $2, $3, $4, $5)",
    )
    .bind(token_sha256.as_slice())
    .bind(link.school_id)
    .bind(link.person_id)
    .bind(link.purpose)
    .bind(link.expires_at)
    .execute(writer)
    .await
    .map(drop)
}

/// Whether somebody has a link for this that is good for longer than until then.
pub async fn count_lasting_links(
    executor: impl Executor<'_>,
    person: PersonId,
    purpose: Purpose,
    until: Moment,
) -> Result<bool> {
    sqlx::query_scalar(
        "SELECT EXISTS (SELECT 1 FROM account_links WHERE person_id = $1 AND purpose = $2 AND expires_at > $3)",
    )
    .bind(person)
    .bind(purpose)
    .bind(until)
    .fetch_one(executor)
    .await
}

/// The link with this hash, if it is good now and its person may sign in.
pub async fn find_valid_link(
    executor: impl Executor<'_>,
    token_sha256: &[u8; 32],
    now: Moment,
) -> Result<Option<AccountLink>> {
    sqlx::query_as(
        "SELECT l.school_id, l.person_id, l.purpose, p.display_name AS name, p.email, s.name AS school
         FROM account_links l JOIN people p ON p.id = l.person_id JOIN schools s ON s.id = l.school_id
         WHERE l.token_sha256 = $1 AND l.expires_at > $2 AND p.disabled_at IS NULL",
    )
    .bind(token_sha256.as_slice())
    .bind(now)
    .fetch_optional(executor)
    .await
}

/// Ends every link of a person, to a password or to a recording, and their code at stations. Whatever changes the address or
/// the password calls it: who had the old one has nothing any more.
pub(super) async fn end_account_links(writer: &mut Connection, person: PersonId) -> Result<()> {
    for statement in [
        "DELETE FROM account_links WHERE person_id = $1",
        "DELETE FROM sign_in_codes WHERE person_id = $1",
        "DELETE FROM recording_links WHERE made_by = $1",
    ] {
        sqlx::query(statement).bind(person).execute(&mut *writer).await?;
    }
    Ok(())
}

/// Longest address that a link is asked for by, in bytes, as mail has it.
const LONGEST_ADDRESS: usize = 254;

/// Notes an address that a link is asked for by. What can be nobody's is not kept.
pub async fn ask_for_link(writer: &mut Connection, email: &str, now: Moment) -> Result<()> {
    let kept = if email.len() > LONGEST_ADDRESS { "" } else { email };
    sqlx::query("INSERT INTO asked_links (email, asked_at) VALUES ($1, $2) ON CONFLICT (email) DO NOTHING")
        .bind(normalize_email(kept))
        .bind(now)
        .execute(writer)
        .await
        .map(drop)
}

/// An address that a link is asked for by, the oldest first.
pub async fn find_next_asked_link(executor: impl Executor<'_>) -> Result<Option<String>> {
    sqlx::query_scalar("SELECT email FROM asked_links ORDER BY asked_at, email LIMIT 1").fetch_optional(executor).await
}

/// Forgets that a link was asked for.
pub async fn forget_asked(writer: &mut Connection, email: &str) -> Result<()> {
    sqlx::query("DELETE FROM asked_links WHERE email = $1").bind(email).execute(writer).await.map(drop)
}

/// Throws away what has expired.
pub async fn forget_expired(writer: &mut Connection, now: Moment) -> Result<()> {
    sqlx::query("DELETE FROM account_links WHERE expires_at <= $1").bind(now).execute(writer).await.map(drop)
}
