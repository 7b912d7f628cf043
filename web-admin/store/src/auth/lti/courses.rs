//! Courses of learning platforms, and their links to this service, as launches describe them.

use model::Moment;
use model::auth::lti::{Launch, LaunchContext};
use model::ids::{PlatformContextId, PlatformLinkId};

use super::platforms::Platform;
use crate::{Connection, Result};

/// A deployment of a learning platform.
#[derive(Clone, Copy, Debug)]
pub struct DeployedPlatform<'a> {
    /// The platform.
    pub platform: &'a Platform,
    /// Id of the deployment at the platform.
    pub deployment: &'a str,
}

/// Adds the course of a message, or updates it; returns its id. The deployment must be known.
pub async fn put_context(
    writer: &mut Connection,
    DeployedPlatform { platform, deployment }: DeployedPlatform<'_>,
    context: &LaunchContext,
    now: Moment,
) -> Result<PlatformContextId> {
    sqlx::query_scalar(
        "INSERT INTO platform_contexts (id, school_id, platform_id, deployment_id, context_id, title, members_url,
           lineitems_url, seen_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9)
         ON CONFLICT (school_id, platform_id, deployment_id, context_id) DO UPDATE SET title = excluded.title,
           members_url = excluded.members_url, lineitems_url = excluded.lineitems_url, seen_at = excluded.seen_at
         RETURNING id",
    )
    .bind(PlatformContextId::made_at(now))
    .bind(platform.school_id)
    .bind(platform.id)
    .bind(deployment)
    .bind(&context.id)
    .bind(&context.title)
    .bind(&context.members_url)
    .bind(&context.lineitems_url)
    .bind(now)
    .fetch_one(writer)
    .await
}

/// Adds the link of a launch and its course, or updates them. The deployment must be known.
pub async fn put_launch(writer: &mut Connection, platform: &Platform, launch: &Launch, now: Moment) -> Result<()> {
    let deployed = DeployedPlatform { platform, deployment: &launch.deployment };
    let context = match &launch.context {
        Some(context) => Some(put_context(writer, deployed, context, now).await?),
        None => None,
    };
    sqlx::query(
        "INSERT INTO platform_links (id, school_id, platform_id, deployment_id, context_id, resource_link_id, page,
           lineitem_url, made_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9)
         ON CONFLICT (school_id, platform_id, deployment_id, resource_link_id) DO UPDATE SET
           context_id = excluded.context_id, page = excluded.page, lineitem_url = excluded.lineitem_url",
    )
    .bind(PlatformLinkId::made_at(now))
    .bind(platform.school_id)
    .bind(platform.id)
    .bind(&launch.deployment)
    .bind(context)
    .bind(&launch.link)
    .bind(&launch.page)
    .bind(&launch.lineitem_url)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}
