//! Learning platforms of a school, and their deployments.

use model::Moment;
use model::auth::lti::{NumberClaim, PlatformSettings};
use model::ids::{PlatformId, SchoolId};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// A learning platform.
#[derive(Clone, Debug)]
pub struct Platform {
    /// Id.
    pub id: PlatformId,
    /// School.
    pub school_id: SchoolId,
    /// Settings.
    pub settings: PlatformSettings,
    /// When it was disabled.
    pub disabled_at: Option<Moment>,
}

#[derive(FromRow)]
struct PlatformRow {
    id: PlatformId,
    school_id: SchoolId,
    name: String,
    issuer: String,
    client_id: String,
    auth_url: String,
    token_url: String,
    keys_url: String,
    token_audience: Option<String>,
    number_claim: Option<NumberClaim>,
    creates: Option<String>,
    disabled_at: Option<Moment>,
}

impl From<PlatformRow> for Platform {
    fn from(row: PlatformRow) -> Self {
        Self {
            id: row.id,
            school_id: row.school_id,
            settings: PlatformSettings {
                name: row.name,
                issuer: row.issuer,
                client_id: row.client_id,
                auth_url: row.auth_url,
                token_url: row.token_url,
                keys_url: row.keys_url,
                token_audience: row.token_audience,
                number_claim: row.number_claim,
                creates_trainees: row.creates.is_some(),
            },
            disabled_at: row.disabled_at,
        }
    }
}

macro_rules! select_platforms {
    ($rest:literal) => {
        concat!(
            "SELECT id, school_id, name, issuer, client_id, auth_url, token_url, keys_url, token_audience, number_claim,
               creates, disabled_at
             FROM platforms ",
            $rest
        )
    };
}

/// Returns the learning platforms of a school, by name.
pub async fn list_platforms(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<Platform>> {
    let rows: Vec<PlatformRow> = sqlx::query_as(select_platforms!("WHERE school_id = $1 ORDER BY name, id"))
        .bind(school)
        .fetch_all(executor)
        .await?;
    Ok(rows.into_iter().map(Platform::from).collect())
}

/// Returns a learning platform of a school.
pub async fn find_platform(executor: impl Executor<'_>, school: SchoolId, id: PlatformId) -> Result<Option<Platform>> {
    let row: Option<PlatformRow> = sqlx::query_as(select_platforms!("WHERE school_id = $1 AND id = $2"))
        .bind(school)
        .bind(id)
        .fetch_optional(executor)
        .await?;
    Ok(row.map(Platform::from))
}

/// Returns a learning platform of any school, for anonymous visitors.
pub async fn find_platform_of_any_school(executor: impl Executor<'_>, id: PlatformId) -> Result<Option<Platform>> {
    let row: Option<PlatformRow> =
        sqlx::query_as(select_platforms!("WHERE id = $1")).bind(id).fetch_optional(executor).await?;
    Ok(row.map(Platform::from))
}

/// Returns the enabled learning platforms of all schools with grades to send.
pub async fn list_awaiting_grades(executor: impl Executor<'_>, now: Moment) -> Result<Vec<Platform>> {
    let rows: Vec<PlatformRow> = sqlx::query_as(select_platforms!(
        "WHERE disabled_at IS NULL AND EXISTS (SELECT 1 FROM deliveries d WHERE d.school_id = platforms.school_id
           AND d.platform_id = platforms.id AND d.next_run_at <= $1)"
    ))
    .bind(now)
    .fetch_all(executor)
    .await?;
    Ok(rows.into_iter().map(Platform::from).collect())
}

/// Returns the registration of an issuer with a client id, or its only one if the client id is not
/// known; over all schools.
pub async fn find_registration(
    executor: impl Executor<'_>,
    issuer: &str,
    client_id: Option<&str>,
) -> Result<Option<Platform>> {
    let mut rows: Vec<PlatformRow> =
        sqlx::query_as(select_platforms!("WHERE issuer = $1 AND ($2 IS NULL OR client_id = $2) LIMIT 2"))
            .bind(issuer)
            .bind(client_id)
            .fetch_all(executor)
            .await?;
    let first = rows.pop();
    Ok(first.filter(|_| rows.is_empty()).map(Platform::from))
}

/// A learning platform to be stored.
#[derive(Clone, Copy, Debug)]
pub struct NewPlatform<'a> {
    /// Id.
    pub id: PlatformId,
    /// School.
    pub school_id: SchoolId,
    /// Settings.
    pub settings: &'a PlatformSettings,
}

/// Returns whether a registration with this issuer and client id exists under another id, at any
/// school.
pub async fn is_registered(executor: impl Executor<'_>, new: NewPlatform<'_>) -> Result<bool> {
    sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM platforms WHERE issuer = $1 AND client_id = $2 AND id <> $3)")
        .bind(&new.settings.issuer)
        .bind(&new.settings.client_id)
        .bind(new.id)
        .fetch_one(executor)
        .await
}

