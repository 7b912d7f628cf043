//! Second factors: enrolment, verification, removal and reset. Each code is valid once, attempts
//! are rate-limited per account, and every operation is in the audit log.

use std::net::IpAddr;

use model::letters::mail::MailKind;
use model::{CurrentPerson, Moment, PersonKey, TotpSecret};
use platform::{sealing, secret};
use serde_json::{Value, json};
use store::audit::{Actor, AuditEntry};
use store::auth::second_factors;
use store::letters::mails;
use store::letters::mails::NewMail;
use store::{Connection, people};

use crate::auth::rate_limits;
use crate::error::Error;
use crate::service::Service;

/// Lifetime of an offered secret, in s.
const OFFER_LIFETIME_S: i64 = 30 * 60;
/// Number of recovery codes issued at once.
const RECOVERY_CODES: usize = 10;
/// Length of a recovery code, in letters of 5 bits each; the codes are also protected by a rate
/// limit and a slow hash.
const RECOVERY_LETTERS: usize = 12;
/// Letters per displayed group.
const GROUP: usize = 4;

/// The kind of second factor that a person has used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignInProof {
    /// A code of their authenticator app.
    App,
    /// A recovery code, which is consumed.
    RecoveryCode,
    /// A signature by a passkey.
    Passkey,
    /// A second factor at a provider.
    Provider,
}

impl SignInProof {
    /// Returns the name used in the audit log.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::App => "app",
            Self::RecoveryCode => "recovery code",
            Self::Passkey => "passkey",
            Self::Provider => "provider",
        }
    }
}

/// Result of enrolling a second factor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Enrolled {
    /// It is the first one; contains the recovery codes, which cannot be shown again.
    First(Vec<String>),
    /// There was one before, and its recovery codes stay valid.
    Another,
}

/// A code entered by a person, and their address.
#[derive(Clone, Copy, Debug)]
pub struct TypedCode<'a> {
    /// The code.
    pub code: &'a str,
    /// Client address.
    pub from: IpAddr,
}

/// Creates a secret for an authenticator app, replacing an unconfirmed one. Returns false if an app
/// is already enrolled.
///
/// # Errors
/// Fails if the key or the database fails.
pub async fn offer(state: &Service, person: &CurrentPerson) -> Result<bool, Error> {
    let bytes = secret::random_bytes::<20>()?;
    let sealed = sealing::seal(&state.config.keys_dir, person.id.uuid().as_bytes(), &bytes)?;
    let (key, now) = (person.into(), state.clock.now());
    let mut tx = state.db.write().await?;
    let offered = second_factors::offer_second_factor(&mut tx, key, &sealed, now).await?;
    if offered {
        AuditEntry::by(person, "second_factor.offered", person.id).append(&mut tx, now).await?;
    }
    tx.commit().await?;
    Ok(offered)
}

/// Returns the secret that was offered recently and has not been confirmed yet.
///
/// # Errors
/// Fails if it cannot be opened, or the database fails.
pub async fn offered(state: &Service, key: PersonKey) -> Result<Option<TotpSecret>, Error> {
    // The offer was made after the password was entered; a person who finds the browser open later
    // must not use it.
    let since = state.clock.now().plus_s(-OFFER_LIFETIME_S);
    let found = second_factors::find_second_factor(state.db.reader(), key)
        .await?
        .filter(|factor| factor.confirmed_at.is_none() && factor.made_at > since);
    found.map(|factor| opened(state, key, &factor.sealed_secret)).transpose()
}

/// Opens a sealed secret.
fn opened(state: &Service, key: PersonKey, sealed: &[u8]) -> Result<TotpSecret, Error> {
    let opened = sealing::open(&state.config.keys_dir, key.person_id.uuid().as_bytes(), sealed);
    let kept = opened.map(|bytes| TotpSecret::from_bytes(&bytes));
    match kept {
        Ok(Some(secret)) => Ok(secret),
        Ok(None) => Err(anyhow::anyhow!("a sealed secret has another length").into()),
        Err(cause) => {
            tracing::error!(cause = format!("{cause:#}"), "app code cannot be checked");
            let why = tr!("app codes cannot be checked right now: use a recovery code, or ask an administrator");
            Err(Error::Conflict(why.to_owned()))
        }
    }
}

