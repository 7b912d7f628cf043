//! How long a school keeps whoever does nothing any more: its rule, who was warned, and how long the service has run since.

use model::count::StoredCount;
use model::ids::{LetterId, PersonId, SchoolId};
use model::mail::RetentionLetter;
use model::retention::{RetentionRule, Warned};
use model::{Moment, PersonKey, Role};
use sqlx::FromRow;

use super::{Connection, Executor, Result};

/// The rule of a school; none where everybody is kept for ever.
///
/// # Errors
/// When there is no such school, or the database fails.
pub async fn find_retention_rule(executor: impl Executor<'_>, school: SchoolId) -> Result<Settings> {
    sqlx::query_as(
        "SELECT retention_months AS months, retention_warn_days AS warn_days, retention_texts AS texts,
           erase_recordings AS recordings FROM schools WHERE id = $1",
    )
    .bind(school)
    .fetch_one(executor)
    .await
}

/// What a school has set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct Settings {
    /// Months after which whoever does nothing is erased; none: never.
    #[sqlx(try_from = "StoredCount")]
    pub months: Option<u32>,
    /// Days before that they are warned.
    #[sqlx(try_from = "i64")]
    pub warn_days: u32,
    /// Their free texts, and others' about them, go with them.
    pub texts: bool,
    /// Recordings go with whoever is erased, by this rule or by hand.
    pub recordings: bool,
}

impl Settings {
    /// The rule, where there is one.
    #[must_use]
    pub fn rule(&self) -> Option<RetentionRule> {
        self.months.map(|months| RetentionRule { months, warn_days: self.warn_days })
    }
}

/// Sets the rule of a school.
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

/// Somebody who has done nothing for long, or was warned.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Idle {
    /// Id.
    pub id: PersonId,
    /// Name.
    pub name: String,
    /// Address.
    pub email: String,
    /// Role.
    pub role: Role,
    /// What recordings say instead of a name.
    pub pseudonym: String,
    /// Since when they are kept whatever the rule says.
    pub held_at: Option<Moment>,
    /// When they last did anything: signed in, trained, said something; or were added.
    pub active_at: Moment,
    /// When they were warned.
    pub warned_at: Option<Moment>,
    /// When their letter was out, or given up.
    pub told_at: Option<Moment>,
    /// The same by the time that the service has run, in s.
    pub told_observed_s: Option<i64>,
    /// Why the letter did not go out.
    pub error: Option<String>,
}

impl Idle {
    /// What is known of their warning.
    #[must_use]
    pub fn warned(&self) -> Option<Warned> {
        self.warned_at.map(|_| Warned { told: self.told_at.zip(self.told_observed_s) })
    }
}

/// When people were last active, and who of them have done nothing since $2 or were warned.
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

/// Who of a school has done nothing since a moment, where there is one, and who was warned, the longest idle first. Administrators, guests and
/// whoever was erased are not among them. That a link was asked for is nobody's deed: any stranger may do so.
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

/// Notes that somebody is warned, and queues their letter.
///
/// # Errors
/// When they were warned before, or the database fails.
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

/// Forgets that somebody was warned.
pub async fn forget_warning(writer: &mut Connection, person: PersonId) -> Result<()> {
    sqlx::query("DELETE FROM retention_warnings WHERE person_id = $1").bind(person).execute(writer).await.map(drop)
}

/// The letters that are due.
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

/// Notes what became of a letter: out, to be tried again, or given up. From the first or the last on the days count.
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

/// How long the service has run, and at which of that time it last looked whom to erase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct ServiceTime {
    /// In s.
    pub observed_s: i64,
    /// In s.
    pub looked_s: Option<i64>,
}

/// How long the service has run.
pub async fn service_time(executor: impl Executor<'_>) -> Result<ServiceTime> {
    sqlx::query_as("SELECT observed_s, looked_s FROM service_time").fetch_one(executor).await
}

/// Adds to how long the service has run, in s.
pub async fn add_service_time(writer: &mut Connection, seconds: i64) -> Result<ServiceTime> {
    sqlx::query_as("UPDATE service_time SET observed_s = observed_s + $1 RETURNING observed_s, looked_s")
        .bind(seconds)
        .fetch_one(writer)
        .await
}

/// Notes that it was looked whom to erase.
pub async fn note_look(writer: &mut Connection) -> Result<()> {
    sqlx::query("UPDATE service_time SET looked_s = observed_s").execute(writer).await.map(drop)
}

/// Since when somebody is kept whatever the rule says, if they are.
pub async fn find_hold_time(executor: impl Executor<'_>, school: SchoolId, person: PersonId) -> Result<Option<Moment>> {
    let held: Option<Option<Moment>> =
        sqlx::query_scalar("SELECT held_at FROM people WHERE school_id = $1 AND id = $2")
            .bind(school)
            .bind(person)
            .fetch_optional(executor)
            .await?;
    Ok(held.flatten())
}

/// Keeps somebody whatever the rule says, or no longer. False where nothing changes.
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

/// Who of a school is kept whatever the rule says: id and name, by name.
pub async fn list_held_people(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<(PersonId, String)>> {
    sqlx::query_as(
        "SELECT id, display_name FROM people WHERE school_id = $1 AND held_at > 0 AND erased_at IS NULL
         ORDER BY display_name",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// How many people of a school were warned.
pub async fn count_warned(executor: impl Executor<'_>, school: SchoolId) -> Result<i64> {
    sqlx::query_scalar("SELECT count(*) FROM retention_warnings WHERE school_id = $1")
        .bind(school)
        .fetch_one(executor)
        .await
}
