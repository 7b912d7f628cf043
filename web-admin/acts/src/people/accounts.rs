//! Accounts: adds, invites, changes, disables and enables people, and issues the links by which
//! passwords are set.

use model::ids::{CohortId, PersonId};
use model::letters::mail::MailKind;
use model::limits::{INVITATION_LIFETIME_S, RESET_LIFETIME_S};
use model::people::directory::{AccountState, DirectoryEntry};
use model::people::email::present_email;
use model::{CurrentPerson, PersonKey, Role};
use platform::secret;
use serde_json::json;
use store::Connection;
use store::audit::{Actor, AuditEntry};
use store::auth::account_links::{AccountLink, NewLink, Purpose};
use store::auth::{account_links, tokens};
use store::letters::mails;
use store::letters::mails::NewMail;
use store::people::directory::Details;
use store::people::{self, NewPerson, Person, directory};
use store::training::cohorts;
use store::training::cohorts::{Attribution, Membership};
use words::Language;

use crate::error::Error;
use crate::service::Service;

/// Lifetime of an initial password set by another person, in s. It is valid for the first sign-in
/// only.
pub const INITIAL_PASSWORD_S: i64 = 3 * 86_400;
/// Minimum time between two password links requested for the same account, in s. Without it, anyone
/// who knows an address could flood its mailbox and invalidate the link that its owner is about to
/// follow.
const ASKED_AGAIN_S: i64 = 600;

/// A person to add.
#[derive(Clone, Debug)]
pub struct NewAccount<'a> {
    /// Name, address and number.
    pub details: Details<'a>,
    /// Role.
    pub role: Role,
    /// Cohort to join, if any.
    pub cohort: Option<CohortId>,
}

/// Adds a person and queues their invitation. Returns `None` if a person of the school has the address.
///
/// # Errors
/// Fails if the cohort does not belong to this school, or the database fails.
pub async fn add(state: &Service, by: &CurrentPerson, new: &NewAccount<'_>) -> Result<Option<PersonId>, Error> {
    let (school_id, now) = (by.school_id, state.clock.now());
    let mut tx = state.db.write().await?;
    let Details { name, email, registrar_id } = new.details;
    if people::find_member_by_email(&mut *tx, school_id, email).await?.is_some() {
        return Ok(None);
    }
    let person = NewPerson { school_id, role: new.role, email, display_name: name, password_hash: "" };
    let person = people::add_person(&mut tx, &person, now).await?;
    if registrar_id.is_some() {
        directory::change_details(&mut tx, school_id, person.id, new.details).await?;
    }
    AuditEntry::by(by, "person.added", person.id)
        .with(json!({ "role": new.role }))
        .append(&mut tx, state.clock.now())
        .await?;
    if let Some(cohort_id) = new.cohort {
        cohorts::find_cohort(&mut *tx, school_id, cohort_id).await?.ok_or(Error::NotFound)?;
        let membership = Membership { school_id, cohort_id, person_id: person.id, role: new.role };
        cohorts::join_cohort(&mut tx, membership, Attribution { by: Some(by.id), at: now }).await?;
        AuditEntry::by(by, "cohort.joined", person.id)
            .with(json!({ "cohort": cohort_id }))
            .append(&mut tx, state.clock.now())
            .await?;
    }
    queue_link(&mut tx, state, PersonKey { school_id, person_id: person.id }, Purpose::Invitation).await?;
    tx.commit().await?;
    state.mails.notify_one();
    Ok(Some(person.id))
}

/// Changes name, address and role. Returns false if another person of the school has the address.
pub async fn change(
    state: &Service,
    by: &CurrentPerson,
    person: &DirectoryEntry,
    details: Details<'_>,
    role: Role,
) -> Result<bool, Error> {
    let mut tx = state.db.write().await?;
    let holder = people::find_member_by_email(&mut *tx, by.school_id, details.email).await?;
    if holder.is_some_and(|holder| holder.id != person.id) {
        return Ok(false);
    }
    directory::change_details(&mut tx, by.school_id, person.id, details).await?;
    let mut changed = json!({ "name": details.name != person.name, "email": details.email != person.email });
    if details.registrar_id.is_some_and(|number| person.registrar_id.as_deref() != Some(number)) {
        changed["number"] = true.into();
    }
    if role != person.role {
        directory::change_role(&mut tx, by.school_id, person.id, role).await?;
        changed["role"] = json!([person.role, role]);
    }
    AuditEntry::by(by, "person.changed", person.id).with(changed).append(&mut tx, state.clock.now()).await?;
    tx.commit().await?;
    Ok(true)
}