/// Enrols the offered secret if the code is right, which ends all other sessions. Returns `None` if
/// the code is wrong.
///
/// # Errors
/// Fails if no secret is offered, there were too many attempts, or the database fails.
pub async fn confirm(state: &Service, person: &CurrentPerson, typed: TypedCode<'_>) -> Result<Option<Enrolled>, Error> {
    let key = PersonKey::from(person);
    let secret = offered(state, key).await?.ok_or_else(nothing_offered)?;
    take_try(state, key, typed.from).await?;
    let now = state.clock.now();
    let Some(step) = secret.step_of(&without_spaces(typed.code), now) else {
        note(state, key, "second_factor.refused").await?;
        return Ok(None);
    };
    let first = !second_factors::is_second_factor_on(state.db.reader(), key).await?;
    // Hashing is slow on purpose, so it is done before the write lock is taken.
    let codes = if first { Some(make_codes(state, key).await?) } else { None };
    let mut tx = state.db.write().await?;
    if !second_factors::confirm_second_factor(&mut tx, key, step, now).await? {
        return Err(nothing_offered());
    }
    let enrolled = match codes {
        Some((codes, hashes)) => {
            second_factors::put_recovery_codes(&mut tx, key, &hashes).await?;
            Enrolled::First(codes)
        }
        None => Enrolled::Another,
    };
    people::end_sign_ins(&mut tx, key.person_id).await?;
    AuditEntry::by(person, "second_factor.on", person.id).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(Some(enrolled))
}

fn nothing_offered() -> Error {
    Error::Conflict(tr!("no second factor is waiting for confirmation: start again").to_owned())
}

/// Checks a code, either of the app or a recovery code, and consumes it. Returns `None` if it is
/// neither.
///
/// # Errors
/// Fails if there were too many attempts, the secret cannot be opened, or the database fails.
pub async fn check(state: &Service, key: PersonKey, typed: TypedCode<'_>) -> Result<Option<SignInProof>, Error> {
    take_try(state, key, typed.from).await?;
    let code = without_spaces(typed.code);
    let proof = if code.bytes().all(|byte| byte.is_ascii_digit()) {
        take_code(state, key, &code).await?
    } else {
        take_recovery_code(state, key, &code).await?
    };
    if proof.is_none() {
        tracing::warn!(from = %typed.from, person = %key.person_id, "wrong second-factor code");
        note(state, key, "second_factor.refused").await?;
    }
    Ok(proof)
}

/// Counts an attempt, right or wrong.
///
/// # Errors
/// Fails if there were too many, or the database fails.
pub(crate) async fn take_try(state: &Service, key: PersonKey, from: IpAddr) -> Result<(), Error> {
    let Err(refused) = rate_limits::take_code(state, key.person_id).await else { return Ok(()) };
    if matches!(refused, Error::TooMany { .. }) && state.rate_limit_log.is_worth_noting(from) {
        tracing::warn!(%from, person = %key.person_id, "too many second-factor attempts");
        note(state, key, "second_factor.blocked").await?;
    }
    Err(refused)
}

async fn take_code(state: &Service, key: PersonKey, code: &str) -> Result<Option<SignInProof>, Error> {
    let found = second_factors::find_second_factor(state.db.reader(), key)
        .await?
        .filter(|factor| factor.confirmed_at.is_some());
    let Some(factor) = found else { return Ok(None) };
    let Some(step) = opened(state, key, &factor.sealed_secret)?.step_of(code, state.clock.now()) else {
        return Ok(None);
    };
    let mut tx = state.db.write().await?;
    let taken = second_factors::take_step(&mut tx, key, step).await?;
    tx.commit().await?;
    Ok(taken.then_some(SignInProof::App))
}

async fn take_recovery_code(state: &Service, key: PersonKey, code: &str) -> Result<Option<SignInProof>, Error> {
    let hash = hashes(state, key, vec![secret::plain_code(code)]).await?.pop().unwrap_or_default();
    let mut tx = state.db.write().await?;
    if !second_factors::use_recovery_code(&mut tx, key, &hash).await? {
        return Ok(None);
    }
    let left = second_factors::recovery_codes_left(&mut *tx, key).await?;
    AuditEntry::new(key.school_id, Actor::Person(key.person_id), "recovery_code.used", key.person_id)
        .with(json!({ "left": left }))
        .append(&mut tx, state.clock.now())
        .await?;
    tx.commit().await?;
    Ok(Some(SignInProof::RecoveryCode))
}

/// Replaces the recovery codes by new ones.
///
/// # Errors
/// Fails if no second factor is enrolled, or the database fails.
pub async fn remake_codes(state: &Service, person: &CurrentPerson) -> Result<Vec<String>, Error> {
    let key = PersonKey::from(person);
    let (codes, hashes) = make_codes(state, key).await?;
    let mut tx = state.db.write().await?;
    if !second_factors::is_second_factor_on(&mut *tx, key).await? {
        return Err(nothing_on());
    }
    second_factors::put_recovery_codes(&mut tx, key, &hashes).await?;
    AuditEntry::by(person, "recovery_codes.made", person.id).append(&mut tx, state.clock.now()).await?;
    tx.commit().await?;
    Ok(codes)
}

/// Error for a person without an enrolled second factor.
#[must_use]
pub fn nothing_on() -> Error {
    Error::Conflict(tr!("this account has no second factor").to_owned())
}

