//! Training stations: pairing with a school, and signing in at a station. Both use codes short
//! enough to type.

use model::ids::{PersonId, SchoolId, StationId};
use model::{CurrentPerson, Moment, PersonKey, Role, single_line_text};
use platform::{keys, secret};
use serde_json::json;
use store::audit::{Actor, AuditEntry};
use store::auth::tokens;
use store::auth::tokens::{Token, TokenHolder};
use store::operations::schools;
use store::people::Person;
use store::stations::{self, PairingCode, WrongCodes, sign_in_codes};
use store::studies::{self, Study};

use crate::error::Error;
use crate::privacy::study_consents::{consent_at_station, revision_of_terms};
use crate::service::Service;

/// Lifetime of a pairing code, in s.
pub const PAIRING_CODE_LIFETIME_S: i64 = 600;
/// Length of a pairing code, in letters: 40 bits, valid for ten minutes.
const PAIRING_LETTERS: usize = 8;
/// Length of a sign-in code, in letters: 30 bits, protected by a station's token and its rate
/// limit.
const SIGN_IN_LETTERS: usize = 6;
/// Number of wrong sign-in codes from one station within [`LOCKOUT_S`] after which it is locked for
/// the rest of that period.
const WRONG_CODES: u32 = 20;
/// Period over which wrong codes are counted, in s.
const LOCKOUT_S: i64 = 3600;
/// Resolution of a station's last activity, in s.
const SIGHT_S: i64 = 60;
const HOUR_S: i64 = 3600;
/// Maximum length of a station's name, in characters.
const LONGEST_NAME: usize = 60;

/// A newly paired station.
#[derive(Debug)]
pub struct Paired {
    /// Id.
    pub station_id: StationId,
    /// Its name.
    pub name: String,
    /// Name of the school.
    pub school: String,
    /// Its token; only a hash is stored.
    pub token: String,
}

/// A station that makes a request.
#[derive(Clone, Debug)]
pub struct CallingStation {
    /// Its school.
    pub school_id: SchoolId,
    /// Id of its token.
    pub id: StationId,
    /// Name.
    pub name: String,
}

/// Creates a pairing code, and returns it, formatted for reading, with its expiry.
pub async fn make_pairing_code(state: &Service, maker: &CurrentPerson) -> Result<(String, Moment), Error> {
    let (now, code) = (state.clock.now(), secret::random_code(PAIRING_LETTERS)?);
    let row =
        PairingCode { school_id: maker.school_id, made_by: maker.id, expires_at: now.plus_s(PAIRING_CODE_LIFETIME_S) };
    let mut tx = state.db.write().await?;
    stations::add_pairing_code(&mut tx, &row, &secret::token_sha256(&code), now).await?;
    AuditEntry::by(maker, "pairing_code.made", maker.school_id).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok((in_groups(&code), row.expires_at))
}

/// Pairs a station with the school of a pairing code, and stores the public key that verifies its
/// recordings. A successful pairing consumes the code; a rejected name does not.
///
/// # Errors
/// Fails if the code is unknown, used or expired, the name is empty or in use, or the key is
/// invalid.
pub async fn pair(state: &Service, code: &str, name: &str, public_key: Option<&str>) -> Result<Paired, Error> {
    let (now, name) = (state.clock.now(), checked_name(name)?);
    if public_key.is_some_and(|key| keys::public_key(key).is_none()) {
        return Err(Error::Unprocessable("public_key: allowed: an Ed25519 key, 64 hexadecimal digits".to_owned()));
    }
    let mut tx = state.db.write().await?;
    let code = secret::token_sha256(&secret::plain_code(code));
    let Some(school_id) = stations::use_pairing_code(&mut tx, &code, now).await? else {
        return Err(Error::Forbidden("this code is unknown, used or expired: an administrator can create another"));
    };
    if stations::is_station_name_taken(&mut *tx, school_id, &name).await? {
        let why = format!(
            "name: \"{name}\" is already a station of this school; choose another name, or revoke that station"
        );
        return Err(Error::Conflict(why));
    }
    let token = secret::random_hex()?;
    let holder = TokenHolder { school_id, person_id: None, station: Some(name.clone()) };
    let token_id = tokens::add_station_token(&mut tx, &holder, &secret::token_sha256(&token), now).await?;
    stations::note_station_seen(&mut tx, school_id, token_id, now).await?;
    let station_id = StationId::from(token_id);
    if let Some(key) = public_key {
        stations::set_station_key(&mut tx, school_id, station_id, key).await?;
    }
    AuditEntry::new(school_id, Actor::Station(name.clone()), "station.paired", station_id)
        .with(json!({ "public_key": public_key }))
        .append(&mut tx, now)
        .await?;
    let school = schools::find_school_name(&mut *tx, school_id).await?;
    tx.commit().await?;
    tracing::info!(station = %station_id, "station paired");
    Ok(Paired { station_id, name, school, token })
}

