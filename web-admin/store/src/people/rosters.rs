//! Uploaded rosters waiting for confirmation, and the queries of the import.

use std::collections::{BTreeMap, BTreeSet};

use model::ids::{PersonId, RosterId, SchoolId};
use model::people::roster::{KnownMember, RosterEntry, RosterMapping, RosterRequest, SchoolPerson};
use model::{Moment, Role};
use sqlx::FromRow;

use crate::people::directory;
use crate::{Connection, Executor, Json, Result, people};

/// A roster waiting for confirmation.
#[derive(Clone, Debug, FromRow)]
pub struct RosterDraft {
    /// Original name of the file.
    pub file_name: String,
    /// Content of the file.
    pub body: Vec<u8>,
    /// Requested changes.
    pub wanted: Json<RosterRequest>,
    /// Time of the upload.
    pub made_at: Moment,
}

/// A roster to be stored.
#[derive(Clone, Debug)]
pub struct NewRosterDraft<'a> {
    /// School.
    pub school_id: SchoolId,
    /// Person who uploaded it.
    pub made_by: PersonId,
    /// Original name of the file.
    pub file_name: &'a str,
    /// Content of the file.
    pub body: &'a [u8],
    /// Requested changes.
    pub wanted: &'a RosterRequest,
}

/// Stores a roster until it is confirmed.
pub async fn keep_roster(writer: &mut Connection, draft: &NewRosterDraft<'_>, now: Moment) -> Result<RosterId> {
    let id = RosterId::made_at(now);
    sqlx::query(
        "INSERT INTO rosters (id, school_id, made_by, file_name, body, wanted, made_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7)",
    )
    .bind(id)
    .bind(draft.school_id)
    .bind(draft.made_by)
    .bind(draft.file_name)
    .bind(draft.body)
    .bind(Json(draft.wanted))
    .bind(now)
    .execute(writer)
    .await?;
    Ok(id)
}

