//! Courses of learning platforms, and their links to this service, as launches describe them.

use model::Moment;
use model::auth::lti::{Launch, LaunchContext};
use model::ids::{CohortId, PlatformContextId, PlatformId, PlatformLinkId, SchoolId};
use sqlx::FromRow;

use super::platforms::Platform;
use crate::{Connection, Executor, Result};

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

/// Adds the link of a launch and its course, or updates them. The deployment must be known. A line item
/// that was found earlier is kept if the launch has none.
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
           context_id = excluded.context_id, page = excluded.page,
           lineitem_url = coalesce(excluded.lineitem_url,
             CASE WHEN platform_links.page = excluded.page THEN platform_links.lineitem_url END)",
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

/// A course of a learning platform.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct PlatformCourse {
    /// Id.
    pub id: PlatformContextId,
    /// Id at the platform.
    pub context_id: String,
    /// Title.
    pub title: Option<String>,
    /// Address of its members.
    pub members_url: Option<String>,
    /// Time of the last launch.
    pub seen_at: Moment,
    /// The cohort that it is tied to.
    pub cohort_id: Option<CohortId>,
    /// Name of that cohort.
    pub cohort: Option<String>,
    /// When the members were last compared with the cohort.
    pub checked_at: Option<Moment>,
    /// Number of differences then; `None` if the members could not be read.
    pub differences: Option<i64>,
}

macro_rules! select_courses {
    ($rest:literal) => {
        concat!(
            "SELECT c.id, c.context_id, c.title, c.members_url, c.seen_at, t.cohort_id, k.name AS cohort,
               t.checked_at, t.differences
             FROM platform_contexts c
             LEFT JOIN platform_context_cohorts t ON t.school_id = c.school_id AND t.context_id = c.id
             LEFT JOIN cohorts k ON k.school_id = t.school_id AND k.id = t.cohort_id ",
            $rest
        )
    };
}

/// Returns the courses of a learning platform, the last launched first; at most `most`.
pub async fn list_courses(
    executor: impl Executor<'_>,
    school: SchoolId,
    platform: PlatformId,
    most: u32,
) -> Result<Vec<PlatformCourse>> {
    sqlx::query_as(select_courses!(
        "WHERE c.school_id = $1 AND c.platform_id = $2 ORDER BY c.seen_at DESC, c.id LIMIT $3 + 0"
    ))
    .bind(school)
    .bind(platform)
    .bind(i64::from(most))
    .fetch_all(executor)
    .await
}

/// Names a course of a learning platform of a school.
#[derive(Clone, Copy, Debug, FromRow)]
pub struct CourseKey {
    /// School.
    pub school_id: SchoolId,
    /// Learning platform.
    pub platform_id: PlatformId,
    /// Course.
    pub course_id: PlatformContextId,
}

/// Returns a course of a learning platform.
pub async fn find_course(executor: impl Executor<'_>, key: CourseKey) -> Result<Option<PlatformCourse>> {
    sqlx::query_as(select_courses!("WHERE c.school_id = $1 AND c.platform_id = $2 AND c.id = $3"))
        .bind(key.school_id)
        .bind(key.platform_id)
        .bind(key.course_id)
        .fetch_optional(executor)
        .await
}

/// Ties a course to a cohort of the school, or to none.
pub async fn tie_course(writer: &mut Connection, key: CourseKey, cohort: Option<CohortId>, now: Moment) -> Result<()> {
    let Some(cohort) = cohort else {
        return sqlx::query("DELETE FROM platform_context_cohorts WHERE school_id = $1 AND context_id = $2")
            .bind(key.school_id)
            .bind(key.course_id)
            .execute(writer)
            .await
            .map(drop);
    };
    sqlx::query(
        "INSERT INTO platform_context_cohorts (context_id, school_id, cohort_id, tied_at) VALUES ($1, $2, $3, $4)
         ON CONFLICT (context_id) DO UPDATE SET cohort_id = excluded.cohort_id, tied_at = excluded.tied_at,
           checked_at = NULL, differences = NULL
         WHERE platform_context_cohorts.school_id = excluded.school_id",
    )
    .bind(key.course_id)
    .bind(key.school_id)
    .bind(cohort)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns courses whose members can be compared with a cohort and were not since a moment.
pub async fn list_unchecked_courses(executor: impl Executor<'_>, since: Moment, most: u32) -> Result<Vec<CourseKey>> {
    sqlx::query_as(
        "SELECT c.school_id, c.platform_id, c.id AS course_id
         FROM platform_context_cohorts t
         JOIN platform_contexts c ON c.school_id = t.school_id AND c.id = t.context_id
         JOIN platforms p ON p.school_id = c.school_id AND p.id = c.platform_id
         WHERE p.disabled_at IS NULL AND c.members_url IS NOT NULL AND coalesce(t.checked_at, 0) < $1
         ORDER BY coalesce(t.checked_at, 0), t.context_id LIMIT $2 + 0",
    )
    .bind(since)
    .bind(i64::from(most))
    .fetch_all(executor)
    .await
}

/// Records a comparison of a course's members with its cohort.
pub async fn note_check(
    writer: &mut Connection,
    key: CourseKey,
    differences: Option<usize>,
    now: Moment,
) -> Result<()> {
    sqlx::query(
        "UPDATE platform_context_cohorts SET checked_at = $3, differences = $4 WHERE school_id = $1 AND context_id = $2",
    )
    .bind(key.school_id)
    .bind(key.course_id)
    .bind(now)
    .bind(differences.map(|count| count as i64))
    .execute(writer)
    .await
    .map(drop)
}

/// Forgets the comparisons with a cohort whose members have changed.
pub async fn forget_checks(writer: &mut Connection, school: SchoolId, cohort: CohortId) -> Result<()> {
    sqlx::query(
        "UPDATE platform_context_cohorts SET checked_at = NULL, differences = NULL WHERE school_id = $1 AND cohort_id = $2",
    )
    .bind(school)
    .bind(cohort)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the link of a launch.
pub async fn find_link(
    executor: impl Executor<'_>,
    platform: &Platform,
    launch: &Launch,
) -> Result<Option<PlatformLinkId>> {
    sqlx::query_scalar(
        "SELECT id FROM platform_links
         WHERE school_id = $1 AND platform_id = $2 AND deployment_id = $3 AND resource_link_id = $4",
    )
    .bind(platform.school_id)
    .bind(platform.id)
    .bind(&launch.deployment)
    .bind(&launch.link)
    .fetch_optional(executor)
    .await
}

/// Sets the line item of a link.
pub async fn set_line_item(
    writer: &mut Connection,
    school: SchoolId,
    link: PlatformLinkId,
    line_item: &str,
) -> Result<()> {
    sqlx::query("UPDATE platform_links SET lineitem_url = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(link)
        .bind(line_item)
        .execute(writer)
        .await
        .map(drop)
}
