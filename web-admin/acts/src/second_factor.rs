//! Second factors: enrolled, asked for, turned off and reset. Each code is good once, tries are counted whoever makes them, and
//! everything is in the audit log.

use std::net::IpAddr;

use model::mail::MailKind;
use model::{CurrentPerson, Moment, PersonKey, TotpSecret};
use serde_json::{Value, json};
use store::audit::{Actor, AuditEntry};
use store::mails::NewMail;
use store::{Connection, mails, people, second_factors};

use crate::error::Error;
use crate::service::Service;
use crate::{brakes, sealing, secret};

/// Lifetime of an offered secret, in s.
const OFFER_LIFETIME_S: i64 = 30 * 60;
/// Recovery codes that are made at once.
const RECOVERY_CODES: usize = 10;
/// Letters of a recovery code, 5 bits each, behind the brake and a slow hash.
const RECOVERY_LETTERS: usize = 12;
/// Letters that stand together.
const GROUP: usize = 4;

/// By what somebody has shown that they are themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignInProof {
    /// A code of their app.
    App,
    /// A recovery code, which is used up.
    RecoveryCode,
    /// A passkey, by its signature.
    Passkey,
}

impl SignInProof {
    /// As the audit log says it.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::App => "app",
            Self::RecoveryCode => "recovery code",
            Self::Passkey => "passkey",
        }
    }
}

/// What came of a second factor that was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Enrolled {
    /// It is the first; the recovery codes, which nobody sees again.
    First(Vec<String>),
    /// There was one before, and its recovery codes go on.
    Another,
}

/// What somebody has typed, and where.
#[derive(Clone, Copy, Debug)]
pub struct TypedCode<'a> {
    /// What.
    pub code: &'a str,
    /// From which network address.
    pub from: IpAddr,
}

/// Offers a secret, in place of one that was offered before. False where a second factor is on already.
///
/// # Errors
/// When the key or the database fails.
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

/// The secret that was offered shortly before and is not on yet.
///
/// # Errors
/// When it cannot be opened, or the database fails.
pub async fn offered(state: &Service, key: PersonKey) -> Result<Option<TotpSecret>, Error> {
    // The offer follows a typed password. A person who finds the browser open later has not typed it.
    let since = state.clock.now().plus_s(-OFFER_LIFETIME_S);
    let found = second_factors::find_second_factor(state.db.reader(), key)
        .await?
        .filter(|factor| factor.confirmed_at.is_none() && factor.made_at > since);
    found.map(|factor| opened(state, key, &factor.sealed_secret)).transpose()
}

/// The secret within a sealed one.
fn opened(state: &Service, key: PersonKey, sealed: &[u8]) -> Result<TotpSecret, Error> {
    let opened = sealing::open(&state.config.keys_dir, key.person_id.uuid().as_bytes(), sealed);
    let kept = opened.map(|bytes| TotpSecret::from_bytes(&bytes));
    match kept {
        Ok(Some(secret)) => Ok(secret),
        Ok(None) => Err(anyhow::anyhow!("a sealed secret has another length").into()),
        Err(cause) => {
            tracing::error!(cause = format!("{cause:#}"), "the code of an app cannot be checked");
            let why = tr!("codes of the app cannot be checked here now: use a recovery code, or ask an administrator");
            Err(Error::Conflict(why.to_owned()))
        }
    }
}

/// Turns the offered secret on by one code of it, which ends every other sign-in. None where the code is wrong.
///
/// # Errors
/// When no secret is offered, there were too many tries, or the database fails.
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
    Error::Conflict(tr!("there is no second factor to confirm: begin once more").to_owned())
}

/// What a code proves that somebody has typed, of the app or a recovery code; either is used up. `None` where it is neither.
///
/// # Errors
/// When there were too many tries, the secret cannot be opened, or the database fails.
pub async fn check(state: &Service, key: PersonKey, typed: TypedCode<'_>) -> Result<Option<SignInProof>, Error> {
    take_try(state, key, typed.from).await?;
    let code = without_spaces(typed.code);
    let proof = if code.bytes().all(|byte| byte.is_ascii_digit()) {
        take_code(state, key, &code).await?
    } else {
        take_recovery_code(state, key, &code).await?
    };
    if proof.is_none() {
        tracing::warn!(from = %typed.from, person = %key.person_id, "a wrong code of a second factor");
        note(state, key, "second_factor.refused").await?;
    }
    Ok(proof)
}

