//! People and their passwords' hashes.

use model::email::{email_in_ascii, normalize_email};
use model::folding::{fold_text, make_search_text};
use model::ids::{PersonId, SchoolId};
use model::{CurrentPerson, Moment, PersonKey, Role};
use sqlx::FromRow;
use words::Language;

use super::second_factors::with_factor_owed;
use super::{Connection, Executor, Result, account_links};

/// A person, without what they sign in with.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Person {
    /// Id.
    pub id: PersonId,
    /// Their school.
    pub school_id: SchoolId,
    /// What they may do.
    pub role: Role,
    /// Address, in lower case.
    pub email: String,
    /// Name for people.
    pub display_name: String,
    /// Name for recordings.
    pub pseudonym: String,
    /// Grows with each new password.
    pub credential_version: i64,
    /// Since when they may not sign in.
    pub disabled_at: Option<Moment>,
    /// The language that they have chosen, by its code.
    pub language: Option<String>,
    /// How much is new for them, where that was asked.
    #[sqlx(default)]
    #[sqlx(try_from = "i64")]
    pub news: u32,
    /// The version of their school's logo, where that was asked and it has one.
    #[sqlx(default)]
    pub logo: Option<String>,
}

impl Person {
    /// As the signed-in person, unless disabled. A guest signs in at stations alone.
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

/// A person as every request of their browser needs them.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct BrowsingPerson {
    /// The person.
    #[sqlx(flatten)]
    pub person: Person,
    /// Time zone of their school.
    pub time_zone: String,
    /// Whether they must have a second factor, and have none.
    pub owes_factor: bool,
}

/// A person to be added.
#[derive(Clone, Debug)]
pub struct NewPerson<'a> {
    /// Their school.
    pub school_id: SchoolId,
    /// What they may do.
    pub role: Role,
    /// Address; kept in lower case.
    pub email: &'a str,
    /// Name for people.
    pub display_name: &'a str,
    /// Argon2id hash in PHC form; empty for somebody who is to set a password by a link.
    pub password_hash: &'a str,
}

/// What signing in compares with.
#[derive(Clone, Debug, FromRow)]
pub struct Credentials {
    /// Whose.
    pub id: PersonId,
    /// Argon2id hash in PHC form; absent for somebody who was invited and has none yet.
    pub password_hash: Option<String>,
    /// Kept in the signed-in session; a newer one ends it.
    pub credential_version: i64,
    /// Since when they may not sign in.
    pub disabled_at: Option<Moment>,
    /// Until when the password is good, for one sign-in, where somebody else has set it; absent where it is their own.
    pub initial_until: Option<Moment>,
}

/// Adds a person with a fresh pseudonym.
///
/// # Errors
/// When the address is taken, or the database fails.
pub async fn add_person(writer: &mut Connection, person: &NewPerson<'_>, now: Moment) -> Result<Person> {
    let id = PersonId::made_at(now);
    // The last 48 bits of a UUIDv7 are random: the pseudonym tells neither the name nor the order of enrolment.
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
    .bind(make_search_text(person.display_name, person.email, None))
    .bind(fold_text(person.display_name))
    .fetch_one(writer)
    .await
}

/// Adds a guest: a pseudonym and nothing else. The address leads nowhere, and no password fits.
///
/// # Errors
/// When the database fails.
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

/// How many people there are, in every school.
pub async fn count_people(executor: impl Executor<'_>) -> Result<i64> {
    sqlx::query_scalar("SELECT count(*) FROM people").fetch_one(executor).await
}

/// A person of any school: for the session cookie, which names no school.
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

/// The same as each request of a browser needs them.
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

/// What the registrar knows somebody by, where that is known.
pub async fn find_registrar_id(executor: impl Executor<'_>, school: SchoolId, id: PersonId) -> Result<Option<String>> {
    let found: Option<Option<String>> =
        sqlx::query_scalar("SELECT registrar_id FROM people WHERE school_id = $1 AND id = $2")
            .bind(school)
            .bind(id)
            .fetch_optional(executor)
            .await?;
    Ok(found.flatten())
}

/// A person of any school by address, however it is spelled. One that an earlier version has stored in another spelling is found by that,
/// and comes first.
pub async fn find_person_by_email(executor: impl Executor<'_>, email: &str) -> Result<Option<Person>> {
    sqlx::query_as(
        "SELECT id, school_id, role, email, display_name, pseudonym, credential_version, disabled_at, language
         FROM people WHERE email IN ($1, $2, $3) ORDER BY email <> $1 LIMIT 1",
    )
    .bind(email.to_lowercase())
    .bind(normalize_email(email))
    .bind(email_in_ascii(&normalize_email(email)))
    .fetch_optional(executor)
    .await
}

/// A person of a school by pseudonym.
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

/// Whether a person's recordings may be kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct RecordingConsent {
    /// They were erased.
    pub is_erased: bool,
    /// A guest who has agreed to no study, or has withdrawn.
    pub is_missing: bool,
}

/// Whether recordings of a person may be kept.
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

/// What signing in with an address compares with.
pub async fn find_credentials(executor: impl Executor<'_>, email: &str) -> Result<Option<Credentials>> {
    sqlx::query_as(
        "SELECT id, nullif(password_hash, '') AS password_hash, credential_version, disabled_at,
           password_initial_until AS initial_until
         FROM people WHERE email IN ($1, $2, $3) ORDER BY email <> $1 LIMIT 1",
    )
    .bind(email.to_lowercase())
    .bind(normalize_email(email))
    .bind(email_in_ascii(&normalize_email(email)))
    .fetch_optional(executor)
    .await
}

/// Sets a new password, which is their own, and ends every earlier sign-in, link and code. False when there is no such person.
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

/// Makes a person's password one that somebody else has set: good until then, for one sign-in.
pub async fn make_initial(writer: &mut Connection, person: PersonId, until: Moment) -> Result<()> {
    sqlx::query("UPDATE people SET password_initial_until = $2 WHERE id = $1")
        .bind(person)
        .bind(until)
        .execute(writer)
        .await
        .map(drop)
}

/// The language that a person of a school has chosen to read in.
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

/// Sets the language that a person reads in; none for what their browser asks for. False when there is no such person.
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

/// Ends every sign-in of a person in a browser.
pub async fn end_sign_ins(writer: &mut Connection, person: PersonId) -> Result<()> {
    sqlx::query("UPDATE people SET credential_version = credential_version + 1 WHERE id = $1")
        .bind(person)
        .execute(writer)
        .await
        .map(drop)
}

/// Keeps a person from signing in, from now on, and ends every sign-in, link and code. False when they already were.
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
