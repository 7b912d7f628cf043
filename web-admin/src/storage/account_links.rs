//! Links by which somebody sets their password, once: only their hashes are here.

use sqlx::{FromRow, SqliteConnection, SqliteExecutor};
use uuid::Uuid;

use super::Result;
use crate::domain::Moment;

/// What a link is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, sqlx::Type)]
#[sqlx(rename_all = "lowercase")]
pub enum Purpose {
    /// A first password.
    Invitation,
    /// Another one.
    Reset,
}

/// A link that is good.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Link {
    /// School.
    pub school_id: Uuid,
    /// Whose password it sets.
    pub person_id: Uuid,
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
    pub school_id: Uuid,
    /// Whose password it sets.
    pub person_id: Uuid,
    /// What it is for.
    pub purpose: Purpose,
    /// Until when.
    pub expires_at: Moment,
}

/// Keeps the hash of a new link. Earlier ones of the person for the same purpose are good no more.
///
/// # Errors
/// When the database fails.
pub async fn add(writer: &mut SqliteConnection, link: NewLink, token_sha256: &[u8; 32]) -> Result<()> {
    sqlx::query("DELETE FROM account_links WHERE person_id = $1 AND purpose = $2")
        .bind(link.person_id)
        .bind(link.purpose)
        .execute(&mut *writer)
        .await?;
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

/// The link with this hash, if it is good now and its person may sign in.
///
/// # Errors
/// When the database fails.
pub async fn valid(executor: impl SqliteExecutor<'_>, token_sha256: &[u8; 32], now: Moment) -> Result<Option<Link>> {
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

/// Ends every link of a person.
///
/// # Errors
/// When the database fails.
pub async fn end_all(writer: &mut SqliteConnection, person: Uuid) -> Result<()> {
    sqlx::query("DELETE FROM account_links WHERE person_id = $1").bind(person).execute(writer).await.map(drop)
}

/// Throws away what has expired.
///
/// # Errors
/// When the database fails.
pub async fn forget_expired(writer: &mut SqliteConnection, now: Moment) -> Result<()> {
    sqlx::query("DELETE FROM account_links WHERE expires_at <= $1").bind(now).execute(writer).await.map(drop)
}
