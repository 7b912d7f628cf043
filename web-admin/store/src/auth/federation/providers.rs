//! Providers of a school, and their documents.

use model::Moment;
use model::auth::federation::{ClientAuthentication, LocalPasswords, ProviderSettings, RoleMap};
use model::ids::{ProviderId, SchoolId};
use sqlx::FromRow;

use crate::{Connection, Executor, Json, Result};

/// A provider.
#[derive(Clone, Debug)]
pub struct SignInProvider {
    /// Id.
    pub id: ProviderId,
    /// School.
    pub school_id: SchoolId,
    /// Settings.
    pub settings: ProviderSettings,
    /// The secret of this service at the provider, encrypted; empty if it authenticates by its key.
    pub sealed_secret: Vec<u8>,
    /// When it was disabled.
    pub disabled_at: Option<Moment>,
}

#[derive(FromRow)]
struct ProviderRow {
    id: ProviderId,
    school_id: SchoolId,
    name: String,
    issuer: String,
    client_id: String,
    client_secret_sealed: Vec<u8>,
    scopes: String,
    subject_claim: String,
    match_claim: Option<String>,
    addresses_verified: bool,
    second_factor_trusted: bool,
    second_factor_acr: Json<Vec<String>>,
    creates: Option<String>,
    role_claim: Option<String>,
    role_map: Json<RoleMap>,
    disabled_at: Option<Moment>,
}

impl From<ProviderRow> for SignInProvider {
    fn from(row: ProviderRow) -> Self {
        let authentication = match row.client_secret_sealed.is_empty() {
            true => ClientAuthentication::Key,
            false => ClientAuthentication::Secret,
        };
        Self {
            id: row.id,
            school_id: row.school_id,
            settings: ProviderSettings {
                name: row.name,
                issuer: row.issuer,
                client_id: row.client_id,
                authentication,
                scopes: row.scopes,
                subject_claim: row.subject_claim,
                match_claim: row.match_claim,
                addresses_verified: row.addresses_verified,
                second_factor_trusted: row.second_factor_trusted,
                second_factor_acr: row.second_factor_acr.0,
                creates_trainees: row.creates.is_some(),
                role_claim: row.role_claim,
                role_map: row.role_map.0,
            },
            sealed_secret: row.client_secret_sealed,
            disabled_at: row.disabled_at,
        }
    }
}

macro_rules! select_providers {
    ($rest:literal) => {
        concat!(
            "SELECT id, school_id, name, issuer, client_id, client_secret_sealed, scopes, subject_claim, match_claim,
               addresses_verified, second_factor_trusted, second_factor_acr, creates, role_claim, role_map, disabled_at
             FROM sign_in_providers ",
            $rest
        )
    };
}

/// Returns the providers of a school, by name.
pub async fn list_providers(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<SignInProvider>> {
    let rows: Vec<ProviderRow> = sqlx::query_as(select_providers!("WHERE school_id = $1 ORDER BY name, id"))
        .bind(school)
        .fetch_all(executor)
        .await?;
    Ok(rows.into_iter().map(SignInProvider::from).collect())
}

/// Returns a provider of a school.
pub async fn find_provider(
    executor: impl Executor<'_>,
    school: SchoolId,
    id: ProviderId,
) -> Result<Option<SignInProvider>> {
    let row: Option<ProviderRow> = sqlx::query_as(select_providers!("WHERE school_id = $1 AND id = $2"))
        .bind(school)
        .bind(id)
        .fetch_optional(executor)
        .await?;
    Ok(row.map(SignInProvider::from))
}

/// Returns a provider of any school, for anonymous visitors.
pub async fn find_provider_of_any_school(
    executor: impl Executor<'_>,
    id: ProviderId,
) -> Result<Option<SignInProvider>> {
    let row: Option<ProviderRow> =
        sqlx::query_as(select_providers!("WHERE id = $1")).bind(id).fetch_optional(executor).await?;
    Ok(row.map(SignInProvider::from))
}

/// A provider on the sign-in page.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct OfferedProvider {
    /// Id.
    pub id: ProviderId,
    /// Name of the provider.
    pub name: String,
    /// School.
    pub school: String,
    /// Who may sign in with a password at that school.
    pub local_passwords: LocalPasswords,
}

/// Returns the enabled providers of all schools, or of the one with a name, by school and name; at
/// most `most`.
pub async fn list_offered_providers(
    executor: impl Executor<'_>,
    school: Option<&str>,
    most: u32,
) -> Result<Vec<OfferedProvider>> {
    sqlx::query_as(
        "SELECT v.id, v.name, s.name AS school, s.local_passwords
         FROM sign_in_providers v JOIN schools s ON s.id = v.school_id
         WHERE v.disabled_at IS NULL AND ($1 IS NULL OR s.name = $1) ORDER BY s.name, v.name, v.id LIMIT $2 + 0",
    )
    .bind(school)
    .bind(i64::from(most))
    .fetch_all(executor)
    .await
}

