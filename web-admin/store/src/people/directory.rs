//! Directory of a school's people, for its administrators: search, changes and erasure.

use model::ids::{CohortId, LetterId, PersonId, SchoolId};
use model::people::directory::{AccountState, DirectoryEntry, PeopleKey, PeopleOrder};
use model::people::email::{normalize_email, present_email};
use model::search_key::{fold_text, make_search_text};
use model::{Moment, PersonKey, Role};
use sqlx::FromRow;

use crate::auth::account_links;
use crate::auth::federation::identities;
use crate::{Connection, Executor, Json, Pool, Result};

/// Search criteria.
#[derive(Clone, Debug, Default)]
pub struct Filter {
    /// Case-folded words that must all occur in the person's search text; empty matches all.
    pub words: Vec<String>,
    /// Role.
    pub role: Option<Role>,
    /// State of the account.
    pub state: Option<AccountState>,
    /// Cohort of the person.
    pub cohort: Option<CohortId>,
    /// Sort order.
    pub order: PeopleOrder,
    /// Cursor: the sort key and id of the last person on the previous page.
    pub after: Option<(String, PersonId)>,
}

/// Selects people of school `$1` whose search text contains all words in `$4`, sorted by a key, on
/// one side of the cursor (`$2`, `$3`). If the key is a plain column, SQLite scans its index in
/// order, which is fast if most rows match; if it is an expression, SQLite sorts the matches
/// afterwards. `$9` and `$10` are the first and the last word: testing them first rejects most rows
/// before the more expensive test of the whole list.
macro_rules! people_by {
    ($listed:literal, $key:literal, $side:literal, $order:literal) => {
        concat!(
            $listed,
            " FROM (
               SELECT p.id, p.display_name AS name, p.email, p.role, p.pseudonym, p.registrar_id, ",
            $key,
            " AS sorted,
                 CASE WHEN p.erased_at IS NOT NULL THEN 'erased' WHEN p.disabled_at IS NOT NULL THEN 'disabled'
                      WHEN p.password_hash = '' AND NOT EXISTS (
                      SELECT 1 FROM identities i WHERE i.school_id = p.school_id AND i.person_id = p.id) THEN 'invited' ELSE 'active' END AS state,
                 coalesce((SELECT string_agg(c.name, ', ') FROM cohort_members m JOIN cohorts c ON c.id = m.cohort_id
                           WHERE m.person_id = p.id), '') AS cohorts
               FROM people p
               WHERE p.school_id = $1 AND p.role <> 'guest' AND (",
            $key,
            ", p.id) ",
            $side,
            " ($2, $3)
                 AND instr(p.search, $9) > 0 AND instr(p.search, $10) > 0
                 AND NOT EXISTS (SELECT 1 FROM json_each($4) w WHERE instr(p.search, w.value) = 0)
                 AND ($5 IS NULL OR p.role = $5)
                 AND ($6 IS NULL OR EXISTS (SELECT 1 FROM cohort_members m WHERE m.cohort_id = $6
                 AND m.person_id = p.id))) listed
             WHERE $7 IS NULL OR state = $7 ORDER BY ",
            $order,
            " LIMIT $8 + 0"
        )
    };
}

/// A string that sorts after every key.
const LAST_KEY: &str = "\u{10FFFF}";

