//! Converts the session to and from the text of the metadata record `stylet.session`. Every f64
//! round-trips exactly.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

use law::Judging;
use law::axial::ForceLaw;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::error::{ReadError, WriteError};
use crate::session::Session;

/// Name of the metadata record.
pub(crate) const RECORD: &str = "stylet.session";

/// Years that message times can represent.
const YEARS: RangeInclusive<i32> = 1970..=2105;
/// Maximum length of a name, in bytes.
const LONGEST_NAME: usize = 256;
/// Description of an allowed name.
const NAME: &str = "a text of at most 256 bytes in one line";
/// Maximum number of a patient's layers.
const MOST_LAYERS: usize = 256;

impl Session {
    /// Converts to the text of the metadata record.
    ///
    /// # Errors
    /// If a value is not allowed in a recording.
    pub fn to_text(&self) -> Result<BTreeMap<String, String>, WriteError> {
        to_text(self)
    }

    /// Converts from the text of the metadata record.
    ///
    /// # Errors
    /// If a key is missing or a value is not allowed; names the key and the allowed values.
    pub fn from_text(text: &BTreeMap<String, String>) -> Result<Self, ReadError> {
        from_text(text)
    }
}

/// Converts a session to text.
pub(crate) fn to_text(session: &Session) -> Result<BTreeMap<String, String>, WriteError> {
    let started_at = session.started_at.to_offset(time::UtcOffset::UTC).format(&Rfc3339);
    let started_at = started_at.map_err(|e| WriteError::invalid("started_at", session.started_at, e))?;
    if !(session.tick_hz > 0.0 && session.tick_hz.is_finite()) {
        return Err(WriteError::invalid("tick_hz", session.tick_hz, "allowed: a finite rate above 0 Hz"));
    }
    let names = [&session.exercise_id, &session.simulator_version, &session.git, &session.device, &session.trainee];
    if let Some(unfit) = names.into_iter().find(|name| !is_name(name)) {
        return Err(WriteError::invalid("a name", format!("{unfit:?}"), NAME));
    }
    let thickness = serde_json::to_string(&session.patient_thickness_mm)
        .map_err(|e| WriteError::invalid("patient_thickness_mm", "", e))?;
    let pairs = [
        ("session_id", session.session_id.to_string()),
        ("exercise_id", session.exercise_id.clone()),
        ("exercise_sha256", session.exercise_sha256.clone()),
        ("scene_sha256", session.scene_sha256.clone()),
        ("simulator_version", session.simulator_version.clone()),
        ("git", session.git.clone()),
        ("device", session.device.clone()),
        ("device_max_force_n", session.device_max_force_n.to_string()),
        ("law", u32::from(session.law).to_string()),
        ("field", session.judging.number().to_string()),
        ("tick_hz", session.tick_hz.to_string()),
        ("seed", session.seed.to_string()),
        ("trainee", session.trainee.clone()),
        ("started_at", started_at),
        ("patient_thickness_mm", thickness),
    ];
    Ok(pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect())
}

/// Parses the session in a metadata record.
pub(crate) fn from_text(text: &BTreeMap<String, String>) -> Result<Session, ReadError> {
    let owned = |key: &str| read_name(text, key);
    let device_max_force_n: f64 = parse_field(text, "device_max_force_n", "a number of N or inf")?;
    let tick_hz: f64 = parse_field(text, "tick_hz", "a number of Hz")?;
    check_number("device_max_force_n", device_max_force_n, device_max_force_n >= 0.0, "0 N or more")?;
    check_number("tick_hz", tick_hz, tick_hz > 0.0 && tick_hz.is_finite(), "a finite rate above 0 Hz")?;
    let started_at = read_field(text, "started_at")?;
    let thickness = read_field(text, "patient_thickness_mm")?;
    Ok(Session {
        session_id: parse_field(text, "session_id", "a UUID")?,
        exercise_id: owned("exercise_id")?,
        exercise_sha256: owned("exercise_sha256")?,
        scene_sha256: owned("scene_sha256")?,
        simulator_version: owned("simulator_version")?,
        git: owned("git")?,
        device: owned("device")?,
        device_max_force_n,
        law: read_force_law(text)?,
        judging: read_judging(text)?,
        tick_hz,
        seed: parse_field(text, "seed", "a whole number of 64 bits")?,
        trainee: owned("trainee")?,
        started_at: OffsetDateTime::parse(started_at, &Rfc3339)
            .ok()
            .filter(|time| YEARS.contains(&time.to_offset(time::UtcOffset::UTC).year()))
            .ok_or_else(|| bad_field("started_at", started_at, "a time as in RFC 3339, from 1970 to 2105"))?,
        patient_thickness_mm: serde_json::from_str(thickness)
            .ok()
            .filter(|layers: &Vec<f64>| layers.len() <= MOST_LAYERS)
            .ok_or_else(|| bad_field("patient_thickness_mm", thickness, "a JSON list of at most 256 numbers in mm"))?,
    })
}

