//! Single-use links for setting a password. Only the hash of each token is stored.

use model::Moment;
use model::ids::{PersonId, SchoolId};
use model::people::email::normalize_email;
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// Purpose of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, sqlx::Type)]
#[sqlx(type_name = "text", rename_all = "lowercase")]
pub enum Purpose {
    /// Setting the first password.
    Invitation,
    /// Replacing a password.
    Reset,
}

crate::engine::read_natively!(Text: Purpose);

/// A valid link.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct AccountLink {
    /// School of the person.
    pub school_id: SchoolId,
    /// Person whose password the link sets.
    pub person_id: PersonId,
    /// Purpose of the link.
    pub purpose: Purpose,
    /// The person's name.
    pub name: String,
    /// The person's email address.
    pub email: String,
    /// Name of the school.
    pub school: String,
}

/// A link to be stored.
#[derive(Clone, Copy, Debug)]
pub struct NewLink {
    /// School of the person.
    pub school_id: SchoolId,
    /// Person whose password the link sets.
    pub person_id: PersonId,
    /// Purpose of the link.
    pub purpose: Purpose,
    /// Expiry time.
    pub expires_at: Moment,
}

/// Deletes all links of a person for one purpose.
pub async fn end_links_for(writer: &mut Connection, person: PersonId, purpose: Purpose) -> Result<()> {
    sqlx::query("DELETE FROM account_links WHERE person_id = $1 AND purpose = $2")
        .bind(person)
        .bind(purpose)
        .execute(writer)
        .await
        .map(drop)
}

/// Stores the hash of a new link. Existing links stay valid.
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

/// Returns whether a person has a link for this purpose that expires after `until`.
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

/// Returns the link with this hash, if it has not expired and the person's account is not disabled.
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

/// Deletes all password, recording and calendar links of a person, and their sign-in code for stations. It is
/// called on every change of the email address or the password, so that a holder of the old one
/// loses access.
pub(crate) async fn end_account_links(writer: &mut Connection, person: PersonId) -> Result<()> {
    for statement in [
        "DELETE FROM account_links WHERE person_id = $1",
        "DELETE FROM sign_in_codes WHERE person_id = $1",
        "DELETE FROM calendar_feeds WHERE person_id = $1",
        "DELETE FROM recording_links WHERE made_by = $1",
    ] {
        sqlx::query(statement).bind(person).execute(&mut *writer).await?;
    }
    Ok(())
}

/// Longest email address for which a link can be requested, in bytes: the limit for mail.
const LONGEST_ADDRESS: usize = 254;

/// Queues a request for a password link. An address longer than 254 bytes is stored as an empty
/// string, which matches no account.
pub async fn ask_for_link(writer: &mut Connection, email: &str, now: Moment) -> Result<()> {
    let kept = if email.len() > LONGEST_ADDRESS { "" } else { email };
    sqlx::query("INSERT INTO asked_links (email, asked_at) VALUES ($1, $2) ON CONFLICT (email) DO NOTHING")
        .bind(normalize_email(kept))
        .bind(now)
        .execute(writer)
        .await
        .map(drop)
}

/// Returns the email address of the oldest request for a link.
pub async fn find_next_asked_link(executor: impl Executor<'_>) -> Result<Option<String>> {
    sqlx::query_scalar("SELECT email FROM asked_links ORDER BY asked_at, email LIMIT 1").fetch_optional(executor).await
}

/// Deletes the request for a link.
pub async fn forget_asked(writer: &mut Connection, email: &str) -> Result<()> {
    sqlx::query("DELETE FROM asked_links WHERE email = $1").bind(email).execute(writer).await.map(drop)
}

/// Deletes expired links.
pub async fn forget_expired(writer: &mut Connection, now: Moment) -> Result<()> {
    sqlx::query("DELETE FROM account_links WHERE expires_at <= $1").bind(now).execute(writer).await.map(drop)
}
