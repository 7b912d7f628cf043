//! Which person an identity belongs to: found, matched, joined, or created.

use model::auth::federation::{IdentityKind, IdentityOrigin, ProvenIdentity};
use model::auth::sign_in_refusal::SignInRefusal;
use model::ids::{IdentityId, PersonId, SchoolId};
use model::letters::mail::MailKind;
use model::people::email::make_absent_email;
use model::people::roster::MemberIdentity;
use model::{CurrentPerson, Moment, PersonKey, new_id};
use serde_json::json;
use store::audit::{Actor, AuditEntry};
use store::auth::federation::identities;
use store::auth::federation::identities::{IssuedSubject, NewIdentity};
use store::letters::mails::{self, NewMail};
use store::people::directory::{self, Details};
use store::people::{self, NewPerson, Person};
use store::{Connection, Write};

use super::sources::{self, IdentitySource};
use crate::error::Error;
use crate::service::Service;

fn subject_of<'a>(source: &IdentitySource, identity: &'a ProvenIdentity) -> IssuedSubject<'a> {
    IssuedSubject {
        school_id: source.school_id,
        kind: source.id.kind(),
        issuer: &identity.issuer,
        subject: &identity.subject,
    }
}

/// Returns the person of an identity: by the identity, by the registration number, by a verified
/// address, or a new one if the source creates accounts and no account has the address. Otherwise
/// `None`: the person joins an account, or begins one.
///
/// # Errors
/// Fails if the database fails. The inner error is the reason of a refusal, which is in the audit
/// log.
pub async fn find_owner(
    service: &Service,
    source: &IdentitySource,
    identity: &ProvenIdentity,
) -> Result<Result<Option<Person>, SignInRefusal>, Error> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    let owner = match identities::use_identity(&mut tx, subject_of(source, identity), now).await? {
        Some(known) => people::find_person(&mut *tx, known).await?,
        None => match match_person(&mut tx, source, identity).await? {
            Some(matched) if matched.disabled_at.is_none() => {
                join(&mut tx, &Joining { source, identity, person: &matched, at: now }, IdentityOrigin::Matched)
                    .await?;
                Some(matched)
            }
            Some(disabled) => Some(disabled),
            None if source.creates_trainees && !is_address_taken(&mut tx, source.school_id, identity).await? => {
                Some(create(&mut tx, source, identity, now).await?)
            }
            None => None,
        },
    };
    tx.commit().await?;
    service.mails.notify_one();
    match owner {
        Some(person) if person.disabled_at.is_some() => sources::refuse(service, source, SignInRefusal::Disabled).await,
        owner => Ok(Ok(owner)),
    }
}

async fn match_person(
    tx: &mut Connection,
    source: &IdentitySource,
    identity: &ProvenIdentity,
) -> Result<Option<Person>, Error> {
    let (school, issuer) = (source.school_id, identity.issuer.as_str());
    let mut found = None;
    if let Some(number) = &identity.number {
        found = identities::find_unlinked_by_number(&mut *tx, school, issuer, number).await?;
    }
    if let Some(email) = identity.email.as_deref().filter(|_| identity.email_verified && found.is_none()) {
        found = identities::find_unlinked_by_email(&mut *tx, school, issuer, email).await?;
    }
    match found {
        Some(person) => Ok(people::find_person(tx, person).await?),
        None => Ok(None),
    }
}

async fn is_address_taken(tx: &mut Connection, school: SchoolId, identity: &ProvenIdentity) -> Result<bool, Error> {
    match &identity.email {
        Some(email) => Ok(people::find_member_by_email(tx, school, email).await?.is_some()),
        None => Ok(false),
    }
}

/// An identity that becomes a person's.
struct Joining<'a> {
    source: &'a IdentitySource,
    identity: &'a ProvenIdentity,
    person: &'a Person,
    at: Moment,
}

async fn join(tx: &mut Connection, joining: &Joining<'_>, how: IdentityOrigin) -> Result<(), Error> {
    let Joining { source, identity, person, at } = joining;
    let new = NewIdentity {
        id: IdentityId::made_at(*at),
        person_id: person.id,
        of: subject_of(source, identity),
        how,
        made_by: (how == IdentityOrigin::Joined).then_some(person.id),
        at: *at,
    };
    if !identities::add_identity(tx, new).await? {
        let why = tr!("this account of your school’s system belongs to another account here");
        return Err(Error::Conflict(why.to_owned()));
    }
    let mut details = source.id.details("how", json!(how));
    details["identity"] = json!(new.id);
    AuditEntry::new(person.school_id, Actor::Person(person.id), "identity.added", person.id)
        .with(details)
        .append(tx, *at)
        .await?;
    if how != IdentityOrigin::Created {
        let kind = MailKind::IdentityJoined;
        let mail = NewMail { school_id: person.school_id, person_id: person.id, kind, assignment_id: None };
        mails::queue_mail(tx, mail, *at).await?;
    }
    Ok(())
}