/// Queues a mail with a link: an invitation if the person has no password yet, a password reset
/// otherwise.
///
/// # Errors
/// Fails if the account is disabled or erased, or the database fails.
pub async fn mail_link(state: &Service, by: &CurrentPerson, person: &DirectoryEntry) -> Result<(), Error> {
    let purpose = purpose(person)?;
    if present_email(&person.email).is_none() {
        return Err(Error::Conflict(tr!("this person has no email address: create a link to hand over").to_owned()));
    }
    let mut tx = state.db.write().await?;
    queue_link(&mut tx, state, PersonKey { school_id: by.school_id, person_id: person.id }, purpose).await?;
    AuditEntry::by(by, "person.link_mailed", person.id).append(&mut tx, state.clock.now()).await?;
    tx.commit().await?;
    state.mails.notify_one();
    Ok(())
}

/// Creates a link for the administrator to hand over, and returns it with its lifetime in s.
/// Earlier links of the same kind are revoked.
///
/// # Errors
/// Fails if the account is disabled or erased, or the database fails.
pub async fn hand_over_link(
    state: &Service,
    by: &CurrentPerson,
    person: &DirectoryEntry,
) -> Result<(String, i64), Error> {
    let purpose = purpose(person)?;
    let mut tx = state.db.write().await?;
    account_links::end_links_for(&mut tx, person.id, purpose).await?;
    let address =
        make_link_within(&mut tx, state, PersonKey { school_id: by.school_id, person_id: person.id }, purpose).await?;
    AuditEntry::by(by, "person.link_made", person.id).append(&mut tx, state.clock.now()).await?;
    tx.commit().await?;
    Ok((address, lifetime_s(purpose)))
}

fn purpose(person: &DirectoryEntry) -> Result<Purpose, Error> {
    match person.state {
        AccountState::Invited => Ok(Purpose::Invitation),
        AccountState::Active => Ok(Purpose::Reset),
        AccountState::Disabled | AccountState::Erased => {
            Err(Error::Conflict(tr!("this account is disabled: enable it first").to_owned()))
        }
    }
}

const fn lifetime_s(purpose: Purpose) -> i64 {
    match purpose {
        Purpose::Invitation => INVITATION_LIFETIME_S,
        Purpose::Reset => RESET_LIFETIME_S,
    }
}

/// Creates a link for a mail and returns its address, which is stored nowhere (only a hash of its
/// token is). Earlier links stay valid: if the connection breaks after a mail server has accepted a
/// mail, the mail is sent again, and the recipient may open either copy.
pub async fn make_link(state: &Service, whose: PersonKey, purpose: Purpose) -> Result<String, Error> {
    let mut tx = state.db.write().await?;
    let address = make_link_within(&mut tx, state, whose, purpose).await?;
    tx.commit().await?;
    Ok(address)
}

/// Creates a link within a transaction and returns its absolute address.
async fn make_link_within(
    tx: &mut Connection,
    state: &Service,
    PersonKey { school_id, person_id }: PersonKey,
    purpose: Purpose,
) -> Result<String, Error> {
    let expires_at = state.clock.now().plus_s(lifetime_s(purpose));
    let path = make_path(tx, NewLink { school_id, person_id, purpose, expires_at }).await?;
    Ok(format!("{}{path}", state.config.address()))
}

/// Creates a link within a transaction and returns its path.
async fn make_path(tx: &mut Connection, link: NewLink) -> Result<String, Error> {
    let token = secret::random_hex()?;
    account_links::add_account_link(tx, link, &secret::token_sha256(&token)).await?;
    Ok(format!("/join/{token}"))
}

/// Time to choose a password after signing in with an initial one, in s.
const CHOOSING_S: i64 = 3600;

