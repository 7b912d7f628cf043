//! Schools and their settings.

use model::ids::SchoolId;
use model::training::signatory::Signatory;
use model::{CurrentPerson, Moment, Needed};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// A school.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct School {
    /// Id.
    pub id: SchoolId,
    /// Name, unique.
    pub name: String,
}

/// Returns all schools, sorted by name.
pub async fn list_schools(executor: impl Executor<'_>) -> Result<Vec<School>> {
    sqlx::query_as("SELECT id, name FROM schools ORDER BY name").fetch_all(executor).await
}

/// Returns the name of a school.
///
/// # Errors
/// If there is no such school, or the database fails.
pub async fn find_school_name(executor: impl Executor<'_>, id: SchoolId) -> Result<String> {
    sqlx::query_scalar("SELECT name FROM schools WHERE id = $1").bind(id).fetch_one(executor).await
}

/// Returns the time zone of a school, a name of the IANA database.
///
/// # Errors
/// If there is no such school, or the database fails.
pub async fn find_time_zone(executor: impl Executor<'_>, id: SchoolId) -> Result<String> {
    sqlx::query_scalar("SELECT time_zone FROM schools WHERE id = $1").bind(id).fetch_one(executor).await
}

/// Settings that a school changes on its settings page.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct SchoolSettings {
    /// Name, unique.
    pub name: String,
    /// Time zone, a name of the IANA database.
    pub time_zone: String,
    /// Code of the language of letters to people who have chosen none; `None` means English.
    pub letter_language: Option<String>,
    /// Reminders of due dates are mailed.
    pub mails_reminders: bool,
    /// Unread notices are mailed to people who want it.
    pub mails_news: bool,
    /// Trainees see statistics of the others in their cohort next to their own.
    pub shows_others: bool,
    /// Number of days for which attempts at a replaced revision still count.
    #[sqlx(try_from = "i64")]
    pub replaced_grace_days: u32,
    /// Who answers for what people tell it, where to ask, and how long it is kept; empty where it has not said.
    pub data_notice: String,
    /// Name of the person who signs certificates on paper; empty if nobody does.
    pub signatory_name: String,
    /// Function of that person at the school.
    pub signatory_function: String,
}

impl SchoolSettings {
    /// Returns the person who signs certificates and transcripts on paper.
    #[must_use]
    pub fn signatory(&self) -> Option<Signatory> {
        let (name, function) = (self.signatory_name.clone(), self.signatory_function.clone());
        (!name.is_empty()).then_some(Signatory { name, function })
    }
}

/// Returns the settings of a school.
///
/// # Errors
/// If there is no such school, or the database fails.
pub async fn find_school_settings(executor: impl Executor<'_>, id: SchoolId) -> Result<SchoolSettings> {
    sqlx::query_as(
        "SELECT name, time_zone, letter_language, mails_reminders, mails_news, shows_others,
           replaced_grace_days, data_notice, signatory_name, signatory_function
         FROM schools WHERE id = $1",
    )
    .bind(id)
    .fetch_one(executor)
    .await
}

/// Stores the settings of a school. Returns false if another school has the name.
pub async fn put_school_settings(writer: &mut Connection, id: SchoolId, settings: &SchoolSettings) -> Result<bool> {
    sqlx::query(
        "UPDATE schools SET name = $2, time_zone = $3, letter_language = $4, mails_reminders = $5, mails_news = $6,
           shows_others = $7, replaced_grace_days = $8, data_notice = $9,
           signatory_name = $10, signatory_function = $11
         WHERE id = $1 AND NOT EXISTS (SELECT 1 FROM schools WHERE name = $2 AND id <> $1)",
    )
    .bind(id)
    .bind(&settings.name)
    .bind(&settings.time_zone)
    .bind(&settings.letter_language)
    .bind(settings.mails_reminders)
    .bind(settings.mails_news)
    .bind(settings.shows_others)
    .bind(i64::from(settings.replaced_grace_days))
    .bind(&settings.data_notice)
    .bind(&settings.signatory_name)
    .bind(&settings.signatory_function)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Returns whether a person sees statistics of the others in a trainee's cohort next to the
/// trainee's own: staff always do, trainees if the school's settings allow it.
///
/// # Errors
/// If there is no such school, or the database fails.
pub async fn sees_others(executor: impl Executor<'_>, viewer: &CurrentPerson) -> Result<bool> {
    if viewer.role.teaches() {
        return Ok(true);
    }
    sqlx::query_scalar("SELECT shows_others FROM schools WHERE id = $1")
        .bind(viewer.school_id)
        .fetch_one(executor)
        .await
}

/// Returns the proof that an attempt needs to count towards a certificate of a school.
///
/// # Errors
/// If there is no such school, or the database fails.
pub async fn certificate_needs(executor: impl Executor<'_>, id: SchoolId) -> Result<Needed> {
    sqlx::query_scalar("SELECT certificate_needs FROM schools WHERE id = $1").bind(id).fetch_one(executor).await
}

/// Sets the proof that an attempt needs to count towards a certificate.
pub async fn set_certificate_needs(writer: &mut Connection, id: SchoolId, needed: Needed) -> Result<()> {
    sqlx::query("UPDATE schools SET certificate_needs = $2 WHERE id = $1")
        .bind(id)
        .bind(needed)
        .execute(writer)
        .await
        .map(drop)
}

/// Returns whether a school deletes the recordings of erased people.
///
/// # Errors
/// If there is no such school, or the database fails.
pub async fn erases_recordings(executor: impl Executor<'_>, id: SchoolId) -> Result<bool> {
    sqlx::query_scalar("SELECT erase_recordings FROM schools WHERE id = $1").bind(id).fetch_one(executor).await
}

/// Returns the school with this name, and creates it if it is missing.
pub async fn find_or_create(writer: &mut Connection, name: &str, now: Moment) -> Result<School> {
    sqlx::query_as(
        "INSERT INTO schools (id, name, created_at) VALUES ($1, $2, $3)
         ON CONFLICT (name) DO UPDATE SET name = excluded.name RETURNING id, name",
    )
    .bind(SchoolId::made_at(now))
    .bind(name)
    .bind(now)
    .fetch_one(writer)
    .await
}

/// Returns whether there is more than one school.
pub async fn are_schools_several(executor: impl Executor<'_>) -> Result<bool> {
    sqlx::query_scalar("SELECT count(*) > 1 FROM (SELECT 1 FROM schools LIMIT 2) two").fetch_one(executor).await
}
