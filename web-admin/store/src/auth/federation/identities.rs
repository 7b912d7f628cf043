//! Accounts at providers and learning platforms that belong to people.

use model::auth::federation::{IdentityKind, IdentityOrigin};
use model::ids::{IdentityId, PersonId, SchoolId};
use model::people::email::normalize_email;
use model::{Moment, PersonKey};
use sqlx::FromRow;

use crate::auth::lti::deliveries;
use crate::{Connection, Executor, Result};

/// An account at a provider or a learning platform.
#[derive(Clone, Debug, FromRow)]
pub struct Identity {
    /// Id.
    pub id: IdentityId,
    /// Issuer identifier of the provider; for a learning platform, with the client id.
    pub issuer: String,
    /// Name of the provider or the platform; `None` if it was changed to another issuer.
    pub provider: Option<String>,
    /// Stable id of the person at the provider.
    pub subject: String,
    /// How it came to belong to the person.
    pub how: IdentityOrigin,
    /// Since when it does.
    pub made_at: Moment,
    /// Time of the last sign-in.
    pub last_used_at: Option<Moment>,
}

/// Id of a person at an issuer.
#[derive(Clone, Copy, Debug)]
pub struct IssuedSubject<'a> {
    /// School.
    pub school_id: SchoolId,
    /// Protocol.
    pub kind: IdentityKind,
    /// Issuer identifier.
    pub issuer: &'a str,
    /// Stable id of the person.
    pub subject: &'a str,
}

/// Returns the identities of a person, oldest first.
pub async fn list_identities(executor: impl Executor<'_>, key: PersonKey) -> Result<Vec<Identity>> {
    sqlx::query_as(
        "SELECT i.id, i.issuer, i.subject, i.how, i.made_at, i.last_used_at,
           CASE i.kind
             WHEN 'lti' THEN (SELECT min(v.name) FROM platforms v WHERE v.school_id = i.school_id AND v.issuer || ' ' || v.client_id = i.issuer)
             ELSE (SELECT min(v.name) FROM sign_in_providers v WHERE v.school_id = i.school_id AND v.issuer = i.issuer)
           END AS provider
         FROM identities i WHERE i.school_id = $1 AND i.person_id = $2 ORDER BY i.made_at, i.id",
    )
    .bind(key.school_id)
    .bind(key.person_id)
    .fetch_all(executor)
    .await
}

/// Returns whether a person can sign in by a provider or a learning platform.
pub async fn has_identity(executor: impl Executor<'_>, key: PersonKey) -> Result<bool> {
    sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM identities WHERE school_id = $1 AND person_id = $2)")
        .bind(key.school_id)
        .bind(key.person_id)
        .fetch_one(executor)
        .await
}

/// Returns the person of an identity, and records its use.
pub async fn use_identity(writer: &mut Connection, of: IssuedSubject<'_>, now: Moment) -> Result<Option<PersonId>> {
    let found: Option<PersonId> = sqlx::query_scalar(
        "SELECT person_id FROM identities WHERE school_id = $1 AND kind = $4 AND issuer = $2 AND subject = $3",
    )
    .bind(of.school_id)
    .bind(of.issuer)
    .bind(of.subject)
    .bind(of.kind)
    .fetch_optional(&mut *writer)
    .await?;
    sqlx::query(
        "UPDATE identities SET last_used_at = $5 WHERE school_id = $1 AND kind = $4 AND issuer = $2 AND subject = $3",
    )
    .bind(of.school_id)
    .bind(of.issuer)
    .bind(of.subject)
    .bind(of.kind)
    .bind(now)
    .execute(writer)
    .await?;
    Ok(found)
}

/// Returns the person with a registration number who has no identity of an issuer.
pub async fn find_unlinked_by_number(
    executor: impl Executor<'_>,
    school: SchoolId,
    issuer: &str,
    number: &str,
) -> Result<Option<PersonId>> {
    sqlx::query_scalar(
        "SELECT p.id FROM people p WHERE p.school_id = $1 AND p.registrar_id = $3 AND p.role <> 'guest' AND p.erased_at IS NULL
         AND NOT EXISTS (SELECT 1 FROM identities i WHERE i.school_id = p.school_id AND i.person_id = p.id AND i.issuer = $2)",
    )
    .bind(school)
    .bind(issuer)
    .bind(number)
    .fetch_optional(executor)
    .await
}