/// Reads a name, a version or a hash: a short single-line text.
fn read_name(text: &BTreeMap<String, String>, key: &str) -> Result<String, ReadError> {
    let value = read_field(text, key)?;
    if is_name(value) { Ok(value.to_owned()) } else { Err(bad_field(key, value, NAME)) }
}

fn is_name(text: &str) -> bool {
    text.len() <= LONGEST_NAME && !text.chars().any(char::is_control)
}

/// Reads the version of the force law. Files written before version 2 lack the key.
fn read_force_law(text: &BTreeMap<String, String>) -> Result<ForceLaw, ReadError> {
    let Some(value) = text.get("law") else { return Ok(ForceLaw::Version1) };
    let law = value.parse().ok().and_then(|number: u32| ForceLaw::try_from(number).ok());
    law.ok_or_else(|| bad_field("law", value, "1 to 5"))
}

/// Reads how the field was computed and judged. Files written before the second method lack the
/// key.
fn read_judging(text: &BTreeMap<String, String>) -> Result<Judging, ReadError> {
    let Some(value) = text.get("field") else { return Ok(Judging::First) };
    let judging = value.parse().ok().and_then(Judging::of_number);
    judging.ok_or_else(|| bad_field("field", value, "1 to 4"))
}

fn read_field<'a>(text: &'a BTreeMap<String, String>, key: &str) -> Result<&'a str, ReadError> {
    let value = text.get(key).map(String::as_str);
    value.ok_or_else(|| ReadError::missing(format!("metadata {RECORD}: {key}"), "missing"))
}

fn parse_field<T: FromStr>(text: &BTreeMap<String, String>, key: &str, allowed: &str) -> Result<T, ReadError> {
    let value = read_field(text, key)?;
    value.parse().map_err(|_| bad_field(key, value, allowed))
}

fn check_number(key: &str, value: f64, good: bool, allowed: &str) -> Result<(), ReadError> {
    if good { Ok(()) } else { Err(bad_field(key, value, allowed)) }
}

fn bad_field(key: &str, value: impl Display, allowed: &str) -> ReadError {
    // Enough of the value to identify it.
    let value: String = value.to_string().chars().take(80).collect();
    ReadError::missing(format!("metadata {RECORD}: {key} = {value}"), format!("only {allowed} is allowed"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a record with this value of the key `field`.
    fn record(field: Option<&str>) -> BTreeMap<String, String> {
        let words = [
            ("session_id", "018f4c1e-7a2b-7c3d-8e4f-0123456789ab"),
            ("device_max_force_n", "inf"),
            ("tick_hz", "1000"),
            ("seed", "1"),
            ("started_at", "2031-05-06T07:08:09Z"),
            ("patient_thickness_mm", "[0.8]"),
        ];
        let empty = ["exercise_id", "exercise_sha256", "scene_sha256", "simulator_version", "git", "device", "trainee"];
        let all = words.into_iter().chain(empty.map(|key| (key, ""))).chain(field.map(|field| ("field", field)));
        all.map(|(key, value)| (key.to_owned(), value.to_owned())).collect()
    }

    #[test]
    fn file_without_a_judging_version_uses_the_first() {
        assert_eq!(from_text(&record(None)).unwrap().judging, Judging::First);
        assert_eq!(from_text(&record(Some("2"))).unwrap().judging, Judging::Second);
        assert_eq!(from_text(&record(Some("3"))).unwrap().judging, Judging::Third);
        assert_eq!(from_text(&record(Some("4"))).unwrap().judging, Judging::Fourth);
        let error = from_text(&record(Some("5"))).unwrap_err().to_string();
        assert!(error.contains("field = 5") && error.contains("1 to 4"), "{error}");
    }
}
