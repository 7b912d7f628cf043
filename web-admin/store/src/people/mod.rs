//! People and their password hashes.

pub mod directory;
pub mod provisioning;
pub mod rosters;

use model::ids::{PersonId, SchoolId};
use model::people::email::{email_in_ascii, normalize_email, present_email};
use model::search_key::{fold_text, make_search_text};
use model::{CurrentPerson, Moment, PersonKey, Role};
use sqlx::FromRow;
use words::Language;

use crate::auth::account_links;
use crate::auth::second_factors::with_factor_owed;
use crate::{Connection, Executor, Result};

/// A person, without credentials.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Person {
    /// Id.
    pub id: PersonId,
    /// School.
    pub school_id: SchoolId,
    /// Role.
    pub role: Role,
    /// Email address, in lower case.
    pub email: String,
    /// Name shown to people.
    pub display_name: String,
    /// Pseudonym, used in recordings.
    pub pseudonym: String,
    /// Incremented with each change of the password and each forced sign-out.
    pub credential_version: i64,
    /// When the account was disabled.
    pub disabled_at: Option<Moment>,
    /// Code of the chosen language.
    pub language: Option<String>,
    /// Number of unread notices, if queried.
    #[sqlx(default)]
    #[sqlx(try_from = "i64")]
    pub news: u32,
    /// Version of the school's logo, if queried and present.
    #[sqlx(default)]
    pub logo: Option<String>,
}

impl Person {
    /// Returns the person for a web session. `None` for disabled accounts and for guests, who sign
    /// in only at stations.
    #[must_use]
    pub fn into_current(self) -> Option<CurrentPerson> {
        (self.disabled_at.is_none() && self.role != Role::Guest).then_some(CurrentPerson {
            id: self.id,
            school_id: self.school_id,
            role: self.role,
            display_name: self.display_name,
            language: self.language.as_deref().and_then(Language::named),
            news: self.news,
            logo: self.logo,
        })
    }
}

/// A person with the data that every request of a browser needs.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct BrowsingPerson {
    /// The person.
    #[sqlx(flatten)]
    pub person: Person,
    /// Time zone of the school.
    pub time_zone: String,
    /// The person is required to have a second factor and has none.
    pub owes_factor: bool,
}

/// A person to be added.
#[derive(Clone, Debug)]
pub struct NewPerson<'a> {
    /// School.
    pub school_id: SchoolId,
    /// Role.
    pub role: Role,
    /// Email address, stored in lower case.
    pub email: &'a str,
    /// Name shown to people.
    pub display_name: &'a str,
    /// Argon2id hash in PHC format; empty if the person will set a password through a link.
    pub password_hash: &'a str,
}

/// Data for verifying a sign-in.
#[derive(Clone, Debug, FromRow)]
pub struct Credentials {
    /// Person.
    pub id: PersonId,
    /// Argon2id hash in PHC format; `None` if an invited person has not set a password yet.
    pub password_hash: Option<String>,
    /// Stored in the web session, which ends when the version changes.
    pub credential_version: i64,
    /// When the account was disabled.
    pub disabled_at: Option<Moment>,
    /// Expiry time of an initial password set by an administrator, which is valid for one sign-in;
    /// `None` if the person chose the password.
    pub initial_until: Option<Moment>,
}

/// Adds a person with a new pseudonym.
///
/// # Errors
/// If the email address is already in use, or the database fails.
pub async fn add_person(writer: &mut Connection, person: &NewPerson<'_>, now: Moment) -> Result<Person> {
    let id = PersonId::made_at(now);
    // The last 48 bits of a UUIDv7 are random: the pseudonym reveals neither the name nor the order
    // of enrolment.
    let pseudonym = format!("p-{}", &id.uuid().simple().to_string()[20..]);
    sqlx::query_as(
        "INSERT INTO people (id, school_id, role, email, display_name, pseudonym, password_hash, created_at, search, sort_name)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)
         RETURNING id, school_id, role, email, display_name, pseudonym, credential_version, disabled_at, language",
    )
    .bind(id)
    .bind(person.school_id)
    .bind(person.role)
    .bind(normalize_email(person.email))
    .bind(person.display_name)
    .bind(pseudonym)
    .bind(person.password_hash)
    .bind(now)
    .bind(make_search_text(person.display_name, present_email(person.email).unwrap_or_default(), None))
    .bind(fold_text(person.display_name))
    .fetch_one(writer)
    .await
}

