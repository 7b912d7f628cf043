//! Grades for learning platforms, one row for each link and each of its users. A row contains no
//! grade: it is read when it is sent. [`mark_person`] and its siblings run in the transaction that
//! changes a grade.

use model::auth::grade_service::DeliveryState;
use model::ids::{AssignmentId, DeliveryId, PersonId, PlatformId, PlatformLinkId, SchoolId};
use model::{Moment, PersonKey, SessionKey};
use serde_json::Value;
use sqlx::FromRow;

use crate::{Connection, Executor, Json, Result};

/// Updates rows of school `$1` whose grade may have changed; the argument selects them. A stopped
/// row stays so.
macro_rules! mark {
    ($rest:literal) => {
        concat!(
            "UPDATE deliveries SET state = 'waiting', next_run_at = 0, tries = 0, version = version + 1
             WHERE school_id = $1 AND state <> 'stopped' AND ",
            $rest
        )
    };
}

/// Adds the grade of a link's user, or marks it, if the link has grades and the platform takes them.
pub async fn put_delivery(
    writer: &mut Connection,
    link: PlatformLinkId,
    person: PersonKey,
    subject: &str,
    now: Moment,
) -> Result<()> {
    sqlx::query(
        "INSERT INTO deliveries (id, school_id, kind, platform_id, link_id, person_id, subject, state, next_run_at, made_at)
         SELECT $1, l.school_id, 'ags', l.platform_id, l.id, $4, $5, 'waiting', 0, $6
         FROM platform_links l LEFT JOIN platform_contexts c ON c.school_id = l.school_id AND c.id = l.context_id
         WHERE l.school_id = $2 AND l.id = $3 AND (l.page LIKE '/exercises/%' OR l.page LIKE '/assignments/%')
           AND (l.lineitem_url IS NOT NULL OR c.lineitems_url IS NOT NULL)
         ON CONFLICT (school_id, link_id, subject) DO UPDATE SET person_id = excluded.person_id,
           version = deliveries.version + 1,
           next_run_at = CASE deliveries.state WHEN 'stopped' THEN NULL ELSE 0 END,
           state = CASE deliveries.state WHEN 'stopped' THEN 'stopped' ELSE 'waiting' END",
    )
    .bind(DeliveryId::made_at(now))
    .bind(person.school_id)
    .bind(link)
    .bind(person.person_id)
    .bind(subject)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Marks the grades of a person.
pub async fn mark_person(writer: &mut Connection, person: PersonKey) -> Result<()> {
    sqlx::query(mark!("person_id = $2")).bind(person.school_id).bind(person.person_id).execute(writer).await.map(drop)
}

/// Marks the grades of the trainee of an attempt.
pub async fn mark_attempt(writer: &mut Connection, session: SessionKey) -> Result<()> {
    sqlx::query(mark!("person_id = (SELECT s.trainee_id FROM sessions s WHERE s.school_id = $1 AND s.id = $2)"))
        .bind(session.school_id)
        .bind(session.id)
        .execute(writer)
        .await
        .map(drop)
}

/// Marks the grades of the trainees of an assignment.
pub async fn mark_assignment(writer: &mut Connection, school: SchoolId, assignment: AssignmentId) -> Result<()> {
    sqlx::query(mark!(
        "person_id IN (
           SELECT m.person_id FROM assignments a
           JOIN cohort_members m ON m.cohort_id = a.cohort_id AND m.role = 'trainee'
           WHERE a.school_id = $1 AND a.id = $2
           UNION ALL SELECT a.person_id FROM assignments a
           WHERE a.school_id = $1 AND a.id = $2 AND a.person_id IS NOT NULL)"
    ))
    .bind(school)
    .bind(assignment)
    .execute(writer)
    .await
    .map(drop)
}