/// Counts a try, right or wrong.
///
/// # Errors
/// When there were too many, or the database fails.
pub(crate) async fn take_try(state: &Service, key: PersonKey, from: IpAddr) -> Result<(), Error> {
    let Err(refused) = brakes::take_code(state, key.person_id).await else { return Ok(()) };
    if matches!(refused, Error::TooMany { .. }) && state.brake_notes.is_worth_noting(from) {
        tracing::warn!(%from, person = %key.person_id, "codes of a second factor are tried too often");
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

/// Makes recovery codes in place of those of before.
///
/// # Errors
/// When no second factor is on, or the database fails.
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

/// What somebody is told who has no second factor that is on.
#[must_use]
pub fn nothing_on() -> Error {
    Error::Conflict(tr!("there is no second factor on this account").to_owned())
}

/// Recovery codes as they are read, and their hashes.
///
/// # Errors
/// When the system's random source or the hashing fails.
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

/// Letters in groups, which are easier to read and to type.
#[must_use]
pub fn in_groups(text: &str) -> String {
    let letters: Vec<char> = text.chars().collect();
    letters.chunks(GROUP).map(|group| group.iter().collect::<String>()).collect::<Vec<_>>().join("-")
}

fn without_spaces(typed: &str) -> String {
    typed.chars().filter(|letter| !letter.is_whitespace()).collect()
}

/// Turns the codes of one's own app off; with the last second factor the recovery codes go, and a mail tells. False where there was
/// no app.
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

/// Forgets the recovery codes of somebody who has just removed their last second factor, and tells them by mail. False where one is
/// left.
pub(crate) async fn end_if_last(tx: &mut Connection, person: &CurrentPerson, now: Moment) -> Result<bool, Error> {
    if second_factors::is_second_factor_on(&mut *tx, person.into()).await? {
        return Ok(false);
    }
    second_factors::remove_second_factor(tx, person.into()).await?;
    note_off(tx, person.into(), RemovalAct { by: Actor::Person(person.id), action: "second_factor.off" }, now).await?;
    Ok(true)
}

/// Takes somebody's second factor away, who has lost it: they sign in by their password, and are told by mail. False where
/// none was on.
pub async fn reset(state: &Service, key: PersonKey, by: Actor) -> Result<bool, Error> {
    let mut tx = state.db.write().await?;
    let done = remove(&mut tx, key, RemovalAct { by, action: "second_factor.reset" }, state).await?;
    tx.commit().await?;
    state.mails.notify_one();
    Ok(done)
}

/// Who turns a second factor off, and as what it is written down.
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

/// Writes down that somebody has no second factor any more, and queues the mail that tells them.
async fn note_off(tx: &mut Connection, key: PersonKey, act: RemovalAct, now: Moment) -> Result<(), Error> {
    let PersonKey { school_id, person_id } = key;
    AuditEntry::new(school_id, act.by, act.action, person_id).append(tx, now).await?;
    let mail = NewMail { school_id, person_id, kind: MailKind::SecondFactorOff, assignment_id: None };
    Ok(mails::queue_mail(tx, mail, now).await?)
}

/// Writes down that somebody has signed in, and by what.
pub async fn note_sign_in(state: &Service, key: PersonKey, by: Option<SignInProof>) -> Result<(), Error> {
    let details = by.map_or_else(|| json!({}), |proof| json!({ "second_factor": proof.word() }));
    write_down(state, key, "person.signed_in", details).await
}

/// Writes down what somebody did to their second factor.
pub(crate) async fn note(state: &Service, key: PersonKey, action: &'static str) -> Result<(), Error> {
    write_down(state, key, action, json!({})).await
}

async fn write_down(state: &Service, key: PersonKey, action: &'static str, details: Value) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    let entry = AuditEntry::new(key.school_id, Actor::Person(key.person_id), action, key.person_id);
    entry.with(details).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}