fn checked_name(given: &str) -> Result<String, Error> {
    let name = given.trim();
    let length = name.chars().count();
    if length == 0 || length > LONGEST_NAME {
        return Err(Error::Unprocessable(format!("name: {length} characters; allowed: 1 to {LONGEST_NAME}")));
    }
    if let Some(why) = single_line_text::refusal("name", name) {
        return Err(Error::Unprocessable(why));
    }
    Ok(name.to_owned())
}

/// Revokes a station's token. Returns false if it has no valid token.
pub async fn revoke(state: &Service, by: &CurrentPerson, station: StationId) -> Result<bool, Error> {
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    if !stations::revoke_station(&mut tx, by.school_id, station, now).await? {
        return Ok(false);
    }
    AuditEntry::by(by, "station.revoked", station).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(true)
}

/// Creates a person's own sign-in code, replacing the previous one.
pub async fn make_sign_in_code(state: &Service, person: &CurrentPerson) -> Result<String, Error> {
    give_sign_in_code(state, person, person.id).await
}

/// Creates a sign-in code for a person of the maker's school, replacing the previous one.
pub(crate) async fn give_sign_in_code(
    state: &Service,
    maker: &CurrentPerson,
    holder: PersonId,
) -> Result<String, Error> {
    loop {
        let code = secret::random_code(SIGN_IN_LETTERS)?;
        let hash = hash(state, maker.school_id, code.clone()).await?;
        let now = state.clock.now();
        let mut tx = state.db.write().await?;
        let holder = PersonKey { school_id: maker.school_id, person_id: holder };
        // With a probability of about 10⁻⁶ the code is in use: then draw another.
        if sign_in_codes::put_sign_in_code(&mut tx, holder, &hash, now).await? {
            AuditEntry::by(maker, "sign_in_code.made", holder.person_id).append(&mut tx, now).await?;
            tx.commit().await?;
            return Ok(in_groups(&code));
        }
    }
}

/// Result of a valid sign-in code.
#[derive(Debug)]
pub enum StationVisit {
    /// The person is signed in at the station.
    SignedIn(Box<Person>),
    /// A guest who has not yet consented to the terms of their study; the code stays valid.
    ConsentAsked(Box<Study>),
}

/// A code entered at a station.
#[derive(Clone, Copy, Debug)]
pub struct TypedCode<'a> {
    /// The code; case, spaces and hyphens are ignored.
    pub code: &'a str,
    /// Revision of the terms to which a guest has consented.
    pub agreed: Option<&'a str>,
}