/// Creates recovery codes and returns them, formatted for display, with their hashes.
///
/// # Errors
/// Fails if the system's random source or the hashing fails.
pub(crate) async fn make_codes(state: &Service, key: PersonKey) -> Result<(Vec<String>, Vec<[u8; 32]>), Error> {
    let codes = (0..RECOVERY_CODES).map(|_| secret::random_code(RECOVERY_LETTERS));
    let codes = codes.collect::<anyhow::Result<Vec<String>>>()?;
    let hashes = hashes(state, key, codes.clone()).await?;
    Ok((codes.iter().map(|code| in_groups(code)).collect(), hashes))
}

async fn hashes(state: &Service, key: PersonKey, codes: Vec<String>) -> Result<Vec<[u8; 32]>, Error> {
    let (cost, realm) = (state.config.password_cost, *key.person_id.uuid().as_bytes());
    let work = move || codes.iter().map(|code| secret::code_hash(code, &realm, cost)).collect::<anyhow::Result<_>>();
    Ok(state.hash(work).await??)
}

/// Splits a text into hyphenated groups, which are easier to read and to type.
#[must_use]
pub fn in_groups(text: &str) -> String {
    let letters: Vec<char> = text.chars().collect();
    letters.chunks(GROUP).map(|group| group.iter().collect::<String>()).collect::<Vec<_>>().join("-")
}

fn without_spaces(typed: &str) -> String {
    typed.chars().filter(|letter| !letter.is_whitespace()).collect()
}

/// Removes a person's own authenticator app. With the last second factor, the recovery codes are
/// removed and a mail is sent. Returns false if there was no app.
pub async fn turn_off(state: &Service, person: &CurrentPerson) -> Result<bool, Error> {
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    if !second_factors::remove_app(&mut tx, person.into()).await? {
        return Ok(false);
    }
    if !end_if_last(&mut tx, person, now).await? {
        AuditEntry::by(person, "second_factor.app_off", person.id).append(&mut tx, now).await?;
    }
    tx.commit().await?;
    state.mails.notify_one();
    Ok(true)
}

/// Removes the recovery codes of a person who has just removed their last second factor, and queues
/// a mail to them. Returns false if another second factor is left.
pub(crate) async fn end_if_last(tx: &mut Connection, person: &CurrentPerson, now: Moment) -> Result<bool, Error> {
    if second_factors::is_second_factor_on(&mut *tx, person.into()).await? {
        return Ok(false);
    }
    second_factors::remove_second_factor(tx, person.into()).await?;
    note_off(tx, person.into(), RemovalAct { by: Actor::Person(person.id), action: "second_factor.off" }, now).await?;
    Ok(true)
}

/// Removes the second factors of a person who has lost them, and queues a mail to them. They can
/// then sign in with their password alone. Returns false if none was enrolled.
pub async fn reset(state: &Service, key: PersonKey, by: Actor) -> Result<bool, Error> {
    let mut tx = state.db.write().await?;
    let done = remove(&mut tx, key, RemovalAct { by, action: "second_factor.reset" }, state).await?;
    tx.commit().await?;
    state.mails.notify_one();
    Ok(done)
}

/// Actor and audit action of the removal of a second factor.
struct RemovalAct {
    by: Actor,
    action: &'static str,
}

async fn remove(tx: &mut Connection, key: PersonKey, act: RemovalAct, state: &Service) -> Result<bool, Error> {
    if !second_factors::remove_second_factor(tx, key).await? {
        return Ok(false);
    }
    note_off(tx, key, act, state.clock.now()).await?;
    Ok(true)
}

/// Records in the audit log that a person has no second factor any more, and queues the mail to
/// them.
async fn note_off(tx: &mut Connection, key: PersonKey, act: RemovalAct, now: Moment) -> Result<(), Error> {
    let PersonKey { school_id, person_id } = key;
    AuditEntry::new(school_id, act.by, act.action, person_id).append(tx, now).await?;
    let mail = NewMail { school_id, person_id, kind: MailKind::SecondFactorOff, assignment_id: None };
    Ok(mails::queue_mail(tx, mail, now).await?)
}

/// Records in the audit log that a person has signed in, with the kind of second factor.
pub async fn note_sign_in(state: &Service, key: PersonKey, by: Option<SignInProof>) -> Result<(), Error> {
    let details = by.map_or_else(|| json!({}), |proof| json!({ "second_factor": proof.word() }));
    write_down(state, key, "person.signed_in", details).await
}

/// Records an action on a person's second factor in the audit log.
pub(crate) async fn note(state: &Service, key: PersonKey, action: &'static str) -> Result<(), Error> {
    write_down(state, key, action, json!({})).await
}

async fn write_down(state: &Service, key: PersonKey, action: &'static str, details: Value) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    let entry = AuditEntry::new(key.school_id, Actor::Person(key.person_id), action, key.person_id);
    entry.with(details).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}