/// Returns a stored roster of a school.
pub async fn find_roster(executor: impl Executor<'_>, school: SchoolId, id: RosterId) -> Result<Option<RosterDraft>> {
    sqlx::query_as("SELECT file_name, body, wanted, made_at FROM rosters WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .fetch_optional(executor)
        .await
}

/// Replaces the requested changes of a stored roster. Returns false if it does not exist.
pub async fn change_roster_request(
    writer: &mut Connection,
    school: SchoolId,
    id: RosterId,
    wanted: &RosterRequest,
) -> Result<bool> {
    sqlx::query("UPDATE rosters SET wanted = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .bind(Json(wanted))
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Returns the column mapping that was chosen at a school for files with these headings, if there
/// is one.
pub async fn find_roster_mapping(
    executor: impl Executor<'_>,
    school: SchoolId,
    headings_sha256: &[u8; 32],
) -> Result<Option<RosterMapping>> {
    let mapping: Option<Json<RosterMapping>> =
        sqlx::query_scalar("SELECT mapping FROM roster_mappings WHERE school_id = $1 AND headings_sha256 = $2")
            .bind(school)
            .bind(headings_sha256.as_slice())
            .fetch_optional(executor)
            .await?;
    Ok(mapping.map(|Json(mapping)| mapping))
}

/// Stores the column mapping chosen at a school for files with these headings.
pub async fn remember_roster_mapping(
    writer: &mut Connection,
    school: SchoolId,
    headings_sha256: &[u8; 32],
    mapping: &RosterMapping,
    now: Moment,
) -> Result<()> {
    sqlx::query(
        "INSERT INTO roster_mappings (school_id, headings_sha256, mapping, changed_at) VALUES ($1, $2, $3, $4)
         ON CONFLICT (school_id, headings_sha256) DO UPDATE SET mapping = excluded.mapping, changed_at = excluded.changed_at",
    )
    .bind(school)
    .bind(headings_sha256.as_slice())
    .bind(Json(mapping))
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Deletes a roster. Returns false if it does not exist.
pub async fn discard_roster(writer: &mut Connection, school: SchoolId, id: RosterId) -> Result<bool> {
    sqlx::query("DELETE FROM rosters WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Deletes rosters that were uploaded before `moment` and never confirmed.
pub async fn forget_before(writer: &mut Connection, moment: Moment) -> Result<()> {
    sqlx::query("DELETE FROM rosters WHERE made_at < $1").bind(moment).execute(writer).await.map(drop)
}

#[derive(FromRow)]
struct KnownRow {
    id: PersonId,
    registrar_id: Option<String>,
    email: String,
    display_name: String,
    role: Role,
    enabled: bool,
}

impl KnownRow {
    fn with_cohorts(self, cohorts: Vec<String>) -> SchoolPerson {
        SchoolPerson {
            cohorts,
            id: self.id,
            registrar_id: self.registrar_id,
            email: self.email,
            name: self.display_name,
            role: self.role,
            enabled: self.enabled,
        }
    }
}

/// Criteria for the people that a roster may concern.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct About {
    /// Email addresses.
    pub emails: BTreeSet<String>,
    /// Registration numbers.
    pub numbers: BTreeSet<String>,
    /// Names of cohorts.
    pub cohorts: BTreeSet<String>,
}

/// Returns the people of a school who match any of the criteria, with their cohorts. Erased people
/// are left out.
pub async fn list_known_people(
    connection: &mut Connection,
    school: SchoolId,
    about: &About,
) -> Result<Vec<SchoolPerson>> {
    let rows: Vec<KnownRow> = sqlx::query_as(
        "SELECT p.id, p.registrar_id, p.email, p.display_name, p.role, p.disabled_at IS NULL AS enabled
         FROM (SELECT e.id FROM json_each($2) asked CROSS JOIN people e
           WHERE e.email = asked.value
           UNION SELECT n.id FROM json_each($3) asked
             CROSS JOIN people n
           WHERE n.school_id = $1 AND n.registrar_id = asked.value
           UNION SELECT m.person_id FROM json_each($4) asked
             CROSS JOIN cohorts c
             CROSS JOIN cohort_members m WHERE m.cohort_id = c.id AND c.school_id = $1 AND c.name = asked.value) named
         CROSS JOIN people p
         WHERE p.school_id = $1 AND p.id = named.id AND p.erased_at IS NULL ORDER BY p.display_name, p.id",
    )
    .bind(school)
    .bind(Json(&about.emails))
    .bind(Json(&about.numbers))
    .bind(Json(&about.cohorts))
    .fetch_all(&mut *connection)
    .await?;
    let mut cohorts = list_cohorts_of(connection, school, rows.iter().map(|row| row.id).collect()).await?;
    let person = |row: KnownRow| {
        let cohorts = cohorts.remove(&row.id).unwrap_or_default();
        row.with_cohorts(cohorts)
    };
    Ok(rows.into_iter().map(person).collect())
}

/// Returns the names of the cohorts of people.
async fn list_cohorts_of(
    connection: &mut Connection,
    school: SchoolId,
    ids: Vec<PersonId>,
) -> Result<BTreeMap<PersonId, Vec<String>>> {
    let memberships: Vec<(PersonId, String)> = sqlx::query_as(
        "SELECT m.person_id, c.name FROM json_each($2) asked
         CROSS JOIN cohort_members m
         CROSS JOIN cohorts c WHERE c.school_id = $1 AND c.id = m.cohort_id
         AND m.person_id = unhex(asked.value, '-') ORDER BY c.name",
    )
    .bind(school)
    .bind(Json(&ids))
    .fetch_all(connection)
    .await?;
    let mut cohorts: BTreeMap<PersonId, Vec<String>> = BTreeMap::new();
    for (person, cohort) in memberships {
        cohorts.entry(person).or_default().push(cohort);
    }
    Ok(cohorts)
}

/// Criteria for the people who may be members of a course of a learning platform.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AboutMembers<'a> {
    /// Issuer of the identities.
    pub issuer: &'a str,
    /// Ids at the platform.
    pub subjects: BTreeSet<&'a str>,
    /// Registration numbers.
    pub numbers: BTreeSet<&'a str>,
    /// Name of the cohort that is compared.
    pub cohort: Option<&'a str>,
}

#[derive(FromRow)]
struct KnownMemberRow {
    #[sqlx(flatten)]
    known: KnownRow,
    subject: Option<String>,
}

/// Returns the people of a school who match any of the criteria, with their cohorts and identities. A
/// person with several identities is repeated. Erased people are left out.
pub async fn list_known_members(
    connection: &mut Connection,
    school: SchoolId,
    about: &AboutMembers<'_>,
) -> Result<Vec<KnownMember>> {
    let rows: Vec<KnownMemberRow> = sqlx::query_as(
        "SELECT p.id, p.registrar_id, p.email, p.display_name, p.role, p.disabled_at IS NULL AS enabled, i.subject
         FROM (SELECT o.person_id AS id FROM json_each($3) asked CROSS JOIN identities o
           WHERE o.school_id = $1 AND o.kind = 'lti' AND o.issuer = $2 AND o.subject = asked.value
           UNION SELECT n.id FROM json_each($4) asked
             CROSS JOIN people n
           WHERE n.school_id = $1 AND n.registrar_id = asked.value
           UNION SELECT m.person_id FROM cohorts c
             CROSS JOIN cohort_members m WHERE m.cohort_id = c.id AND c.school_id = $1 AND c.name = $5) named
         CROSS JOIN people p
         LEFT JOIN identities i ON i.school_id = $1 AND i.person_id = p.id AND i.kind = 'lti' AND i.issuer = $2
         WHERE p.school_id = $1 AND p.id = named.id AND p.erased_at IS NULL ORDER BY p.display_name, p.id, i.subject",
    )
    .bind(school)
    .bind(about.issuer)
    .bind(Json(&about.subjects))
    .bind(Json(&about.numbers))
    .bind(about.cohort)
    .fetch_all(&mut *connection)
    .await?;
    let cohorts = list_cohorts_of(connection, school, rows.iter().map(|row| row.known.id).collect()).await?;
    let member = |KnownMemberRow { known, subject }: KnownMemberRow| {
        let of = cohorts.get(&known.id).cloned().unwrap_or_default();
        KnownMember { person: known.with_cohorts(of), subject }
    };
    Ok(rows.into_iter().map(member).collect())
}

/// Adds the person of a roster line, without a password.
///
/// # Errors
/// If the email address or the registration number is already in use, or the database fails.
pub async fn enrol_person(
    writer: &mut Connection,
    school: SchoolId,
    entry: &RosterEntry,
    now: Moment,
) -> Result<PersonId> {
    let new = people::NewPerson {
        school_id: school,
        role: entry.role.unwrap_or(Role::Trainee),
        email: &entry.email,
        display_name: &entry.name,
        password_hash: "",
    };
    let person = people::add_person(writer, &new, now).await?;
    if let Some(number) = &entry.registrar_id {
        let details =
            directory::Details { name: &entry.name, email: &entry.email, registrar_id: Some(number.as_str()) };
        directory::change_details(writer, school, person.id, details).await?;
    }
    Ok(person.id)
}