/// A grade that may have changed.
#[derive(Clone, Debug, FromRow)]
pub struct DueDelivery {
    /// Id.
    pub id: DeliveryId,
    /// School.
    pub school_id: SchoolId,
    /// Link of the platform.
    pub link_id: PlatformLinkId,
    /// Id of the link at the platform.
    pub resource_link_id: String,
    /// Path that the link opens.
    pub page: String,
    /// Whose grade it is.
    pub person_id: PersonId,
    /// The person, as the platform names them.
    pub subject: String,
    /// Grows whenever the grade may have changed.
    pub version: i64,
    /// Number of tries since the last success or change.
    #[sqlx(try_from = "i64")]
    pub tries: u32,
    /// What the platform has, without the timestamp; `None` if it has nothing, or this is unknown.
    pub body: Option<Json<Value>>,
    /// Timestamp of the last message.
    pub stamped_at: Option<Moment>,
    /// Address of the line item.
    pub lineitem_url: Option<String>,
    /// Address of the line items of the course.
    pub lineitems_url: Option<String>,
}

/// Returns the next grades of a platform that may have changed, in the order of their next tries.
pub async fn list_due_deliveries(
    executor: impl Executor<'_>,
    school: SchoolId,
    platform: PlatformId,
    now: Moment,
    limit: u32,
) -> Result<Vec<DueDelivery>> {
    sqlx::query_as(
        "SELECT d.id, d.school_id, d.link_id, l.resource_link_id, l.page, d.person_id, d.subject, d.version, d.tries, d.body,
           d.stamped_at, l.lineitem_url, c.lineitems_url
         FROM deliveries d
         JOIN platform_links l ON l.school_id = d.school_id AND l.id = d.link_id
         LEFT JOIN platform_contexts c ON c.school_id = l.school_id AND c.id = l.context_id
         WHERE d.school_id = $1 AND d.platform_id = $2 AND d.next_run_at <= $3 ORDER BY d.next_run_at LIMIT $4 + 0",
    )
    .bind(school)
    .bind(platform)
    .bind(now)
    .bind(i64::from(limit))
    .fetch_all(executor)
    .await
}

/// Ends a try that sends nothing, unless the grade has changed again.
pub async fn settle_delivery(writer: &mut Connection, due: &DueDelivery, state: DeliveryState) -> Result<()> {
    sqlx::query(
        "UPDATE deliveries SET state = $4, next_run_at = NULL, tries = 0
         WHERE school_id = $1 AND id = $2 AND version = $3 AND state = 'waiting'",
    )
    .bind(due.school_id)
    .bind(due.id)
    .bind(due.version)
    .bind(state)
    .execute(writer)
    .await
    .map(drop)
}

/// Begins to send a message with a timestamp. If the service ends meanwhile, it is sent again from
/// `until` on. Returns false if the grade has changed again.
pub async fn claim_delivery(
    writer: &mut Connection,
    due: &DueDelivery,
    timestamp: Moment,
    until: Moment,
) -> Result<bool> {
    sqlx::query(
        "UPDATE deliveries SET body = NULL, stamped_at = $4, next_run_at = $5, tries = tries + 1
         WHERE school_id = $1 AND id = $2 AND version = $3 AND state = 'waiting' AND stamped_at IS NOT DISTINCT FROM $6",
    )
    .bind(due.school_id)
    .bind(due.id)
    .bind(due.version)
    .bind(timestamp)
    .bind(until)
    .bind(due.stamped_at)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Result of a try.
#[derive(Clone, Debug)]
pub struct DeliveryResult<'a> {
    /// Timestamp of the message.
    pub timestamp: Moment,
    /// New state; a grade that has changed meanwhile waits.
    pub state: DeliveryState,
    /// Time of the next try, if it waits.
    pub next_run_at: Option<Moment>,
    /// Number of tries since the last success.
    pub tries: u32,
    /// What the platform has, if it is known.
    pub body: Option<&'a Value>,
    /// HTTP status.
    pub status: Option<u16>,
    /// Answer of a platform that has refused.
    pub answer: Option<String>,
    /// When it was sent.
    pub sent_at: Option<Moment>,
}

