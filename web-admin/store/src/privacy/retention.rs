//! Retention: the schools' rules for erasing inactive people, the warnings sent, and the uptime of
//! the service since.

use model::count::StoredCount;
use model::ids::{LetterId, PersonId, SchoolId};
use model::letters::mail::RetentionLetter;
use model::privacy::retention::{RetentionRule, Warned};
use model::{Moment, PersonKey, Role};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// Returns the retention settings of a school.
///
/// # Errors
/// If there is no such school, or the database fails.
pub async fn find_retention_rule(executor: impl Executor<'_>, school: SchoolId) -> Result<Settings> {
    sqlx::query_as(
        "SELECT retention_months AS months, retention_warn_days AS warn_days, retention_texts AS texts,
           erase_recordings AS recordings FROM schools WHERE id = $1",
    )
    .bind(school)
    .fetch_one(executor)
    .await
}

/// Retention settings of a school.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct Settings {
    /// Months of inactivity after which a person is erased; `None` means never.
    #[sqlx(try_from = "StoredCount")]
    pub months: Option<u32>,
    /// Days between the warning and the erasure.
    #[sqlx(try_from = "i64")]
    pub warn_days: u32,
    /// Free texts by and about erased people are deleted, too.
    pub texts: bool,
    /// Recordings of erased people are deleted, too, after automatic or manual erasure.
    pub recordings: bool,
}

impl Settings {
    /// Returns the rule, unless people are kept without limit.
    #[must_use]
    pub fn rule(&self) -> Option<RetentionRule> {
        self.months.map(|months| RetentionRule { months, warn_days: self.warn_days })
    }
}

/// Stores the retention settings of a school.
pub async fn set_retention_rule(writer: &mut Connection, school: SchoolId, settings: Settings) -> Result<()> {
    sqlx::query(
        "UPDATE schools SET retention_months = $2, retention_warn_days = $3, retention_texts = $4, erase_recordings = $5
         WHERE id = $1",
    )
    .bind(school)
    .bind(settings.months.map(i64::from))
    .bind(i64::from(settings.warn_days))
    .bind(settings.texts)
    .bind(settings.recordings)
    .execute(writer)
    .await
    .map(drop)
}

/// A person who has been inactive for a long time, or was warned.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Idle {
    /// Id.
    pub id: PersonId,
    /// Name.
    pub name: String,
    /// Email address.
    pub email: String,
    /// Role.
    pub role: Role,
    /// Pseudonym, used in recordings.
    pub pseudonym: String,
    /// Start of an exemption from the rule.
    pub held_at: Option<Moment>,
    /// Last activity: the last attempt received or action in the audit log, or else the creation of
    /// the account.
    pub active_at: Moment,
    /// Time of the warning.
    pub warned_at: Option<Moment>,
    /// Time at which the letter was sent or given up.
    pub told_at: Option<Moment>,
    /// Uptime of the service at that time, in s.
    pub told_observed_s: Option<i64>,
    /// Error when sending the letter.
    pub error: Option<String>,
}

impl Idle {
    /// Returns the state of the warning, if there is one.
    #[must_use]
    pub fn warned(&self) -> Option<Warned> {
        self.warned_at.map(|_| Warned { told: self.told_at.zip(self.told_observed_s) })
    }
}

/// Selects people of school `$1` with their last activity who have been inactive since `$2` or were
/// warned.
macro_rules! idle_people {
    ($people:literal) => {
        concat!(
            "WITH everybody AS MATERIALIZED (
               SELECT p.id, p.display_name AS name, p.email, p.role, p.pseudonym, p.held_at, w.warned_at, w.told_at, w.told_observed_s,
                 w.error, max(p.created_at,
                   coalesce((SELECT s.received_at FROM sessions s WHERE s.school_id = p.school_id AND s.trainee_id = p.id
                             ORDER BY s.started_at DESC LIMIT 1), 0),
                   coalesce((SELECT a.at FROM audit_log a WHERE a.actor = lower(substr(hex(p.id), 1, 8) || '-'
                       || substr(hex(p.id), 9, 4) || '-' || substr(hex(p.id), 13, 4) || '-' || substr(hex(p.id), 17, 4) || '-'
                       || substr(hex(p.id), 21)) AND a.action <> 'person.link_asked_for' ORDER BY a.seq DESC LIMIT 1), 0)) AS active_at
               FROM ",
            $people,
            " AND p.school_id = $1 AND p.erased_at IS NULL AND p.role IN ('trainee', 'instructor'))
             SELECT * FROM everybody WHERE active_at < $2 OR warned_at IS NOT NULL ORDER BY active_at, id"
        )
    };
}

/// Returns the people of a school who were warned and, if `since` is given, those who have been
/// inactive since then; longest inactive first. Administrators, guests and erased people are left
/// out. A request for a password link is not an activity, because anyone can make it.
pub async fn list_idle_people(
    executor: impl Executor<'_>,
    school: SchoolId,
    since: Option<Moment>,
) -> Result<Vec<Idle>> {
    let statement = match since {
        Some(_) => idle_people!(
            "people p LEFT JOIN retention_warnings w ON w.person_id = p.id WHERE (p.created_at < $2 OR w.warned_at IS NOT NULL)"
        ),
        None => idle_people!("retention_warnings w CROSS JOIN people p WHERE p.id = w.person_id"),
    };
    sqlx::query_as(statement).bind(school).bind(since).fetch_all(executor).await
}