/// A provider to be stored.
#[derive(Clone, Copy, Debug)]
pub struct NewProvider<'a> {
    /// Id.
    pub id: ProviderId,
    /// School.
    pub school_id: SchoolId,
    /// Settings.
    pub settings: &'a ProviderSettings,
    /// The secret of this service at the provider, encrypted; empty if it authenticates by its key.
    pub sealed_secret: &'a [u8],
}

/// Stores a provider, or replaces its settings. Returns false if the school has another one with
/// the same issuer and client id.
pub async fn put_provider(writer: &mut Connection, new: NewProvider<'_>, now: Moment) -> Result<bool> {
    let settings = new.settings;
    let is_taken: bool = sqlx::query_scalar(
        "SELECT EXISTS (SELECT 1 FROM sign_in_providers
                        WHERE school_id = $1 AND issuer = $2 AND client_id = $3 AND id <> $4)",
    )
    .bind(new.school_id)
    .bind(&settings.issuer)
    .bind(&settings.client_id)
    .bind(new.id)
    .fetch_one(&mut *writer)
    .await?;
    if is_taken {
        return Ok(false);
    }
    sqlx::query(
        "INSERT INTO sign_in_providers (id, school_id, name, issuer, client_id, client_secret_sealed, scopes, subject_claim,
           match_claim, addresses_verified, second_factor_trusted, creates, role_claim, role_map, made_at,
           second_factor_acr)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16)
         ON CONFLICT (id) DO UPDATE SET name = excluded.name, issuer = excluded.issuer, client_id = excluded.client_id,
           client_secret_sealed = excluded.client_secret_sealed, scopes = excluded.scopes,
           subject_claim = excluded.subject_claim, match_claim = excluded.match_claim,
           addresses_verified = excluded.addresses_verified, second_factor_trusted = excluded.second_factor_trusted,
           creates = excluded.creates, role_claim = excluded.role_claim, role_map = excluded.role_map,
           second_factor_acr = excluded.second_factor_acr
         WHERE sign_in_providers.school_id = excluded.school_id",
    )
    .bind(new.id)
    .bind(new.school_id)
    .bind(&settings.name)
    .bind(&settings.issuer)
    .bind(&settings.client_id)
    .bind(new.sealed_secret)
    .bind(&settings.scopes)
    .bind(&settings.subject_claim)
    .bind(&settings.match_claim)
    .bind(settings.addresses_verified)
    .bind(settings.second_factor_trusted)
    .bind(settings.creates_trainees.then_some("trainee"))
    .bind(&settings.role_claim)
    .bind(Json(&settings.role_map))
    .bind(now)
    .bind(Json(&settings.second_factor_acr))
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Disables a provider, or enables it again. Returns false if it does not exist or is in this state
/// already.
pub async fn set_provider_disabled(
    writer: &mut Connection,
    school: SchoolId,
    id: ProviderId,
    disabled_at: Option<Moment>,
) -> Result<bool> {
    sqlx::query(
        "UPDATE sign_in_providers SET disabled_at = $3
         WHERE school_id = $1 AND id = $2 AND (disabled_at IS NULL) <> ($3 IS NULL)",
    )
    .bind(school)
    .bind(id)
    .bind(disabled_at)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Returns who may sign in with a password at a school.
///
/// # Errors
/// If there is no such school, or the database fails.
pub async fn find_local_passwords(executor: impl Executor<'_>, school: SchoolId) -> Result<LocalPasswords> {
    sqlx::query_scalar("SELECT local_passwords FROM schools WHERE id = $1").bind(school).fetch_one(executor).await
}

/// Sets who may sign in with a password at a school.
pub async fn set_local_passwords(writer: &mut Connection, school: SchoolId, rule: LocalPasswords) -> Result<()> {
    sqlx::query("UPDATE schools SET local_passwords = $2 WHERE id = $1")
        .bind(school)
        .bind(rule)
        .execute(writer)
        .await
        .map(drop)
}

/// A document of a provider, as fetched.
#[derive(Clone, Debug, FromRow)]
pub struct ProviderDocument {
    /// The document.
    pub body: String,
    /// Time of the fetch.
    pub fetched_at: Moment,
}

/// Returns the last document fetched from an address.
pub async fn find_document(executor: impl Executor<'_>, url_sha256: &[u8; 32]) -> Result<Option<ProviderDocument>> {
    sqlx::query_as("SELECT body, fetched_at FROM provider_documents WHERE url_sha256 = $1")
        .bind(url_sha256.as_slice())
        .fetch_optional(executor)
        .await
}

/// Stores the document fetched from an address.
pub async fn put_document(
    writer: &mut Connection,
    url: &str,
    url_sha256: &[u8; 32],
    document: &ProviderDocument,
) -> Result<()> {
    sqlx::query(
        "INSERT INTO provider_documents (url_sha256, url, body, fetched_at) VALUES ($1, $2, $3, $4)
         ON CONFLICT (url_sha256) DO UPDATE SET body = excluded.body, fetched_at = excluded.fetched_at",
    )
    .bind(url_sha256.as_slice())
    .bind(url)
    .bind(&document.body)
    .bind(document.fetched_at)
    .execute(writer)
    .await
    .map(drop)
}