/// Returns people in the requested order.
pub async fn list_people(
    executor: impl Executor<'_>,
    school: SchoolId,
    filter: &Filter,
    limit: u32,
) -> Result<Vec<DirectoryEntry>> {
    let PeopleOrder { by, down } = filter.order;
    let word = filter.words.first();
    let statement = match (word, by, down) {
        (None, PeopleKey::Name, false) => people_by!("SELECT *", "p.sort_name", ">", "sorted, id"),
        (None, PeopleKey::Name, true) => people_by!("SELECT *", "p.sort_name", "<", "sorted DESC, id DESC"),
        (None, PeopleKey::Email, false) => people_by!("SELECT *", "p.email", ">", "sorted, id"),
        (None, PeopleKey::Email, true) => people_by!("SELECT *", "p.email", "<", "sorted DESC, id DESC"),
        (None, PeopleKey::Number, false) => people_by!("SELECT *", "p.sort_number", ">", "sorted, id"),
        (None, PeopleKey::Number, true) => people_by!("SELECT *", "p.sort_number", "<", "sorted DESC, id DESC"),
        (Some(_), PeopleKey::Name, false) => people_by!("SELECT listed.*", "p.sort_name || ''", ">", "sorted, id"),
        (Some(_), PeopleKey::Name, true) => {
            people_by!("SELECT listed.*", "p.sort_name || ''", "<", "sorted DESC, id DESC")
        }
        (Some(_), PeopleKey::Email, false) => people_by!("SELECT listed.*", "p.email || ''", ">", "sorted, id"),
        (Some(_), PeopleKey::Email, true) => {
            people_by!("SELECT listed.*", "p.email || ''", "<", "sorted DESC, id DESC")
        }
        (Some(_), PeopleKey::Number, false) => people_by!("SELECT listed.*", "p.sort_number || ''", ">", "sorted, id"),
        (Some(_), PeopleKey::Number, true) => {
            people_by!("SELECT listed.*", "p.sort_number || ''", "<", "sorted DESC, id DESC")
        }
    };
    let first = || (if down { LAST_KEY } else { "" }.to_owned(), PersonId::nil());
    let (key, id) = filter.after.clone().unwrap_or_else(first);
    sqlx::query_as(statement)
        .bind(school)
        .bind(key)
        .bind(id)
        .bind(Json(&filter.words))
        .bind(filter.role)
        .bind(filter.cohort)
        .bind(filter.state)
        .bind(i64::from(limit))
        .bind(word.map_or("", String::as_str))
        .bind(filter.words.last().map_or("", String::as_str))
        .fetch_all(executor)
        .await
}

/// Returns the people of a school with these ids, sorted by name. Guests and people of other
/// schools are left out.
pub async fn list_people_by_id(
    executor: impl Executor<'_>,
    school: SchoolId,
    ids: &[PersonId],
) -> Result<Vec<DirectoryEntry>> {
    sqlx::query_as(
        "SELECT p.id, p.display_name AS name, p.email, p.role, p.pseudonym, p.registrar_id,
           CASE WHEN p.erased_at IS NOT NULL THEN 'erased' WHEN p.disabled_at IS NOT NULL THEN 'disabled'
                WHEN p.password_hash = '' AND NOT EXISTS (
                      SELECT 1 FROM identities i WHERE i.school_id = p.school_id AND i.person_id = p.id) THEN 'invited' ELSE 'active' END AS state,
           coalesce((SELECT string_agg(c.name, ', ') FROM cohort_members m JOIN cohorts c ON c.id = m.cohort_id
                     WHERE m.person_id = p.id), '') AS cohorts
         FROM (SELECT DISTINCT value FROM json_each($2)) asked CROSS JOIN people p
         WHERE p.id = unhex(asked.value, '-') AND p.school_id = $1 AND p.role <> 'guest' ORDER BY p.sort_name, p.id",
    )
    .bind(school)
    .bind(Json(ids))
    .fetch_all(executor)
    .await
}

/// Fills the search and sort columns for accounts created before these columns existed.
pub(crate) async fn fill_search_texts(writer: &Pool) -> Result<()> {
    #[derive(FromRow)]
    struct Unsorted {
        id: PersonId,
        display_name: String,
        email: String,
        registrar_id: Option<String>,
    }
    let mut tx = writer.begin().await?;
    let unsorted: Vec<Unsorted> = sqlx::query_as(
        "SELECT id, display_name, email, registrar_id FROM people WHERE sort_name = '' AND role <> 'guest'",
    )
    .fetch_all(&mut *tx)
    .await?;
    for person in unsorted {
        let search = make_search_text(
            &person.display_name,
            present_email(&person.email).unwrap_or_default(),
            person.registrar_id.as_deref(),
        );
        sqlx::query("UPDATE people SET search = $2, sort_name = $3 WHERE id = $1")
            .bind(person.id)
            .bind(search)
            .bind(fold_text(&person.display_name))
            .execute(&mut *tx)
            .await?;
    }
    tx.commit().await
}