/// Returns the path at which a person who has signed in with an initial password chooses their own.
/// Until they have done so, they are not signed in.
pub async fn use_initial_password(state: &Service, person: &Person) -> Result<String, Error> {
    let (school_id, person_id, now) = (person.school_id, person.id, state.clock.now());
    let mut tx = state.db.write().await?;
    account_links::end_links_for(&mut tx, person_id, Purpose::Reset).await?;
    let link = NewLink { school_id, person_id, purpose: Purpose::Reset, expires_at: now.plus_s(CHOOSING_S) };
    let path = make_path(&mut tx, link).await?;
    AuditEntry::new(school_id, Actor::Person(person_id), "person.initial_password_used", person_id)
        .append(&mut tx, now)
        .await?;
    tx.commit().await?;
    Ok(path)
}

/// Returns whether a password is the initial one that another person has set for this account.
pub async fn is_initial_password(state: &Service, person: PersonId, typed: &str) -> Result<bool, Error> {
    let known = people::find_credentials(state.db.reader(), person).await?;
    let known = known.filter(|known| known.initial_until.is_some());
    let Some(hash) = known.and_then(|known| known.password_hash) else { return Ok(false) };
    let typed = typed.to_owned();
    state.hash(move || secret::password_fits(&typed, &hash)).await
}

/// Queues the mail with a link and revokes earlier links. The link itself is created when the mail
/// is sent.
pub async fn queue_link(
    tx: &mut Connection,
    state: &Service,
    PersonKey { school_id, person_id }: PersonKey,
    purpose: Purpose,
) -> Result<(), Error> {
    let kind = match purpose {
        Purpose::Invitation => MailKind::Invitation,
        Purpose::Reset => MailKind::Reset,
    };
    account_links::end_links_for(&mut *tx, person_id, purpose).await?;
    let mail = NewMail { school_id, person_id, kind, assignment_id: None };
    Ok(mails::queue_mail(tx, mail, state.clock.now()).await?)
}

/// Records that a password link was requested for an address. [`answer_asked`] looks up later
/// whether an account has that address, so that the response time does not reveal it.
pub async fn ask_for_link(state: &Service, email: &str) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    account_links::ask_for_link(&mut tx, email, state.clock.now()).await?;
    tx.commit().await?;
    state.mails.notify_one();
    Ok(())
}

/// Queues a link for every account without a recent link that has a requested address, and deletes all
/// requests.
pub async fn answer_asked(state: &Service) -> Result<(), Error> {
    while let Some(email) = account_links::find_next_asked_link(state.db.reader()).await? {
        let mut tx = state.db.write().await?;
        for person in people::list_people_by_email(&mut *tx, &email).await? {
            answer(&mut tx, state, &person).await?;
        }
        account_links::forget_asked(&mut tx, &email).await?;
        tx.commit().await?;
    }
    Ok(())
}

async fn answer(tx: &mut Connection, state: &Service, person: &Person) -> Result<(), Error> {
    let Some(listed) = directory::find_directory_entry(&mut *tx, person.school_id, person.id).await? else {
        return Ok(());
    };
    let Ok(purpose) = purpose(&listed) else { return Ok(()) };
    let made_lately = state.clock.now().plus_s(lifetime_s(purpose) - ASKED_AGAIN_S);
    if account_links::count_lasting_links(&mut *tx, person.id, purpose, made_lately).await? {
        return Ok(());
    }
    queue_link(tx, state, PersonKey { school_id: person.school_id, person_id: person.id }, purpose).await?;
    let asked = AuditEntry::new(person.school_id, Actor::Person(person.id), "person.link_asked_for", person.id);
    Ok(asked.append(tx, state.clock.now()).await?)
}

/// Returns the link of a token, or `None` if it is unknown, used or expired.
pub async fn link(state: &Service, token: &str) -> Result<Option<AccountLink>, Error> {
    Ok(account_links::find_valid_link(state.db.reader(), &secret::token_sha256(token), state.clock.now()).await?)
}