/// Signs in the holder of a code. A guest's code is valid once, and requires consent. Each attempt
/// is counted as wrong before it is checked, so that concurrent attempts cannot exceed the limit. A
/// right code takes back only its own count, not those of earlier wrong codes.
///
/// # Errors
/// Fails if the code is unknown, its study has ended, or the station has sent too many wrong ones.
pub async fn sign_in(
    state: &Service,
    station: &CallingStation,
    TypedCode { code, agreed }: TypedCode<'_>,
) -> Result<StationVisit, Error> {
    take_try(state, station).await?;
    let hash = hash(state, station.school_id, secret::plain_code(code)).await?;
    let mut tx = state.db.write().await?;
    let known = sign_in_codes::find_code_holder(&mut *tx, station.school_id, &hash).await?;
    let Some(person) = known.filter(|person| person.disabled_at.is_none()) else {
        return Err(Error::Forbidden("unknown sign-in code; create a new one on your account page"));
    };
    let now = state.clock.now();
    stations::forgive_wrong_codes(&mut tx, station.school_id, station.id).await?;
    if person.role == Role::Guest {
        let guest = PersonKey { school_id: person.school_id, person_id: person.id };
        let Some(study) = studies::find_study_of_guest(&mut *tx, guest).await? else {
            return Err(Error::Forbidden("the study of this code has ended"));
        };
        if agreed != Some(revision_of_terms(&study).as_str()) {
            tx.commit().await?;
            return Ok(StationVisit::ConsentAsked(Box::new(study)));
        }
        consent_at_station(&mut tx, &station.name, &study, person.id, now).await?;
        sign_in_codes::end_sign_in_code(&mut tx, guest).await?;
    }
    let actor = Actor::Station(station.name.clone());
    let action = format!("{}.signed_in_at_station", person.role);
    let entry = AuditEntry::new(station.school_id, actor, &action, person.id);
    entry.append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(StationVisit::SignedIn(Box::new(person)))
}

async fn take_try(state: &Service, station: &CallingStation) -> Result<(), Error> {
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    let told = stations::find_wrong_codes(&mut *tx, station.school_id, station.id).await?;
    let wrong = match told.wrong_since {
        Some(since) if now < since.plus_s(LOCKOUT_S) => told,
        _ => WrongCodes { wrong_codes: 0, wrong_since: Some(now) },
    };
    if wrong.wrong_codes >= WRONG_CODES {
        let until = wrong.wrong_since.unwrap_or(now).plus_s(LOCKOUT_S);
        let wait_us = until.micros().saturating_sub(now.micros());
        return Err(Error::TooMany { retry_after_s: wait_us.unsigned_abs().div_ceil(1_000_000) });
    }
    let counted = WrongCodes { wrong_codes: wrong.wrong_codes + 1, ..wrong };
    stations::set_wrong_codes(&mut tx, station.school_id, station.id, counted).await?;
    Ok(tx.commit().await?)
}

async fn hash(state: &Service, school: SchoolId, code: String) -> Result<[u8; 32], Error> {
    let cost = state.config.password_cost;
    Ok(state.hash(move || secret::code_hash(&code, school.uuid().as_bytes(), cost)).await??)
}

/// Splits a code into two hyphenated halves, which are easier to read and to type.
fn in_groups(code: &str) -> String {
    let (first, second) = code.split_at(code.len() / 2);
    format!("{first}-{second}")
}

/// Records the use of a personal token, to the hour: enough for its owner to see whether it is in
/// use, without tracking their activity.
pub async fn note_token_use(state: &Service, token: &Token) -> Result<(), Error> {
    let now = state.clock.now();
    if token.last_seen_at.is_some_and(|seen| now < seen.plus_s(HOUR_S)) {
        return Ok(());
    }
    let hour = Moment::from_micros(now.micros() - now.micros().rem_euclid(HOUR_S * 1_000_000));
    let mut tx = state.db.write().await?;
    stations::note_station_seen(&mut tx, token.school_id, token.id, hour).await?;
    Ok(tx.commit().await?)
}

/// Records a station's activity, to the minute. A write for each request would slow down uploads.
pub async fn note_station_sight(state: &Service, token: &Token) -> Result<(), Error> {
    let now = state.clock.now();
    if token.last_seen_at.is_some_and(|seen| now < seen.plus_s(SIGHT_S)) {
        return Ok(());
    }
    let mut tx = state.db.write().await?;
    stations::note_station_seen(&mut tx, token.school_id, token.id, now).await?;
    Ok(tx.commit().await?)
}
