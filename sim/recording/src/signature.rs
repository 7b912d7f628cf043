//! The metadata record `stylet.signature`: a station vouches for what a hand has done at it.
//!
//! What is signed is who did what, when and on which documents. Forces and events are not: they follow from it, and
//! whoever asks for a proof re-simulates them.

use std::collections::BTreeMap;

use uuid::Uuid;

use crate::error::ReadError;
use crate::session::Session;

/// Name of the metadata record.
pub const RECORD: &str = "stylet.signature";
/// Begins what is signed, so that the signature of one thing is never taken for that of another.
const DOMAIN: &str = "stylet.signature 1";

/// A station's signature.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signature {
    /// The station's id at its school.
    pub station: Uuid,
    /// Ed25519, 128 hexadecimal digits.
    pub ed25519: String,
}

impl Signature {
    /// As the text of its record.
    #[must_use]
    pub fn to_text(&self) -> BTreeMap<String, String> {
        let pairs = [("station", self.station.to_string()), ("ed25519", self.ed25519.clone())];
        pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
    }

    /// The signature that a record states.
    ///
    /// # Errors
    /// When something is missing or is not what is allowed; which, and what is.
    pub fn from_text(text: &BTreeMap<String, String>) -> Result<Self, ReadError> {
        let field = |key: &str| text.get(key).map(String::as_str).unwrap_or_default();
        let bad = |key: &str, allowed: &str| {
            ReadError::missing(format!("metadata {RECORD}: {key} = {:?}", field(key)), format!("allowed is {allowed}"))
        };
        let ed25519 = field("ed25519");
        if ed25519.len() != 128 || !ed25519.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            return Err(bad("ed25519", "128 hexadecimal digits"));
        }
        let station = field("station").parse().map_err(|_| bad("station", "a UUID"))?;
        Ok(Self { station, ed25519: ed25519.to_owned() })
    }
}

/// What a station signs of a session and of its motion: fields in this order, each after its length in bytes as four bytes,
/// little-endian.
#[must_use]
pub fn signed_statement(session: &Session, station: Uuid, motion_sha256: &[u8; 32]) -> Vec<u8> {
    let started_ns = session.started_at.unix_timestamp_nanos();
    let thickness = session.patient_thickness_mm.iter().flat_map(|mm| mm.to_bits().to_le_bytes()).collect();
    let fields: [Vec<u8>; 12] = [
        DOMAIN.into(),
        station.as_bytes().to_vec(),
        session.session_id.as_bytes().to_vec(),
        session.exercise_id.clone().into_bytes(),
        session.exercise_sha256.clone().into_bytes(),
        session.scene_sha256.clone().into_bytes(),
        session.device.clone().into_bytes(),
        session.trainee.clone().into_bytes(),
        started_ns.to_le_bytes().to_vec(),
        session.seed.to_le_bytes().to_vec(),
        thickness,
        motion_sha256.to_vec(),
    ];
    fields.iter().flat_map(|field| length_bytes(field).into_iter().chain(field.iter().copied())).collect()
}

#[expect(clippy::expect_used, reason = "the texts of a session are a line each, and its numbers a few bytes")]
fn length_bytes(field: &[u8]) -> [u8; 4] {
    u32::try_from(field.len()).expect("a field is shorter than 4 GB").to_le_bytes()
}