/// Records the result of a try, unless another replica has claimed the grade meanwhile. Returns
/// whether the state is the new one.
pub async fn note_result(writer: &mut Connection, due: &DueDelivery, result: &DeliveryResult<'_>) -> Result<bool> {
    let is_unchanged: Option<bool> = sqlx::query_scalar(
        "UPDATE deliveries SET tries = $5, body = $6, last_status = $7, last_answer = $8,
           sent_at = coalesce($9, sent_at),
           state = CASE WHEN version = $4 THEN $10 ELSE 'waiting' END,
           next_run_at = CASE WHEN version = $4 THEN $11 ELSE 0 END
         WHERE school_id = $1 AND id = $2 AND stamped_at = $3
         RETURNING version = $4",
    )
    .bind(due.school_id)
    .bind(due.id)
    .bind(result.timestamp)
    .bind(due.version)
    .bind(i64::from(result.tries))
    .bind(result.body.map(Json))
    .bind(result.status.map(i64::from))
    .bind(&result.answer)
    .bind(result.sent_at)
    .bind(result.state)
    .bind(result.next_run_at)
    .fetch_optional(writer)
    .await?;
    Ok(is_unchanged.unwrap_or(false))
}

/// A grade, as its page shows it.
#[derive(Clone, Debug, FromRow)]
pub struct ShownDelivery {
    /// Id.
    pub id: DeliveryId,
    /// Whose grade it is.
    pub person_id: PersonId,
    /// Name of the person.
    pub name: String,
    /// Path that the link opens.
    pub page: String,
    /// Number of tries since the last success or change.
    #[sqlx(try_from = "i64")]
    pub tries: u32,
    /// Time of the next try.
    pub next_run_at: Option<Moment>,
    /// Last HTTP status.
    pub last_status: Option<i64>,
    /// Last answer of a platform that has refused.
    pub last_answer: Option<String>,
    /// When it was last sent.
    pub sent_at: Option<Moment>,
}

/// Part of a list of grades.
#[derive(Clone, Copy, Debug)]
pub struct DeliveryQuery {
    /// School.
    pub school_id: SchoolId,
    /// Learning platform.
    pub platform_id: PlatformId,
    /// State.
    pub state: DeliveryState,
    /// The last one of the part before.
    pub after: DeliveryId,
    /// Maximum number.
    pub limit: u32,
}

/// Returns grades of a platform in one state, oldest first.
pub async fn list_deliveries(executor: impl Executor<'_>, query: DeliveryQuery) -> Result<Vec<ShownDelivery>> {
    sqlx::query_as(
        "SELECT d.id, d.person_id, p.display_name AS name, l.page, d.tries, d.next_run_at, d.last_status, d.last_answer,
           d.sent_at
         FROM deliveries d
         JOIN platform_links l ON l.school_id = d.school_id AND l.id = d.link_id
         JOIN people p ON p.school_id = d.school_id AND p.id = d.person_id
         WHERE d.school_id = $1 AND d.platform_id = $2 AND d.state = $3 AND d.id > $4 ORDER BY d.id LIMIT $5 + 0",
    )
    .bind(query.school_id)
    .bind(query.platform_id)
    .bind(query.state)
    .bind(query.after)
    .bind(i64::from(query.limit))
    .fetch_all(executor)
    .await
}

/// Makes a stopped or waiting grade of a platform due now. Returns false if there is none.
pub async fn retry_delivery(
    writer: &mut Connection,
    school: SchoolId,
    platform: PlatformId,
    id: DeliveryId,
) -> Result<bool> {
    sqlx::query(
        "UPDATE deliveries SET state = 'waiting', next_run_at = 0, tries = 0, version = version + 1
         WHERE school_id = $1 AND platform_id = $2 AND id = $3 AND state IN ('stopped', 'waiting')",
    )
    .bind(school)
    .bind(platform)
    .bind(id)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Deletes the grades of a person.
pub async fn remove_deliveries(writer: &mut Connection, person: PersonKey) -> Result<()> {
    sqlx::query("DELETE FROM deliveries WHERE school_id = $1 AND person_id = $2")
        .bind(person.school_id)
        .bind(person.person_id)
        .execute(writer)
        .await
        .map(drop)
}
