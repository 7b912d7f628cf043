//! Administrative commands on schools and people, run on the host.

use model::{Moment, PersonKey, Role};
use platform::secret;
use serde_json::json;
use store::Connection;
use store::audit::{Actor, AuditEntry};
use store::auth::tokens;
use store::auth::tokens::{NewToken, TokenHolder};
use store::operations::schools;
use store::operations::schools::School;
use store::people::{self, NewPerson, Person};
use store::training::cohorts;
use store::training::cohorts::{Attribution, Membership};

use crate::auth::tokens::{TokenRequest, checked_name, end};
use crate::people::accounts::INITIAL_PASSWORD_S;
use crate::service::Service;

/// Error of an administrative command.
#[derive(Debug, thiserror::Error)]
pub enum RegistryError {
    /// Invalid arguments: the option, its value, and the allowed values.
    #[error("{0}")]
    Usage(String),
    /// An operation failed.
    #[error(transparent)]
    Work(#[from] anyhow::Error),
}

impl From<store::Error> for RegistryError {
    fn from(error: store::Error) -> Self {
        Self::Work(anyhow::Error::new(error).context("database"))
    }
}

/// A person to add.
#[derive(Clone, Copy, Debug)]
pub struct RegisteredPerson<'a> {
    /// Email address, with which they sign in.
    pub email: &'a str,
    /// Display name.
    pub name: &'a str,
    /// Role.
    pub role: Role,
    /// Name of the school; `None` for the only one.
    pub school: Option<&'a str>,
    /// Name of the cohort to teach or learn in, created if missing.
    pub cohort: Option<&'a str>,
    /// Password for the first sign-in.
    pub password: &'a str,
    /// API token to create, if any.
    pub token: Option<TokenRequest<'a>>,
}

/// A person who was added.
#[derive(Debug)]
pub struct AddedAccount {
    /// The person.
    pub person: Person,
    /// Name of their school.
    pub school: String,
    /// When the initial password expires.
    pub until: Moment,
    /// Their token; only its hash is stored.
    pub token: Option<String>,
}

/// Adds a person with an initial password.
///
/// # Errors
/// Fails if the address is in use, the school is ambiguous, an administrator is to join a cohort,
/// or the database fails.
pub async fn add_person(service: &Service, new: RegisteredPerson<'_>) -> Result<AddedAccount, RegistryError> {
    let password_hash = secret::hash_password(new.password, service.config.password_cost)?;
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    let school = choose_in(&mut tx, new.school, now).await?;
    if people::find_member_by_email(&mut *tx, school.id, new.email).await?.is_some() {
        return Err(RegistryError::Usage(format!(
            "--email: \"{}\"; another person already has this address",
            new.email
        )));
    }
    let row = NewPerson {
        school_id: school.id,
        role: new.role,
        email: new.email,
        display_name: new.name,
        password_hash: &password_hash,
    };
    let person = people::add_person(&mut tx, &row, now).await?;
    let until = now.plus_s(INITIAL_PASSWORD_S);
    people::make_initial(&mut tx, person.id, until).await?;
    AuditEntry::new(person.school_id, Actor::CommandLine, "person.added", person.id)
        .with(json!({ "role": new.role }))
        .append(&mut tx, now)
        .await?;
    if let Some(cohort) = new.cohort {
        join(&mut tx, &person, cohort, now).await?;
    }
    let token = match new.token {
        Some(wanted) => Some(give_in(&mut tx, &person, wanted, now).await?),
        None => None,
    };
    tx.commit().await?;
    Ok(AddedAccount { person, school: school.name, until, token })
}

async fn join(tx: &mut Connection, person: &Person, cohort: &str, now: Moment) -> Result<(), RegistryError> {
    if person.role == Role::Administrator {
        let why = "--cohort: an administrator cannot be in a cohort; leave the option out";
        return Err(RegistryError::Usage(why.to_owned()));
    }
    let cohort = cohorts::find_or_create(tx, person.school_id, cohort, now).await?;
    let membership =
        Membership { school_id: person.school_id, cohort_id: cohort.id, person_id: person.id, role: person.role };
    cohorts::join_cohort(tx, membership, Attribution { by: None, at: now }).await?;
    let entry = AuditEntry::new(person.school_id, Actor::CommandLine, "cohort.joined", person.id);
    Ok(entry.with(json!({ "cohort": cohort.id })).append(tx, now).await?)
}

/// Sets an initial password, which ends all sessions, and returns its expiry.
pub async fn reset_password(service: &Service, person: &Person, password: &str) -> Result<Moment, RegistryError> {
    let hash = secret::hash_password(password, service.config.password_cost)?;
    let now = service.clock.now();
    let until = now.plus_s(INITIAL_PASSWORD_S);
    let mut tx = service.db.write().await?;
    people::set_password(&mut tx, person.id, &hash).await?;
    people::make_initial(&mut tx, person.id, until).await?;
    let entry = AuditEntry::new(person.school_id, Actor::CommandLine, "person.password_reset", person.id);
    entry.append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(until)
}

