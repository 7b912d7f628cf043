//! Choices of content for courses of learning platforms that have not been answered.

use model::auth::deep_linking::{ContentRequest, DeepLinkingRequest};
use model::ids::{ContentChoiceId, PlatformId, SchoolId};
use model::{Moment, PersonKey};
use sqlx::FromRow;

use super::platforms::Platform;
use crate::{Connection, Executor, Result};

/// A choice of content.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ContentChoice {
    /// Learning platform.
    pub platform_id: PlatformId,
    /// Deployment at the platform.
    pub deployment: String,
    /// What the platform accepts.
    pub content: ContentRequest,
}

#[derive(FromRow)]
struct ChoiceRow {
    platform_id: PlatformId,
    deployment_id: String,
    return_url: String,
    data: Option<String>,
    accepts_several: bool,
    accepts_line_items: bool,
}

impl From<ChoiceRow> for ContentChoice {
    fn from(row: ChoiceRow) -> Self {
        Self {
            platform_id: row.platform_id,
            deployment: row.deployment_id,
            content: ContentRequest {
                return_url: row.return_url,
                data: row.data,
                accepts_several: row.accepts_several,
                accepts_line_items: row.accepts_line_items,
            },
        }
    }
}

/// Stores a choice of content, and deletes expired ones. The deployment must be known.
pub async fn add_choice(
    writer: &mut Connection,
    platform: &Platform,
    asked: &DeepLinkingRequest,
    expires_at: Moment,
    now: Moment,
) -> Result<ContentChoiceId> {
    sqlx::query("DELETE FROM content_choices WHERE expires_at < $1").bind(now).execute(&mut *writer).await?;
    let id = ContentChoiceId::made_at(now);
    sqlx::query(
        "INSERT INTO content_choices (id, school_id, platform_id, deployment_id, issuer, subject, return_url, data,
           accepts_several, accepts_line_items, expires_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11)",
    )
    .bind(id)
    .bind(platform.school_id)
    .bind(platform.id)
    .bind(&asked.deployment)
    .bind(&asked.identity.issuer)
    .bind(&asked.identity.subject)
    .bind(&asked.content.return_url)
    .bind(&asked.content.data)
    .bind(asked.content.accepts_several)
    .bind(asked.content.accepts_line_items)
    .bind(expires_at)
    .execute(writer)
    .await?;
    Ok(id)
}

/// Returns a choice of content that has not expired, if an identity of the person has asked for it.
pub async fn find_choice(
    executor: impl Executor<'_>,
    key: PersonKey,
    id: ContentChoiceId,
    now: Moment,
) -> Result<Option<ContentChoice>> {
    let row: Option<ChoiceRow> = sqlx::query_as(
        "SELECT c.platform_id, c.deployment_id, c.return_url, c.data, c.accepts_several, c.accepts_line_items
         FROM content_choices c JOIN identities i ON i.school_id = c.school_id AND i.kind = 'lti'
           AND i.issuer = c.issuer AND i.subject = c.subject
         WHERE c.school_id = $1 AND c.id = $2 AND i.person_id = $3 AND c.expires_at > $4",
    )
    .bind(key.school_id)
    .bind(id)
    .bind(key.person_id)
    .bind(now)
    .fetch_optional(executor)
    .await?;
    Ok(row.map(ContentChoice::from))
}

/// Deletes a choice of content, so that it is answered only once. Returns false if it does not exist.
pub async fn remove_choice(writer: &mut Connection, school: SchoolId, id: ContentChoiceId) -> Result<bool> {
    sqlx::query("DELETE FROM content_choices WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}
