//! The metadata record `stylet.signature`: a station's signature of an attempt made on it.
//!
//! The signature covers the session, the motion and the conditions. Forces, events and energies
//! follow from these: a verifier re-simulates them.

use std::collections::BTreeMap;

use uuid::Uuid;

use crate::error::ReadError;
use crate::motion::AttemptHashes;
use crate::session::Session;

/// Name of the metadata record.
pub const RECORD: &str = "stylet.signature";
/// Prefix of the signed bytes (domain separation), so that a signature is never accepted for
/// another kind of statement.
const DOMAIN: &str = "stylet.signature 2";

/// A station's signature.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signature {
    /// The station's id at its school.
    pub station: Uuid,
    /// Ed25519, 128 hexadecimal digits.
    pub ed25519: String,
}

impl Signature {
    /// Converts to the text of the metadata record.
    #[must_use]
    pub fn to_text(&self) -> BTreeMap<String, String> {
        let pairs = [("station", self.station.to_string()), ("ed25519", self.ed25519.clone())];
        pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
    }

    /// Parses the signature in a metadata record.
    ///
    /// # Errors
    /// If a key is missing or a value is not allowed; names the key and the allowed values.
    pub fn from_text(text: &BTreeMap<String, String>) -> Result<Self, ReadError> {
        let field = |key: &str| text.get(key).map(String::as_str).unwrap_or_default();
        let bad = |key: &str, allowed: &str| {
            ReadError::missing(
                format!("metadata {RECORD}: {key} = {:?}", field(key)),
                format!("only {allowed} is allowed"),
            )
        };
        let ed25519 = field("ed25519");
        if ed25519.len() != 128 || !ed25519.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            return Err(bad("ed25519", "128 hexadecimal digits"));
        }
        let station = field("station").parse().map_err(|_| bad("station", "a UUID"))?;
        Ok(Self { station, ed25519: ed25519.to_owned() })
    }
}

/// Returns the bytes that a station signs for an attempt: fields in this order, each after its
/// length in bytes as four bytes, little-endian. Numbers are little-endian, and doubles keep every
/// bit.
#[must_use]
pub fn signed_statement(session: &Session, station: Uuid, hashes: &AttemptHashes) -> Vec<u8> {
    // Destructured without `..`, so that a new field of a session cannot be forgotten here.
    let Session {
        session_id,
        exercise_id,
        exercise_sha256,
        scene_sha256,
        simulator_version,
        git,
        device,
        device_max_force_n,
        law,
        judging,
        tick_hz,
        seed,
        trainee,
        started_at,
        patient_thickness_mm,
    } = session;
    let text = |text: &String| text.clone().into_bytes();
    let double = |number: &f64| number.to_bits().to_le_bytes().to_vec();
    let fields: [Vec<u8>; 19] = [
        DOMAIN.into(),
        station.as_bytes().to_vec(),
        session_id.as_bytes().to_vec(),
        text(exercise_id),
        text(exercise_sha256),
        text(scene_sha256),
        text(simulator_version),
        text(git),
        text(device),
        double(device_max_force_n),
        u32::from(*law).to_le_bytes().to_vec(),
        judging.number().to_le_bytes().to_vec(),
        double(tick_hz),
        seed.to_le_bytes().to_vec(),
        text(trainee),
        started_at.unix_timestamp_nanos().to_le_bytes().to_vec(),
        patient_thickness_mm.iter().flat_map(double).collect(),
        hashes.motion.to_vec(),
        hashes.conditions.to_vec(),
    ];
    fields.iter().flat_map(|field| length_bytes(field).into_iter().chain(field.iter().copied())).collect()
}

#[expect(clippy::expect_used, reason = "the texts of a session are a line each, and its numbers a few bytes")]
fn length_bytes(field: &[u8]) -> [u8; 4] {
    u32::try_from(field.len()).expect("a field is shorter than 4 GB").to_le_bytes()
}