/// Sets the password by a link, which revokes the link and ends all earlier sessions. Returns false
/// if the link is no longer valid.
pub async fn set_password_by_link(state: &Service, token: &str, password: &str) -> Result<bool, Error> {
    let hash = hash(state, password).await?;
    let mut tx = state.db.write().await?;
    let known = account_links::find_valid_link(&mut *tx, &secret::token_sha256(token), state.clock.now()).await?;
    let Some(link) = known else { return Ok(false) };
    set_password(&mut tx, state, PersonKey { school_id: link.school_id, person_id: link.person_id }, &hash).await?;
    tx.commit().await?;
    Ok(true)
}

/// Returns whether a password is the person's own. A wrong one is recorded in the audit log.
pub async fn is_own_password(state: &Service, person: &CurrentPerson, typed: &str) -> Result<bool, Error> {
    let known = people::find_credentials(state.db.reader(), person.id).await?.and_then(|known| known.password_hash);
    let Some(known) = known else { return Ok(false) };
    let typed = typed.to_owned();
    if state.hash(move || secret::password_fits(&typed, &known)).await? {
        return Ok(true);
    }
    let mut tx = state.db.write().await?;
    AuditEntry::by(person, "person.password_refused", person.id).append(&mut tx, state.clock.now()).await?;
    tx.commit().await?;
    Ok(false)
}

/// Sets a person's own password, after they have proved who they are.
pub async fn set_own_password(state: &Service, person: &CurrentPerson, new: &str) -> Result<(), Error> {
    let hash = hash(state, new).await?;
    let mut tx = state.db.write().await?;
    set_password(&mut tx, state, PersonKey::from(person), &hash).await?;
    Ok(tx.commit().await?)
}

/// Returns whether a person has a password.
pub async fn has_password(state: &Service, person: PersonId) -> Result<bool, Error> {
    Ok(people::has_password(state.db.reader(), person).await?)
}

async fn hash(state: &Service, password: &str) -> Result<String, Error> {
    let (password, cost) = (password.to_owned(), state.config.password_cost);
    Ok(state.hash(move || secret::hash_password(&password, cost)).await??)
}

async fn set_password(
    tx: &mut Connection,
    state: &Service,
    PersonKey { school_id, person_id: person }: PersonKey,
    hash: &str,
) -> Result<(), Error> {
    people::set_password(tx, person, hash).await?;
    Ok(AuditEntry::new(school_id, Actor::Person(person), "person.password_set", person)
        .append(tx, state.clock.now())
        .await?)
}

/// Prevents a person from signing in and revokes their tokens. Their data is kept.
pub async fn disable(state: &Service, by: &CurrentPerson, person: PersonId) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    disable_in(&mut tx, state, by, person).await?;
    Ok(tx.commit().await?)
}

/// [`disable`], within a transaction.
pub async fn disable_in(
    tx: &mut Connection,
    state: &Service,
    by: &CurrentPerson,
    person: PersonId,
) -> Result<(), Error> {
    if people::disable_person(tx, person, state.clock.now()).await? {
        let revoked = tokens::revoke_all_tokens(tx, person, state.clock.now()).await?;
        AuditEntry::by(by, "person.disabled", person)
            .with(json!({ "tokens_revoked": revoked }))
            .append(tx, state.clock.now())
            .await?;
    }
    Ok(())
}

/// Enables a disabled account again.
pub async fn enable(state: &Service, by: &CurrentPerson, person: PersonId) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    enable_in(&mut tx, state, by, person).await?;
    Ok(tx.commit().await?)
}

/// [`enable`], within a transaction.
pub(crate) async fn enable_in(
    tx: &mut Connection,
    state: &Service,
    by: &CurrentPerson,
    person: PersonId,
) -> Result<(), Error> {
    if directory::enable_account(tx, by.school_id, person).await? {
        AuditEntry::by(by, "person.enabled", person).append(tx, state.clock.now()).await?;
    }
    Ok(())
}

/// Sets a person's language; `None` follows the browser's `Accept-Language`.
pub async fn set_language(state: &Service, person: &CurrentPerson, chosen: Option<Language>) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    people::set_language(&mut tx, PersonKey { school_id: person.school_id, person_id: person.id }, chosen).await?;
    let told = json!({ "language": chosen.map(Language::code) });
    AuditEntry::by(person, "person.language_set", person.id).with(told).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}
