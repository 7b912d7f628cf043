//! What whoever has the machine does to schools and people on its command line.

use model::{Moment, PersonKey, Role};
use serde_json::json;
use store::Connection;
use store::audit::{Actor, AuditEntry};
use store::cohorts::{self, Deed, Membership};
use store::people::{self, NewPerson, Person};
use store::schools::{self, School};
use store::tokens::{self, NewToken, TokenHolder};

use crate::accounts::INITIAL_PASSWORD_S;
use crate::secret;
use crate::service::Service;
use crate::tokens::{TokenRequest, checked_name, end};

/// Why something was not done.
#[derive(Debug, thiserror::Error)]
pub enum RegistryError {
    /// What was asked for makes no sense: the option, what it says, and what is allowed.
    #[error("{0}")]
    Usage(String),
    /// The work failed.
    #[error(transparent)]
    Work(#[from] anyhow::Error),
}

impl From<store::Error> for RegistryError {
    fn from(error: store::Error) -> Self {
        Self::Work(anyhow::Error::new(error).context("database"))
    }
}

/// A person to be added.
#[derive(Clone, Copy, Debug)]
pub struct RegisteredPerson<'a> {
    /// Address they sign in with.
    pub email: &'a str,
    /// Name shown to people.
    pub name: &'a str,
    /// What they may do.
    pub role: Role,
    /// The school; the only one there is where none is named.
    pub school: Option<&'a str>,
    /// Cohort to teach or to learn in, made where it is missing.
    pub cohort: Option<&'a str>,
    /// Password for the first sign-in.
    pub password: &'a str,
    /// A token for the API, where one is wanted.
    pub token: Option<TokenRequest<'a>>,
}

/// A person who was added.
#[derive(Debug)]
pub struct AddedAccount {
    /// Who.
    pub person: Person,
    /// Their school's name.
    pub school: String,
    /// Until when their password signs them in.
    pub until: Moment,
    /// Their token, which nobody sees again.
    pub token: Option<String>,
}

/// Adds a person with a password for their first sign-in.
///
/// # Errors
/// When somebody has the address, the school is not clear, the cohort is none for them, or the database fails.
pub async fn add_person(service: &Service, new: RegisteredPerson<'_>) -> Result<AddedAccount, RegistryError> {
    let password_hash = secret::hash_password(new.password, service.config.password_cost)?;
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    if people::find_person_by_email(&mut *tx, new.email).await?.is_some() {
        return Err(RegistryError::Usage(format!("--email: \"{}\"; somebody has this address already", new.email)));
    }
    let school = choose_in(&mut tx, new.school, now).await?;
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
        let why = "--cohort: an administrator neither teaches nor learns; leave it out";
        return Err(RegistryError::Usage(why.to_owned()));
    }
    let cohort = cohorts::find_or_create(tx, person.school_id, cohort, now).await?;
    let membership =
        Membership { school_id: person.school_id, cohort_id: cohort.id, person_id: person.id, role: person.role };
    cohorts::join_cohort(tx, membership, Deed { by: None, at: now }).await?;
    let entry = AuditEntry::new(person.school_id, Actor::CommandLine, "cohort.joined", person.id);
    Ok(entry.with(json!({ "cohort": cohort.id })).append(tx, now).await?)
}

/// Sets a password for one sign-in, which ends every earlier one; until when it is good.
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

/// Keeps a person from signing in; how many of their tokens were revoked, none where they were disabled before.
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

/// Makes a token for a person.
///
/// # Errors
/// When its name is none, or the database fails.
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

/// Makes a token for a station of a school.
///
/// # Errors
/// When the school is not clear, or the database fails.
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

/// The named school, or the only one there is.
///
/// # Errors
/// When there is none of the name, or none is named and there are several; or the database fails.
pub async fn find_school(service: &Service, name: Option<&str>) -> Result<School, RegistryError> {
    let existing = schools::list_schools(service.db.reader()).await?;
    match name {
        Some(name) => existing
            .into_iter()
            .find(|school| school.name == name)
            .ok_or_else(|| RegistryError::Usage(format!("--school: \"{name}\"; there is no school of this name"))),
        None => only_one(&existing)?.cloned().ok_or_else(|| RegistryError::Usage("there is no school yet".to_owned())),
    }
}

/// The only school there is, or none.
fn only_one(existing: &[School]) -> Result<Option<&School>, RegistryError> {
    match existing {
        [] => Ok(None),
        [only] => Ok(Some(only)),
        several => {
            let names: Vec<_> = several.iter().map(|school| school.name.as_str()).collect();
            Err(RegistryError::Usage(format!("--school is needed; there are: {}", names.join(", "))))
        }
    }
}

/// The named school; the only one there is where none is named; a first one where there is none. Made where it is missing.
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