/// Records a warning and queues the letter.
///
/// # Errors
/// If the person was already warned, or the database fails.
pub async fn warn_person(writer: &mut Connection, school: SchoolId, idle: &Idle, now: Moment) -> Result<()> {
    sqlx::query(
        "INSERT INTO retention_warnings (id, school_id, person_id, active_at, warned_at, next_run_at)
         VALUES ($1, $2, $3, $4, $5, $5)",
    )
    .bind(LetterId::made_at(now))
    .bind(school)
    .bind(idle.id)
    .bind(idle.active_at)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Deletes a warning.
pub async fn forget_warning(writer: &mut Connection, person: PersonId) -> Result<()> {
    sqlx::query("DELETE FROM retention_warnings WHERE person_id = $1").bind(person).execute(writer).await.map(drop)
}

/// Returns the letters that are due, oldest first.
pub async fn list_due_warnings(executor: impl Executor<'_>, now: Moment, limit: u32) -> Result<Vec<RetentionLetter>> {
    sqlx::query_as(
        "SELECT w.id, w.tries, p.display_name AS name, p.email, s.name AS school,
           coalesce(p.language, s.letter_language) AS language, s.retention_months AS months,
           s.retention_warn_days AS warn_days
         FROM retention_warnings w JOIN people p ON p.id = w.person_id JOIN schools s ON s.id = w.school_id
         WHERE w.next_run_at <= $1 ORDER BY w.next_run_at LIMIT $2 + 0",
    )
    .bind(now)
    .bind(i64::from(limit))
    .fetch_all(executor)
    .await
}

/// Records the result of sending a letter: sent, to be retried, or given up. The days until the
/// erasure are counted from the time when it was sent or given up.
pub async fn note_warning_letter(
    writer: &mut Connection,
    letter: LetterId,
    error: Option<&str>,
    again: Option<Moment>,
    now: Moment,
) -> Result<()> {
    sqlx::query(
        "UPDATE retention_warnings SET tries = tries + 1, error = $2, next_run_at = $3,
           told_at = CASE WHEN $3 IS NULL THEN CAST($4 AS BIGINT) END,
           told_observed_s = CASE WHEN $3 IS NULL THEN (SELECT observed_s FROM service_time) END
         WHERE id = $1",
    )
    .bind(letter)
    .bind(error)
    .bind(again)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Uptime of the service.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct ServiceTime {
    /// Total uptime, in s.
    pub observed_s: i64,
    /// Uptime at the last check for people to be erased, in s.
    pub looked_s: Option<i64>,
}

/// Returns the uptime of the service.
pub async fn service_time(executor: impl Executor<'_>) -> Result<ServiceTime> {
    sqlx::query_as("SELECT observed_s, looked_s FROM service_time").fetch_one(executor).await
}

/// Adds to the uptime of the service, in s.
pub async fn add_service_time(writer: &mut Connection, seconds: i64) -> Result<ServiceTime> {
    sqlx::query_as("UPDATE service_time SET observed_s = observed_s + $1 RETURNING observed_s, looked_s")
        .bind(seconds)
        .fetch_one(writer)
        .await
}

/// Records that people to be erased were checked.
pub async fn note_look(writer: &mut Connection) -> Result<()> {
    sqlx::query("UPDATE service_time SET looked_s = observed_s").execute(writer).await.map(drop)
}

/// Returns the start of a person's exemption from the rule, if there is one.
pub async fn find_hold_time(executor: impl Executor<'_>, school: SchoolId, person: PersonId) -> Result<Option<Moment>> {
    let held: Option<Option<Moment>> =
        sqlx::query_scalar("SELECT held_at FROM people WHERE school_id = $1 AND id = $2")
            .bind(school)
            .bind(person)
            .fetch_optional(executor)
            .await?;
    Ok(held.flatten())
}

/// Exempts a person from the rule, or ends the exemption. Returns false if nothing changed.
pub async fn hold_person(
    writer: &mut Connection,
    PersonKey { school_id: school, person_id: person }: PersonKey,
    since: Option<Moment>,
) -> Result<bool> {
    sqlx::query(
        "UPDATE people SET held_at = $3 WHERE school_id = $1 AND id = $2 AND (held_at IS NULL) <> ($3 IS NULL)
           AND erased_at IS NULL",
    )
    .bind(school)
    .bind(person)
    .bind(since)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Returns the people of a school who are exempt from the rule: id and name, sorted by name.
pub async fn list_held_people(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<(PersonId, String)>> {
    sqlx::query_as(
        "SELECT id, display_name FROM people WHERE school_id = $1 AND held_at > 0 AND erased_at IS NULL
         ORDER BY display_name",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Returns the number of warned people of a school.
pub async fn count_warned(executor: impl Executor<'_>, school: SchoolId) -> Result<i64> {
    sqlx::query_scalar("SELECT count(*) FROM retention_warnings WHERE school_id = $1")
        .bind(school)
        .fetch_one(executor)
        .await
}