/// Adds a learning platform, or changes the one with this id. Returns false if it belongs to another
/// school.
pub async fn put_platform(writer: &mut Connection, new: NewPlatform<'_>, now: Moment) -> Result<bool> {
    let settings = new.settings;
    sqlx::query(
        "INSERT INTO platforms (id, school_id, name, issuer, client_id, auth_url, token_url, keys_url, token_audience,
           number_claim, creates, made_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12)
         ON CONFLICT (id) DO UPDATE SET name = excluded.name, issuer = excluded.issuer, client_id = excluded.client_id,
           auth_url = excluded.auth_url, token_url = excluded.token_url, keys_url = excluded.keys_url,
           token_audience = excluded.token_audience, number_claim = excluded.number_claim, creates = excluded.creates
         WHERE platforms.school_id = excluded.school_id",
    )
    .bind(new.id)
    .bind(new.school_id)
    .bind(&settings.name)
    .bind(&settings.issuer)
    .bind(&settings.client_id)
    .bind(&settings.auth_url)
    .bind(&settings.token_url)
    .bind(&settings.keys_url)
    .bind(&settings.token_audience)
    .bind(settings.number_claim)
    .bind(settings.creates_trainees.then_some("trainee"))
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Disables a learning platform, or enables it again. Returns false if it does not exist or is in
/// this state already.
pub async fn set_platform_disabled(
    writer: &mut Connection,
    school: SchoolId,
    id: PlatformId,
    disabled_at: Option<Moment>,
) -> Result<bool> {
    sqlx::query(
        "UPDATE platforms SET disabled_at = $3
         WHERE school_id = $1 AND id = $2 AND (disabled_at IS NULL) <> ($3 IS NULL)",
    )
    .bind(school)
    .bind(id)
    .bind(disabled_at)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// A deployment of a learning platform.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Deployment {
    /// Id at the platform.
    pub deployment_id: String,
    /// Time of its first launch.
    pub first_seen_at: Moment,
    /// When an administrator has admitted it.
    pub admitted_at: Option<Moment>,
}

/// Returns the deployments of a learning platform, in the order of their first launches.
pub async fn list_deployments(
    executor: impl Executor<'_>,
    school: SchoolId,
    platform: PlatformId,
) -> Result<Vec<Deployment>> {
    sqlx::query_as(
        "SELECT deployment_id, first_seen_at, admitted_at FROM platform_deployments
         WHERE school_id = $1 AND platform_id = $2 ORDER BY first_seen_at, deployment_id",
    )
    .bind(school)
    .bind(platform)
    .fetch_all(executor)
    .await
}

/// Number of deployments of a learning platform that wait to be admitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct WaitingDeployments {
    /// Learning platform.
    pub platform_id: PlatformId,
    /// Number of deployments.
    pub deployments: i64,
}

/// Counts the deployments that wait to be admitted, by learning platform.
pub async fn count_waiting_deployments(
    executor: impl Executor<'_>,
    school: SchoolId,
) -> Result<Vec<WaitingDeployments>> {
    sqlx::query_as(
        "SELECT platform_id, count(*) AS deployments FROM platform_deployments
         WHERE school_id = $1 AND admitted_at IS NULL GROUP BY platform_id",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Returns a deployment of a learning platform.
pub async fn find_deployment(
    executor: impl Executor<'_>,
    platform: PlatformId,
    deployment: &str,
) -> Result<Option<Deployment>> {
    sqlx::query_as(
        "SELECT deployment_id, first_seen_at, admitted_at FROM platform_deployments
         WHERE platform_id = $1 AND deployment_id = $2",
    )
    .bind(platform)
    .bind(deployment)
    .fetch_optional(executor)
    .await
}

/// Stores a deployment that waits to be admitted, unless it is known or `most` are.
pub async fn add_deployment(
    writer: &mut Connection,
    platform: &Platform,
    deployment: &str,
    most: u32,
    now: Moment,
) -> Result<()> {
    sqlx::query(
        "INSERT INTO platform_deployments (platform_id, deployment_id, school_id, first_seen_at)
         SELECT $1, $2, $3, $4 WHERE (SELECT count(*) FROM platform_deployments WHERE school_id = $3 AND platform_id = $1) < $5
         ON CONFLICT DO NOTHING",
    )
    .bind(platform.id)
    .bind(deployment)
    .bind(platform.school_id)
    .bind(now)
    .bind(i64::from(most))
    .execute(writer)
    .await
    .map(drop)
}

/// Admits a deployment that waits. Returns false if none does.
pub async fn admit_deployment(
    writer: &mut Connection,
    school: SchoolId,
    platform: PlatformId,
    deployment: &str,
    now: Moment,
) -> Result<bool> {
    sqlx::query(
        "UPDATE platform_deployments SET admitted_at = $4
         WHERE school_id = $1 AND platform_id = $2 AND deployment_id = $3 AND admitted_at IS NULL",
    )
    .bind(school)
    .bind(platform)
    .bind(deployment)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}