/// Disables a person and returns the number of tokens revoked; `None` if they were disabled
/// already.
pub async fn disable_person(service: &Service, person: &Person) -> Result<Option<u64>, RegistryError> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    if !people::disable_person(&mut tx, person.id, now).await? {
        return Ok(None);
    }
    let revoked = tokens::revoke_all_tokens(&mut tx, person.id, now).await?;
    AuditEntry::new(person.school_id, Actor::CommandLine, "person.disabled", person.id)
        .with(json!({ "tokens_revoked": revoked }))
        .append(&mut tx, now)
        .await?;
    tx.commit().await?;
    Ok(Some(revoked))
}

/// Creates an API token for a person.
///
/// # Errors
/// Fails if its name is not allowed, or the database fails.
pub async fn give_token(service: &Service, person: &Person, wanted: TokenRequest<'_>) -> Result<String, RegistryError> {
    let mut tx = service.db.write().await?;
    let token = give_in(&mut tx, person, wanted, service.clock.now()).await?;
    tx.commit().await?;
    Ok(token)
}

async fn give_in(
    tx: &mut Connection,
    person: &Person,
    wanted: TokenRequest<'_>,
    now: Moment,
) -> Result<String, RegistryError> {
    let name = checked_name(wanted.name).map_err(|why| RegistryError::Usage(format!("--{why}")))?;
    let token = secret::random_hex()?;
    let owner = PersonKey { school_id: person.school_id, person_id: person.id };
    let new = NewToken { owner, name: &name, expires_at: end(now, wanted.days) };
    let id = tokens::add_personal_token(tx, new, &secret::token_sha256(&token), now).await?;
    AuditEntry::new(person.school_id, Actor::CommandLine, "token.made", id)
        .with(json!({ "person": person.id, "expires_at": new.expires_at }))
        .append(tx, now)
        .await?;
    Ok(token)
}

/// Creates a token for a station of a school.
///
/// # Errors
/// Fails if the school is ambiguous, or the database fails.
pub async fn give_station_token(
    service: &Service,
    school: Option<&str>,
    station: Option<&str>,
) -> Result<String, RegistryError> {
    let (now, token) = (service.clock.now(), secret::random_hex()?);
    let mut tx = service.db.write().await?;
    let school = choose_in(&mut tx, school, now).await?;
    let holder = TokenHolder { school_id: school.id, person_id: None, station: station.map(str::to_owned) };
    let id = tokens::add_station_token(&mut tx, &holder, &secret::token_sha256(&token), now).await?;
    AuditEntry::new(school.id, Actor::CommandLine, "token.made", id)
        .with(json!({ "person": holder.person_id, "station": holder.station }))
        .append(&mut tx, now)
        .await?;
    tx.commit().await?;
    Ok(token)
}

/// Returns the named school, or the only one.
///
/// # Errors
/// Fails if there is no school of this name, or none is named and there is not exactly one, or the
/// database fails.
pub async fn find_school(service: &Service, name: Option<&str>) -> Result<School, RegistryError> {
    let existing = schools::list_schools(service.db.reader()).await?;
    match name {
        Some(name) => existing
            .into_iter()
            .find(|school| school.name == name)
            .ok_or_else(|| RegistryError::Usage(format!("--school: \"{name}\"; no school has this name"))),
        None => only_one(&existing)?.cloned().ok_or_else(|| RegistryError::Usage("there is no school yet".to_owned())),
    }
}

/// Returns the only school, or `None` without any school. Several schools are a usage error.
fn only_one(existing: &[School]) -> Result<Option<&School>, RegistryError> {
    match existing {
        [] => Ok(None),
        [only] => Ok(Some(only)),
        several => {
            let names: Vec<_> = several.iter().map(|school| school.name.as_str()).collect();
            Err(RegistryError::Usage(format!("--school is required; schools: {}", names.join(", "))))
        }
    }
}

/// Returns the named school, or the only one, or, without any school, one named `School`. Creates
/// it if missing.
pub(crate) async fn choose_in(tx: &mut Connection, name: Option<&str>, now: Moment) -> Result<School, RegistryError> {
    let existing = schools::list_schools(&mut *tx).await?;
    let name = match name {
        Some(name) => name,
        None => match only_one(&existing)? {
            Some(only) => return Ok(only.clone()),
            None => "School",
        },
    };
    if let Some(known) = existing.iter().find(|school| school.name == name) {
        return Ok(known.clone());
    }
    let school = schools::find_or_create(tx, name, now).await?;
    AuditEntry::new(school.id, Actor::CommandLine, "school.added", school.id)
        .with(json!({ "name": school.name }))
        .append(tx, now)
        .await?;
    Ok(school)
}
