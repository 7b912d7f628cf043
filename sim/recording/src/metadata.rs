//! The session as the text of the metadata record `stylet.session`, and back. Every f64 returns to the bit.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::str::FromStr;

use mechanics::axial::ForceLaw;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::read::ReadError;
use crate::session::Session;
use crate::write::WriteError;

/// Name of the metadata record.
pub(crate) const RECORD: &str = "stylet.session";

/// The session as text.
pub(crate) fn to_text(session: &Session) -> Result<BTreeMap<String, String>, WriteError> {
    let started_at = session.started_at.to_offset(time::UtcOffset::UTC).format(&Rfc3339);
    let started_at = started_at.map_err(|e| WriteError::invalid("started_at", session.started_at, e))?;
    if !(session.tick_hz > 0.0 && session.tick_hz.is_finite()) {
        return Err(WriteError::invalid("tick_hz", session.tick_hz, "a finite rate above 0 Hz is allowed"));
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
        ("tick_hz", session.tick_hz.to_string()),
        ("seed", session.seed.to_string()),
        ("trainee", session.trainee.clone()),
        ("started_at", started_at),
        ("patient_thickness_mm", thickness),
    ];
    Ok(pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect())
}

/// The session that a metadata record states.
pub(crate) fn from_text(text: &BTreeMap<String, String>) -> Result<Session, ReadError> {
    let owned = |key: &str| field(text, key).map(str::to_owned);
    let device_max_force_n: f64 = parsed(text, "device_max_force_n", "a number of N or inf")?;
    let tick_hz: f64 = parsed(text, "tick_hz", "a number of Hz")?;
    check("device_max_force_n", device_max_force_n, device_max_force_n >= 0.0, "0 N or more")?;
    check("tick_hz", tick_hz, tick_hz > 0.0 && tick_hz.is_finite(), "a finite rate above 0 Hz")?;
    let started_at = field(text, "started_at")?;
    let thickness = field(text, "patient_thickness_mm")?;
    Ok(Session {
        session_id: parsed(text, "session_id", "a UUID")?,
        exercise_id: owned("exercise_id")?,
        exercise_sha256: owned("exercise_sha256")?,
        scene_sha256: owned("scene_sha256")?,
        simulator_version: owned("simulator_version")?,
        git: owned("git")?,
        device: owned("device")?,
        device_max_force_n,
        law: law(text)?,
        tick_hz,
        seed: parsed(text, "seed", "a whole number of 64 bits")?,
        trainee: owned("trainee")?,
        started_at: OffsetDateTime::parse(started_at, &Rfc3339)
            .map_err(|_| bad("started_at", started_at, "a time as in RFC 3339"))?,
        patient_thickness_mm: serde_json::from_str(thickness)
            .map_err(|_| bad("patient_thickness_mm", thickness, "a JSON list of numbers in mm"))?,
    })
}

/// The version of the force law. Files of before there was a second one do not say.
fn law(text: &BTreeMap<String, String>) -> Result<ForceLaw, ReadError> {
    let Some(value) = text.get("law") else { return Ok(ForceLaw::Version1) };
    let law = value.parse().ok().and_then(|number: u32| ForceLaw::try_from(number).ok());
    law.ok_or_else(|| bad("law", value, "1 or 2"))
}

fn field<'a>(text: &'a BTreeMap<String, String>, key: &str) -> Result<&'a str, ReadError> {
    let value = text.get(key).map(String::as_str);
    value.ok_or_else(|| ReadError::missing(format!("metadata {RECORD}: {key}"), "not there"))
}

fn parsed<T: FromStr>(text: &BTreeMap<String, String>, key: &str, allowed: &str) -> Result<T, ReadError> {
    let value = field(text, key)?;
    value.parse().map_err(|_| bad(key, value, allowed))
}

fn check(key: &str, value: f64, good: bool, allowed: &str) -> Result<(), ReadError> {
    if good { Ok(()) } else { Err(bad(key, value, allowed)) }
}

fn bad(key: &str, value: impl Display, allowed: &str) -> ReadError {
    ReadError::missing(format!("metadata {RECORD}: {key} = {value}"), format!("allowed is {allowed}"))
}