/// Creates an account for an identity. An address that another account of the school has is not stored.
async fn create(
    tx: &mut Connection,
    source: &IdentitySource,
    identity: &ProvenIdentity,
    at: Moment,
) -> Result<Person, Error> {
    let school_id = source.school_id;
    let email = match &identity.email {
        Some(email) if people::find_member_by_email(&mut *tx, school_id, email).await?.is_none() => email.clone(),
        _ => make_absent_email(new_id(at)),
    };
    let new =
        NewPerson { school_id, role: identity.role, email: &email, display_name: &identity.name, password_hash: "" };
    let person = people::add_person(tx, &new, at).await?;
    if let Some(number) = identity.number.as_deref()
        && directory::find_number_holder(&mut *tx, school_id, number).await?.is_none()
    {
        let details = Details { name: &identity.name, email: &email, registrar_id: Some(number) };
        directory::change_details(tx, school_id, person.id, details).await?;
    }
    AuditEntry::new(school_id, Actor::Person(person.id), "person.added", person.id)
        .with(source.id.details("role", json!(identity.role)))
        .append(tx, at)
        .await?;
    join(tx, &Joining { source, identity, person: &person, at }, IdentityOrigin::Created).await?;
    Ok(person)
}

/// A member of a platform's course whom an administrator has taken in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TakenMember<'a> {
    /// What the platform calls them.
    pub identity: &'a MemberIdentity,
    /// The person.
    pub person: PersonKey,
    /// Whether the account was created for them.
    pub is_new: bool,
}

/// Adds the identity of a member to an account, so that their first launch finds it.
pub(crate) async fn add_member_identity(
    tx: &mut Connection,
    by: &CurrentPerson,
    member: TakenMember<'_>,
    at: Moment,
) -> Result<(), Error> {
    let TakenMember { identity, person: PersonKey { school_id, person_id }, is_new } = member;
    let MemberIdentity { platform_id, issuer, subject } = identity;
    let how = IdentityOrigin::ByAdministrator;
    let of = IssuedSubject { school_id, kind: IdentityKind::Lti, issuer, subject };
    let new = NewIdentity { id: IdentityId::made_at(at), person_id, of, how, made_by: Some(by.id), at };
    if !identities::add_identity(tx, new).await? {
        let why = tr!("this account of your school’s system belongs to another account here");
        return Err(Error::Conflict(why.to_owned()));
    }
    AuditEntry::by(by, "identity.added", person_id)
        .with(json!({ "platform": platform_id, "how": how, "identity": new.id }))
        .append(tx, at)
        .await?;
    if !is_new {
        let mail = NewMail { school_id, person_id, kind: MailKind::IdentityJoined, assignment_id: None };
        mails::queue_mail(tx, mail, at).await?;
    }
    Ok(())
}

/// Begins a new account for an identity whose owner has none.
///
/// # Errors
/// Fails if the source does not create accounts, the identity belongs to another account, or
/// the database fails.
pub async fn begin_account(
    service: &Service,
    source: &IdentitySource,
    identity: &ProvenIdentity,
) -> Result<Person, Error> {
    if !source.creates_trainees {
        return Err(Error::Forbidden(tr!("accounts are created by your school’s administrator")));
    }
    let mut tx = service.db.write().await?;
    let person = create(&mut tx, source, identity, service.clock.now()).await?;
    tx.commit().await?;
    Ok(person)
}

/// Adds an identity to the account of a person who has proved both.
///
/// # Errors
/// Fails if they belong to different schools, the identity belongs to another account, or the
/// database fails.
pub async fn join_account(
    service: &Service,
    source: &IdentitySource,
    identity: &ProvenIdentity,
    person: PersonId,
) -> Result<(), Error> {
    let at = service.clock.now();
    let mut tx: Write = service.db.write().await?;
    let person = people::find_person(&mut *tx, person).await?.ok_or(Error::NotFound)?;
    if person.school_id != source.school_id {
        return Err(Error::Forbidden(tr!("this account belongs to another school")));
    }
    // A repeated answer changes nothing.
    let known = identities::use_identity(&mut tx, subject_of(source, identity), at).await?;
    if known != Some(person.id) {
        join(&mut tx, &Joining { source, identity, person: &person, at }, IdentityOrigin::Joined).await?;
    }
    tx.commit().await?;
    service.mails.notify_one();
    Ok(())
}

/// Removes an identity of a person and ends their other sessions.
///
/// # Errors
/// Fails if there is no such identity, it is the person's last way to sign in, or the database
/// fails.
pub async fn remove_identity(service: &Service, person: &CurrentPerson, id: IdentityId) -> Result<(), Error> {
    let key = PersonKey::from(person);
    let mut tx = service.db.write().await?;
    if !identities::remove_identity(&mut tx, key, id).await? {
        return Err(Error::NotFound);
    }
    let has_other = identities::has_identity(&mut *tx, key).await? || people::has_password(&mut *tx, person.id).await?;
    if !has_other {
        let why = tr!("this is the only way into your account: choose a password first");
        return Err(Error::Conflict(why.to_owned()));
    }
    people::end_sign_ins(&mut tx, person.id).await?;
    AuditEntry::by(person, "identity.removed", person.id)
        .with(json!({ "identity": id }))
        .append(&mut tx, service.clock.now())
        .await?;
    Ok(tx.commit().await?)
}