/// Adds a guest, who has only a pseudonym: the email address is invalid, and no password matches.
///
/// # Errors
/// If the database fails.
pub async fn add_guest(writer: &mut Connection, school: SchoolId, now: Moment) -> Result<Person> {
    let id = PersonId::made_at(now);
    let pseudonym = format!("g-{}", &id.uuid().simple().to_string()[20..]);
    sqlx::query_as(
        "INSERT INTO people (id, school_id, role, email, display_name, pseudonym, password_hash, created_at, search)
         VALUES ($1, $2, 'guest', $3 || '@guest.invalid', $3, $3, '', $4, '')
         RETURNING id, school_id, role, email, display_name, pseudonym, credential_version, disabled_at, language",
    )
    .bind(id)
    .bind(school)
    .bind(pseudonym)
    .bind(now)
    .fetch_one(writer)
    .await
}

/// Returns the number of people in all schools.
pub async fn count_people(executor: impl Executor<'_>) -> Result<i64> {
    sqlx::query_scalar("SELECT count(*) FROM people").fetch_one(executor).await
}

/// Returns a person of any school. Used for the session cookie, which contains no school.
pub async fn find_person(executor: impl Executor<'_>, id: PersonId) -> Result<Option<Person>> {
    sqlx::query_as(
        "SELECT id, school_id, role, email, display_name, pseudonym, credential_version, disabled_at, language,
           (SELECT count(*) FROM notices n
            WHERE n.school_id = p.school_id AND n.person_id = p.id AND n.read_at IS NULL) AS news,
           (SELECT l.version FROM school_logos l WHERE l.school_id = p.school_id) AS logo
         FROM people p WHERE id = $1",
    )
    .bind(id)
    .fetch_optional(executor)
    .await
}

/// Returns a person with the data that every request of a browser needs.
pub async fn find_browsing_person(executor: impl Executor<'_>, id: PersonId) -> Result<Option<BrowsingPerson>> {
    sqlx::query_as(with_factor_owed!(
        "SELECT p.id, p.school_id, p.role, p.email, p.display_name, p.pseudonym, p.credential_version, p.disabled_at,
           p.language, s.time_zone,
           (SELECT count(*) FROM notices n
            WHERE n.school_id = p.school_id AND n.person_id = p.id AND n.read_at IS NULL) AS news,
           (SELECT l.version FROM school_logos l WHERE l.school_id = p.school_id) AS logo, ",
        " AS owes_factor
         FROM people p JOIN schools s ON s.id = p.school_id WHERE p.id = $1"
    ))
    .bind(id)
    .fetch_optional(executor)
    .await
}

/// Returns a person's registration number, if it is known.
pub async fn find_registrar_id(executor: impl Executor<'_>, school: SchoolId, id: PersonId) -> Result<Option<String>> {
    let found: Option<Option<String>> =
        sqlx::query_scalar("SELECT registrar_id FROM people WHERE school_id = $1 AND id = $2")
            .bind(school)
            .bind(id)
            .fetch_optional(executor)
            .await?;
    Ok(found.flatten())
}

/// Returns the people of all schools with an email address, in any spelling, the oldest account first. An
/// address belongs to at most one account of a school.
pub async fn list_people_by_email(executor: impl Executor<'_>, email: &str) -> Result<Vec<Person>> {
    sqlx::query_as(
        "SELECT id, school_id, role, email, display_name, pseudonym, credential_version, disabled_at, language
         FROM people WHERE email IN ($1, $2, $3) ORDER BY created_at, id",
    )
    .bind(email.to_lowercase())
    .bind(normalize_email(email))
    .bind(email_in_ascii(&normalize_email(email)))
    .fetch_all(executor)
    .await
}

/// Returns the person of any school who has had an email address longest.
pub async fn find_person_by_email(executor: impl Executor<'_>, email: &str) -> Result<Option<Person>> {
    Ok(list_people_by_email(executor, email).await?.into_iter().next())
}

/// Returns a person of a school by email address, in any spelling. An address that an earlier
/// version stored without normalization takes precedence.
pub async fn find_member_by_email(
    executor: impl Executor<'_>,
    school: SchoolId,
    email: &str,
) -> Result<Option<Person>> {
    sqlx::query_as(
        "SELECT id, school_id, role, email, display_name, pseudonym, credential_version, disabled_at, language
         FROM people WHERE school_id = $4 AND email IN ($1, $2, $3) ORDER BY email <> $1 LIMIT 1",
    )
    .bind(email.to_lowercase())
    .bind(normalize_email(email))
    .bind(email_in_ascii(&normalize_email(email)))
    .bind(school)
    .fetch_optional(executor)
    .await
}

/// Returns a person of a school by pseudonym.
pub async fn by_pseudonym(executor: impl Executor<'_>, school: SchoolId, name: &str) -> Result<Option<Person>> {
    sqlx::query_as(
        "SELECT id, school_id, role, email, display_name, pseudonym, credential_version, disabled_at, language
         FROM people WHERE school_id = $1 AND pseudonym = $2",
    )
    .bind(school)
    .bind(name)
    .fetch_optional(executor)
    .await
}

/// Whether a person's recordings may be stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct RecordingConsent {
    /// The person was erased.
    pub is_erased: bool,
    /// The person is a guest without a valid consent to a study.
    pub is_missing: bool,
}

