//! Passkeys (WebAuthn) as a second factor: registration, assertion, renaming and removal.
//! Challenges are stored on the server and valid once; every operation is in the audit log.

use std::net::IpAddr;

use anyhow::Context;
use model::auth::passkey::PasskeyQuestion;
use model::ids::{CeremonyId, PasskeyId};
use model::{CurrentPerson, PersonKey};
use platform::relying_party::{
    AnswerRefused, AssertionRequest, Challenge, CredentialRecord, PasskeyAccount, PasskeyOwner, RelyingParty,
};
use serde_json::json;
use store::audit::AuditEntry;
use store::auth::passkeys::{KeptPasskey, NewPasskey, PasskeySignature};
use store::auth::{passkeys, second_factors};
use store::people;

use crate::auth::second_factor::{Enrolled, SignInProof};
use crate::auth::tokens::checked_name;
use crate::auth::webauthn_challenges::PasskeyChallenge;
use crate::auth::{second_factor, webauthn_challenges};
use crate::error::Error;
use crate::service::Service;

/// Maximum number of passkeys per person.
pub const MOST: usize = 20;

/// Response of a browser to a WebAuthn challenge.
#[derive(Clone, Copy, Debug)]
pub struct PasskeyAnswer<'a> {
    /// Id of the challenge, from the session.
    pub question: Option<CeremonyId>,
    /// The response, in JSON.
    pub json: &'a str,
    /// Client address.
    pub from: IpAddr,
}

/// Result of checking a response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PasskeyCheck {
    /// The assertion is valid.
    Proved(SignInProof),
    /// There was no challenge, or it has expired or been used.
    Late,
    /// The response was rejected.
    Refused(AnswerRefused),
}

/// Error for a service on which passkeys cannot be used.
#[must_use]
pub fn no_site() -> Error {
    let why =
        tr!("passkeys are not available here: browsers support them only over https with a host name, or on localhost");
    Error::Conflict(why.to_owned())
}

/// Creates a challenge for a person's passkeys. Returns `None` if they have none, or passkeys
/// cannot be used here.
///
/// # Errors
/// Fails if no challenge can be created, or the database fails.
pub async fn ask(state: &Service, key: PersonKey) -> Result<Option<PasskeyQuestion>, Error> {
    let Some(party) = state.relying_party.as_deref() else { return Ok(None) };
    let known = read_records(&passkeys::list_passkeys(state.db.reader(), key).await?)?;
    if known.is_empty() {
        return Ok(None);
    }
    let (request, options) = party.request_options(Challenge::random()?, &known);
    let id = webauthn_challenges::begin(state, key.person_id, PasskeyChallenge::ToSign(request)).await?;
    Ok(Some(PasskeyQuestion { id, options, origin: party.origin().to_owned() }))
}

fn read_records(kept: &[KeptPasskey]) -> Result<Vec<CredentialRecord>, Error> {
    let records = kept.iter().map(|kept| CredentialRecord::from_json(&kept.public_key));
    Ok(records.collect::<Result<_, _>>().context("a passkey in the database cannot be read")?)
}

/// Checks an assertion. Each challenge is valid once, and each attempt counts against the rate
/// limit.
///
/// # Errors
/// Fails if there were too many attempts, or the database fails.
pub async fn check(state: &Service, key: PersonKey, answer: PasskeyAnswer<'_>) -> Result<PasskeyCheck, Error> {
    second_factor::take_try(state, key, answer.from).await?;
    let party = state.relying_party.as_deref().ok_or_else(no_site)?;
    let signed = match take(state, key, answer.question).await? {
        Some(PasskeyChallenge::ToSign(request)) => {
            verify_signature(state, key, PasskeyResponse { party, request: &request, json: answer.json }).await?
        }
        _ => PasskeyCheck::Late,
    };
    match signed {
        PasskeyCheck::Proved(_) => {}
        PasskeyCheck::Late => second_factor::note(state, key, "second_factor.refused").await?,
        PasskeyCheck::Refused(why) => {
            tracing::warn!(from = %answer.from, person = %key.person_id, ?why, "passkey response rejected");
            let action = match why {
                AnswerRefused::Wrong => "second_factor.refused",
                AnswerRefused::Copied => "passkey.counted_backwards",
            };
            second_factor::note(state, key, action).await?;
        }
    }
    Ok(signed)
}

async fn take(
    state: &Service,
    key: PersonKey,
    question: Option<CeremonyId>,
) -> Result<Option<PasskeyChallenge>, Error> {
    let Some(question) = question else { return Ok(None) };
    webauthn_challenges::take(state, question, key.person_id).await
}

/// A response to a signature request.
struct PasskeyResponse<'a> {
    party: &'a RelyingParty,
    request: &'a AssertionRequest,
    json: &'a str,
}

async fn verify_signature(
    state: &Service,
    key: PersonKey,
    response: PasskeyResponse<'_>,
) -> Result<PasskeyCheck, Error> {
    // Another challenge may have been answered or the passkey removed since, so verify against the
    // current record within the transaction.
    let mut tx = state.db.write().await?;
    let records = read_records(&passkeys::list_passkeys(&mut *tx, key).await?)?;
    let account = PasskeyAccount { person_id: key.person_id, records: &records };
    let record = match response.party.verify_assertion(response.json, response.request, account) {
        Ok(record) => record,
        Err(why) => return Ok(PasskeyCheck::Refused(why)),
    };
    let json = record.to_json().context("a passkey cannot be written")?;
    let signature = PasskeySignature {
        credential_id: record.id(),
        public_key: &json,
        count: record.sign_count(),
        at: state.clock.now(),
    };
    if !passkeys::take_signature(&mut tx, key, signature).await? {
        return Ok(PasskeyCheck::Refused(AnswerRefused::Copied));
    }
    tx.commit().await?;
    Ok(PasskeyCheck::Proved(SignInProof::Passkey))
}