/// Returns a person of a school, unless they are a guest.
pub async fn find_directory_entry(
    executor: impl Executor<'_>,
    school: SchoolId,
    id: PersonId,
) -> Result<Option<DirectoryEntry>> {
    Ok(find_anybody(executor, school, id).await?.filter(|person| person.role != Role::Guest))
}

/// Returns a person of a school, including guests of studies.
pub async fn find_anybody(
    executor: impl Executor<'_>,
    school: SchoolId,
    id: PersonId,
) -> Result<Option<DirectoryEntry>> {
    sqlx::query_as(
        "SELECT p.id, p.display_name AS name, p.email, p.role, p.pseudonym, p.registrar_id,
           CASE WHEN p.erased_at IS NOT NULL THEN 'erased' WHEN p.disabled_at IS NOT NULL THEN 'disabled'
                WHEN p.password_hash = '' AND NOT EXISTS (
                      SELECT 1 FROM identities i WHERE i.school_id = p.school_id AND i.person_id = p.id) THEN 'invited' ELSE 'active' END AS state,
           coalesce((SELECT string_agg(c.name, ', ') FROM cohort_members m JOIN cohorts c ON c.id = m.cohort_id
                     WHERE m.person_id = p.id), '') AS cohorts
         FROM people p WHERE p.school_id = $1 AND p.id = $2",
    )
    .bind(school)
    .bind(id)
    .fetch_optional(executor)
    .await
}

/// Whom the registrar of a school knows by a number.
pub async fn find_number_holder(
    executor: impl Executor<'_>,
    school: SchoolId,
    number: &str,
) -> Result<Option<PersonId>> {
    sqlx::query_scalar("SELECT id FROM people WHERE school_id = $1 AND registrar_id = $2")
        .bind(school)
        .bind(number)
        .fetch_optional(executor)
        .await
}

/// Who somebody is said to be.
#[derive(Clone, Copy, Debug)]
pub struct Details<'a> {
    /// Name.
    pub name: &'a str,
    /// Email address.
    pub email: &'a str,
    /// Registration number; `None` leaves the stored number unchanged.
    pub registrar_id: Option<&'a str>,
}

/// Changes a person's details. A change of the email address deletes all links and sign-in codes.
///
/// # Errors
/// If the email address or the registration number is already in use, or the database fails.
pub async fn change_details(
    writer: &mut Connection,
    school: SchoolId,
    id: PersonId,
    details: Details<'_>,
) -> Result<()> {
    let known: Option<(bool, Option<String>)> =
        sqlx::query_as("SELECT email <> $3, registrar_id FROM people WHERE school_id = $1 AND id = $2")
            .bind(school)
            .bind(id)
            .bind(normalize_email(details.email))
            .fetch_optional(&mut *writer)
            .await?;
    let Some((moved, number)) = known else { return Ok(()) };
    if moved {
        account_links::end_account_links(writer, id).await?;
    }
    let number = details.registrar_id.or(number.as_deref());
    sqlx::query(
        "UPDATE people SET display_name = $3, email = $4, search = $5, sort_name = $6, registrar_id = $7
         WHERE school_id = $1 AND id = $2",
    )
    .bind(school)
    .bind(id)
    .bind(details.name)
    .bind(normalize_email(details.email))
    .bind(make_search_text(details.name, present_email(details.email).unwrap_or_default(), number))
    .bind(fold_text(details.name))
    .bind(number)
    .execute(writer)
    .await
    .map(drop)
}