/// Returns the person with an address who has never had a password and no identity of an issuer.
pub async fn find_unlinked_by_email(
    executor: impl Executor<'_>,
    school: SchoolId,
    issuer: &str,
    email: &str,
) -> Result<Option<PersonId>> {
    sqlx::query_scalar(
        "SELECT p.id FROM people p WHERE p.school_id = $1 AND p.email = $3 AND p.password_hash = '' AND p.role <> 'guest' AND p.erased_at IS NULL
         AND NOT EXISTS (SELECT 1 FROM identities i WHERE i.school_id = p.school_id AND i.person_id = p.id AND i.issuer = $2)",
    )
    .bind(school)
    .bind(issuer)
    .bind(normalize_email(email))
    .fetch_optional(executor)
    .await
}

/// An identity to be stored.
#[derive(Clone, Copy, Debug)]
pub struct NewIdentity<'a> {
    /// Id.
    pub id: IdentityId,
    /// Whose it is.
    pub person_id: PersonId,
    /// What it is at the provider.
    pub of: IssuedSubject<'a>,
    /// How it came to belong to the person.
    pub how: IdentityOrigin,
    /// Who has added it; `None` for the sign-in itself.
    pub made_by: Option<PersonId>,
    /// Time.
    pub at: Moment,
}

/// Stores an identity. Returns false if it belongs to a person already.
pub async fn add_identity(writer: &mut Connection, new: NewIdentity<'_>) -> Result<bool> {
    sqlx::query(
        "INSERT INTO identities (id, school_id, person_id, kind, issuer, subject, made_at, made_by, how, last_used_at)
         VALUES ($1, $2, $3, $9, $4, $5, $6, $7, $8, $6) ON CONFLICT DO NOTHING",
    )
    .bind(new.id)
    .bind(new.of.school_id)
    .bind(new.person_id)
    .bind(new.of.issuer)
    .bind(new.of.subject)
    .bind(new.at)
    .bind(new.made_by)
    .bind(new.how)
    .bind(new.of.kind)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Deletes an identity of a person, and its grades for a learning platform. Returns false if it does
/// not exist.
pub async fn remove_identity(writer: &mut Connection, key: PersonKey, id: IdentityId) -> Result<bool> {
    sqlx::query(
        "DELETE FROM deliveries WHERE school_id = $1 AND person_id = $2 AND (platform_id, subject) IN (
           SELECT v.id, i.subject FROM identities i
           JOIN platforms v ON v.school_id = i.school_id AND v.issuer || ' ' || v.client_id = i.issuer
           WHERE i.school_id = $1 AND i.person_id = $2 AND i.id = $3 AND i.kind = 'lti')",
    )
    .bind(key.school_id)
    .bind(key.person_id)
    .bind(id)
    .execute(&mut *writer)
    .await?;
    sqlx::query("DELETE FROM identities WHERE school_id = $1 AND person_id = $2 AND id = $3")
        .bind(key.school_id)
        .bind(key.person_id)
        .bind(id)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Deletes all identities of a person, their grades for learning platforms, and the sign-ins and choices
/// of content that they have begun.
pub async fn remove_identities(writer: &mut Connection, key: PersonKey) -> Result<()> {
    deliveries::remove_deliveries(&mut *writer, key).await?;
    for statement in [
        "DELETE FROM content_choices WHERE school_id = $1 AND EXISTS (SELECT 1 FROM identities i
           WHERE i.school_id = content_choices.school_id AND i.kind = 'lti' AND i.issuer = content_choices.issuer
           AND i.subject = content_choices.subject AND i.person_id = $2)",
        "DELETE FROM identities WHERE school_id = $1 AND person_id = $2",
        "DELETE FROM sign_in_flows WHERE school_id = $1 AND person_id = $2",
        "UPDATE identities SET made_by = NULL WHERE school_id = $1 AND made_by = $2",
    ] {
        sqlx::query(statement).bind(key.school_id).bind(key.person_id).execute(&mut *writer).await?;
    }
    Ok(())
}