/// Creates a challenge for registering a new passkey.
///
/// # Errors
/// Fails if the name is not allowed, there are too many passkeys, passkeys cannot be used here, or
/// the database fails.
pub async fn ask_to_make(state: &Service, person: &CurrentPerson, name: &str) -> Result<PasskeyQuestion, Error> {
    let party = state.relying_party.as_deref().ok_or_else(no_site)?;
    let name = checked_name(name)?;
    let (reader, key) = (state.db.reader(), PersonKey::from(person));
    let known = read_records(&passkeys::list_passkeys(reader, key).await?)?;
    if known.len() >= MOST {
        let why = tr!(
            "this account already has {most} passkeys, the most allowed: remove one that you no longer use",
            most = MOST
        );
        return Err(Error::Unprocessable(why));
    }
    let account = people::find_person(reader, person.id).await?.ok_or(Error::NotFound)?;
    let owner = PasskeyOwner { id: person.id, email: &account.email, name: &person.display_name };
    let challenge = Challenge::random()?;
    let options = party.creation_options(owner, &challenge, &known);
    let id = webauthn_challenges::begin(state, person.id, PasskeyChallenge::ToMake { name, challenge }).await?;
    Ok(PasskeyQuestion { id, options, origin: party.origin().to_owned() })
}

/// Registers a new passkey. If it is the first second factor, recovery codes are issued and all
/// other sessions end. Returns `None` if the response is invalid, expired or repeated.
///
/// # Errors
/// Fails if the passkey is registered already, or the database fails.
pub async fn make(
    state: &Service,
    person: &CurrentPerson,
    answer: PasskeyAnswer<'_>,
) -> Result<Option<Enrolled>, Error> {
    let key = PersonKey::from(person);
    let party = state.relying_party.as_deref().ok_or_else(no_site)?;
    let made = match take(state, key, answer.question).await? {
        Some(PasskeyChallenge::ToMake { name, challenge }) => {
            party.verify_registration(answer.json, &challenge).ok().map(|made| (name, made))
        }
        _ => None,
    };
    let Some((name, made)) = made else {
        second_factor::note(state, key, "passkey.refused").await?;
        return Ok(None);
    };
    let first = !second_factors::is_second_factor_on(state.db.reader(), key).await?;
    // Hashing is slow on purpose, so it is done before the write lock is taken.
    let codes = if first { Some(second_factor::make_codes(state, key).await?) } else { None };
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    let json = made.to_json().context("a passkey cannot be written")?;
    let new =
        NewPasskey { id: PasskeyId::random(), name: &name, credential_id: made.id(), public_key: &json, made_at: now };
    if !passkeys::add_passkey(&mut tx, key, new).await? {
        return Err(Error::Conflict(tr!("this passkey is already registered here: create another").to_owned()));
    }
    let details = json!({ "passkey": new.id, "first": first });
    AuditEntry::by(person, "passkey.added", person.id).with(details).append(&mut tx, now).await?;
    let enrolled = match codes {
        Some((codes, hashes)) => {
            second_factors::put_recovery_codes(&mut tx, key, &hashes).await?;
            people::end_sign_ins(&mut tx, key.person_id).await?;
            Enrolled::First(codes)
        }
        None => Enrolled::Another,
    };
    tx.commit().await?;
    Ok(Some(enrolled))
}

/// Returns one of a person's passkeys.
///
/// # Errors
/// Fails if there is no passkey with this id, or the database fails.
pub async fn find(state: &Service, person: &CurrentPerson, id: PasskeyId) -> Result<KeptPasskey, Error> {
    passkeys::find_passkey(state.db.reader(), person.into(), id).await?.ok_or(Error::NotFound)
}

/// Renames a passkey.
///
/// # Errors
/// Fails if there is no passkey with this id, the name is not allowed, or the database fails.
pub async fn rename(state: &Service, person: &CurrentPerson, id: PasskeyId, name: &str) -> Result<(), Error> {
    let name = checked_name(name)?;
    let mut tx = state.db.write().await?;
    if !passkeys::rename_passkey(&mut tx, person.into(), id, &name).await? {
        return Err(Error::NotFound);
    }
    let details = json!({ "passkey": id });
    AuditEntry::by(person, "passkey.renamed", person.id).with(details).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// Removes a passkey. With the last second factor, the recovery codes are removed and a mail is
/// sent.
///
/// # Errors
/// Fails if there is no passkey with this id, or the database fails.
pub async fn remove(state: &Service, person: &CurrentPerson, id: PasskeyId) -> Result<(), Error> {
    let key = PersonKey::from(person);
    let mut tx = state.db.write().await?;
    if !passkeys::remove_passkey(&mut tx, key, id).await? {
        return Err(Error::NotFound);
    }
    let details = json!({ "passkey": id });
    AuditEntry::by(person, "passkey.removed", person.id).with(details).append(&mut tx, state.clock.now()).await?;
    second_factor::end_if_last(&mut tx, person, state.clock.now()).await?;
    tx.commit().await?;
    state.mails.notify_one();
    Ok(())
}