/// Changes a person's role and removes the person from all cohorts: a promoted trainee must not
/// teach their former cohort.
pub async fn change_role(writer: &mut Connection, school: SchoolId, id: PersonId, role: Role) -> Result<()> {
    sqlx::query("UPDATE people SET role = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .bind(role)
        .execute(&mut *writer)
        .await?;
    leave_all_cohorts(writer, school, id).await
}

async fn leave_all_cohorts(writer: &mut Connection, school: SchoolId, id: PersonId) -> Result<()> {
    sqlx::query("DELETE FROM cohort_members WHERE school_id = $1 AND person_id = $2")
        .bind(school)
        .bind(id)
        .execute(writer)
        .await
        .map(drop)
}

/// Enables a disabled account. Returns false if it was not disabled, or is erased.
pub async fn enable_account(writer: &mut Connection, school: SchoolId, id: PersonId) -> Result<bool> {
    sqlx::query(
        "UPDATE people SET disabled_at = NULL
         WHERE school_id = $1 AND id = $2 AND disabled_at IS NOT NULL AND erased_at IS NULL",
    )
    .bind(school)
    .bind(id)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Returns the ids of all letters to a person, sent or not.
pub async fn list_letters_to(
    executor: impl Executor<'_>,
    person: &DirectoryEntry,
    school: SchoolId,
) -> Result<Vec<LetterId>> {
    sqlx::query_scalar(
        "SELECT id FROM mails WHERE school_id = $1 AND person_id = $2
         UNION ALL SELECT id FROM survey_letters WHERE school_id = $1 AND email = $3
         UNION ALL SELECT id FROM retention_warnings WHERE person_id = $2",
    )
    .bind(school)
    .bind(person.id)
    .bind(&person.email)
    .fetch_all(executor)
    .await
}

/// Erases a person's identity. Attempts and scores stay under the pseudonym.
pub async fn erase_person(
    writer: &mut Connection,
    person: &DirectoryEntry,
    school: SchoolId,
    now: Moment,
) -> Result<()> {
    let email = format!("{}@erased.invalid", person.pseudonym);
    account_links::end_account_links(writer, person.id).await?;
    account_links::forget_asked(writer, &person.email).await?;
    sqlx::query("DELETE FROM provisioned_people WHERE school_id = $1 AND person_id = $2")
        .bind(school)
        .bind(person.id)
        .execute(&mut *writer)
        .await?;
    identities::remove_identities(writer, PersonKey { school_id: school, person_id: person.id }).await?;
    sqlx::query("DELETE FROM mails WHERE school_id = $1 AND person_id = $2")
        .bind(school)
        .bind(person.id)
        .execute(&mut *writer)
        .await?;
    sqlx::query("DELETE FROM support_notes WHERE school_id = $1 AND person_id = $2")
        .bind(school)
        .bind(person.id)
        .execute(&mut *writer)
        .await?;
    sqlx::query("DELETE FROM notices WHERE school_id = $1 AND person_id = $2")
        .bind(school)
        .bind(person.id)
        .execute(&mut *writer)
        .await?;
    // Letters with a survey link carry no person id, but their address identifies the person.
    sqlx::query("DELETE FROM survey_letters WHERE school_id = $1 AND email = $2")
        .bind(school)
        .bind(&person.email)
        .execute(&mut *writer)
        .await?;
    // An uploaded roster that waits for confirmation may contain any person's data.
    sqlx::query("DELETE FROM rosters WHERE school_id = $1").bind(school).execute(&mut *writer).await?;
    sqlx::query(
        "UPDATE people SET display_name = pseudonym, sort_name = pseudonym, email = $3, search = $4, registrar_id = NULL, password_hash = '',
           credential_version = credential_version + 1, disabled_at = coalesce(disabled_at, $5), erased_at = $5
         WHERE school_id = $1 AND id = $2",
    )
    .bind(school)
    .bind(person.id)
    .bind(&email)
    .bind(make_search_text(&person.pseudonym, "", None))
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the time at which the account was created.
pub async fn find_creation_time(executor: impl Executor<'_>, school: SchoolId, id: PersonId) -> Result<Option<Moment>> {
    sqlx::query_scalar("SELECT created_at FROM people WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .fetch_optional(executor)
        .await
}