/// Returns whether a person's recordings may be stored.
pub async fn find_recording_consent(
    executor: impl Executor<'_>,
    PersonKey { school_id: school, person_id: person }: PersonKey,
) -> Result<RecordingConsent> {
    sqlx::query_as(
        "SELECT p.erased_at IS NOT NULL AS is_erased,
           p.role = 'guest' AND NOT EXISTS (SELECT 1 FROM study_participants t WHERE t.school_id = p.school_id
             AND t.person_id = p.id AND t.agreed_at IS NOT NULL AND t.withdrawn_at IS NULL) AS is_missing
         FROM people p WHERE p.school_id = $1 AND p.id = $2",
    )
    .bind(school)
    .bind(person)
    .fetch_one(executor)
    .await
}

/// Returns the data for verifying a sign-in with an email address: of each account that has it, or of the one at
/// the named school; at most eight, the oldest first.
pub async fn list_credentials(
    executor: impl Executor<'_>,
    email: &str,
    school: Option<&str>,
) -> Result<Vec<Credentials>> {
    sqlx::query_as(
        "SELECT p.id, nullif(p.password_hash, '') AS password_hash, p.credential_version, p.disabled_at,
           p.password_initial_until AS initial_until
         FROM people p JOIN schools s ON s.id = p.school_id
         WHERE p.email IN ($1, $2, $3) AND ($4 IS NULL OR s.name = $4) ORDER BY p.created_at, p.id LIMIT 8",
    )
    .bind(email.to_lowercase())
    .bind(normalize_email(email))
    .bind(email_in_ascii(&normalize_email(email)))
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Returns the data for verifying the password of a person.
pub async fn find_credentials(executor: impl Executor<'_>, person: PersonId) -> Result<Option<Credentials>> {
    sqlx::query_as(
        "SELECT id, nullif(password_hash, '') AS password_hash, credential_version, disabled_at,
           password_initial_until AS initial_until
         FROM people WHERE id = $1",
    )
    .bind(person)
    .fetch_optional(executor)
    .await
}

/// Returns whether a person has a password.
pub async fn has_password(executor: impl Executor<'_>, person: PersonId) -> Result<bool> {
    sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM people WHERE id = $1 AND password_hash <> '')")
        .bind(person)
        .fetch_one(executor)
        .await
}

/// Sets a password chosen by the person, and ends all earlier web sessions, links and sign-in
/// codes. Returns false if there is no such person.
pub async fn set_password(writer: &mut Connection, person: PersonId, password_hash: &str) -> Result<bool> {
    account_links::end_account_links(writer, person).await?;
    sqlx::query(
        "UPDATE people SET password_hash = $2, credential_version = credential_version + 1, password_initial_until = NULL
         WHERE id = $1",
    )
    .bind(person)
    .bind(password_hash)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Marks a person's password as initial: valid until `until`, for one sign-in.
pub async fn make_initial(writer: &mut Connection, person: PersonId, until: Moment) -> Result<()> {
    sqlx::query("UPDATE people SET password_initial_until = $2 WHERE id = $1")
        .bind(person)
        .bind(until)
        .execute(writer)
        .await
        .map(drop)
}

/// Returns the language that a person has chosen.
pub async fn find_language(
    executor: impl Executor<'_>,
    PersonKey { school_id: school, person_id: person }: PersonKey,
) -> Result<Option<Language>> {
    let chosen: Option<Option<String>> =
        sqlx::query_scalar("SELECT language FROM people WHERE school_id = $1 AND id = $2")
            .bind(school)
            .bind(person)
            .fetch_optional(executor)
            .await?;
    Ok(chosen.flatten().as_deref().and_then(Language::named))
}

/// Sets a person's language; `None` selects the language of the browser. Returns false if there is
/// no such person.
pub async fn set_language(
    writer: &mut Connection,
    PersonKey { school_id: school, person_id: person }: PersonKey,
    language: Option<Language>,
) -> Result<bool> {
    sqlx::query("UPDATE people SET language = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(person)
        .bind(language.map(Language::code))
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Ends all web sessions of a person.
pub async fn end_sign_ins(writer: &mut Connection, person: PersonId) -> Result<()> {
    sqlx::query("UPDATE people SET credential_version = credential_version + 1 WHERE id = $1")
        .bind(person)
        .execute(writer)
        .await
        .map(drop)
}

/// Disables an account, and ends all web sessions, links and sign-in codes. Returns false if it was
/// already disabled.
pub async fn disable_person(writer: &mut Connection, person: PersonId, now: Moment) -> Result<bool> {
    account_links::end_account_links(writer, person).await?;
    sqlx::query(
        "UPDATE people SET disabled_at = $2, credential_version = credential_version + 1
         WHERE id = $1 AND disabled_at IS NULL",
    )
    .bind(person)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}
