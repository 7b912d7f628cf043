//! Training stations: how one joins a school, and how somebody signs in at one. Both by codes short enough to type.

use model::ids::{PersonId, SchoolId, StationId};
use model::{CurrentPerson, Moment, PersonKey, Role, line};
use serde_json::json;
use store::audit::{Actor, AuditEntry};
use store::people::Person;
use store::stations::{self, PairingCode, WrongCodes};
use store::studies::{self, Study};
use store::tokens::{self, Token, TokenHolder};
use store::{schools, sign_in_codes};

use crate::error::Error;
use crate::service::Service;
use crate::study_consents::{consent_at_station, revision_of_terms};
use crate::{keys, secret};

/// How long a pairing code is good, in s.
pub const PAIRING_CODE_LIFETIME_S: i64 = 600;
/// Letters of a pairing code: 40 bits for ten minutes.
const PAIRING_LETTERS: usize = 8;
/// Letters of a sign-in code: 30 bits, behind a station's token and its brake.
const SIGN_IN_LETTERS: usize = 6;
/// Wrong sign-in codes that a station may pass on in [`LOCKOUT_S`] before it is locked for the rest of them.
const WRONG_CODES: u32 = 20;
/// In s.
const LOCKOUT_S: i64 = 3600;
/// How exactly it is noted when a station was seen, in s.
const SIGHT_S: i64 = 60;
const HOUR_S: i64 = 3600;
/// Longest name of a station, in characters.
const LONGEST_NAME: usize = 60;

/// A station that has just joined.
#[derive(Debug)]
pub struct Paired {
    /// Id.
    pub station_id: StationId,
    /// Its name.
    pub name: String,
    /// The school's name.
    pub school: String,
    /// Its token, which nobody sees again.
    pub token: String,
}

/// A station that asks for something.
#[derive(Clone, Debug)]
pub struct CallingStation {
    /// Its school.
    pub school_id: SchoolId,
    /// Id of its token.
    pub id: StationId,
    /// Name.
    pub name: String,
}

/// Makes a pairing code, as it is to be read out.
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

/// Lets a station join the school that a code leads to, with the public key by which its recordings will be known. The code
/// is used up, but not by a name that cannot be had.
///
/// # Errors
/// When the code is unknown, used or expired, the name is none or taken, or the key is none.
pub async fn pair(state: &Service, code: &str, name: &str, public_key: Option<&str>) -> Result<Paired, Error> {
    let (now, name) = (state.clock.now(), checked_name(name)?);
    if public_key.is_some_and(|key| keys::public_key(key).is_none()) {
        return Err(Error::Unprocessable("public_key: allowed is an Ed25519 key, 64 hexadecimal digits".to_owned()));
    }
    let mut tx = state.db.write().await?;
    let code = secret::token_sha256(&secret::plain_code(code));
    let Some(school_id) = stations::use_pairing_code(&mut tx, &code, now).await? else {
        return Err(Error::Forbidden("this code is unknown, used or expired: the administrator's page makes another"));
    };
    if stations::is_station_name_taken(&mut *tx, school_id, &name).await? {
        let why = format!("name: \"{name}\" is a station of this school; choose another name, or revoke that station");
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
        return Err(Error::Unprocessable(format!("name: {length} characters; 1 to {LONGEST_NAME} are allowed")));
    }
    if let Some(why) = line::refusal("name", name) {
        return Err(Error::Unprocessable(why));
    }
    Ok(name.to_owned())
}

/// Takes a station's token from it. False when there is none to take.
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

/// Makes one's own sign-in code, in place of the one before.
pub async fn make_sign_in_code(state: &Service, person: &CurrentPerson) -> Result<String, Error> {
    give_sign_in_code(state, person, person.id).await
}

/// Gives somebody of the maker's school a sign-in code, in place of the one they had.
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
        // One in a million that somebody has it already: then it is another.
        if sign_in_codes::put_sign_in_code(&mut tx, holder, &hash, now).await? {
            AuditEntry::by(maker, "sign_in_code.made", holder.person_id).append(&mut tx, now).await?;
            tx.commit().await?;
            return Ok(in_groups(&code));
        }
    }
}

/// What has come of a code that is somebody's.
#[derive(Debug)]
pub enum StationVisit {
    /// They sit at the station now.
    SignedIn(Box<Person>),
    /// A guest, who has yet to agree to what their study asks of them: the code is as good as before.
    ConsentAsked(Box<Study>),
}

/// A code that somebody types at a station.
#[derive(Clone, Copy, Debug)]
pub struct TypedCode<'a> {
    /// The code; case, spaces and hyphens do not matter.
    pub code: &'a str,
    /// The revision of what they have read and agreed to, where they are a guest.
    pub agreed: Option<&'a str>,
}

/// Whose code this is. A guest's is good once, with their agreement. A try counts as wrong until it proves right: so of many at once no more are made
/// than the brake allows, and a right one in between does not loosen it.
///
/// # Errors
/// When the code is nobody's or of a study that has ended, or the station has passed on too many wrong ones.
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
        return Err(Error::Forbidden("this is nobody's sign-in code; the page of one's account makes one"));
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

/// A code in two halves, which are easier to read and to type.
fn in_groups(code: &str) -> String {
    let (first, second) = code.split_at(code.len() / 2);
    format!("{first}-{second}")
}

/// Notes when a token of a person was used, to the hour: its owner sees whether it is needed, and not what they did when.
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

/// Notes when a station was seen, to the minute: a write for each request would slow uploads down.
pub async fn note_station_sight(state: &Service, token: &Token) -> Result<(), Error> {
    let now = state.clock.now();
    if token.last_seen_at.is_some_and(|seen| now < seen.plus_s(SIGHT_S)) {
        return Ok(());
    }
    let mut tx = state.db.write().await?;
    stations::note_station_seen(&mut tx, token.school_id, token.id, now).await?;
    Ok(tx.commit().await?)
}
