//! Status lists: which badges were revoked, one bit each (Bitstring Status List 1.0).

use std::io::Write;

use anyhow::ensure;
use data_encoding::BASE64URL_NOPAD;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Value, json};

use super::identity::IssuerAddress;
use super::proof::{BadgeSigner, DATE_TIME};
use super::quads::{Quads, TypedValue, check_address};
use super::{CREDENTIALS, CREDENTIALS_CONTEXT, STATUS};

/// Number of badges in a list: the smallest that the recommendation allows, so that a request for
/// the list does not show which badge is checked.
const PLACES: u64 = 131_072;

/// The place of a badge in the status lists of a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct StatusPlace(i64);

impl StatusPlace {
    /// Returns the place with this number, counted through all lists; the first one is 0.
    #[must_use]
    pub fn numbered(number: i64) -> Self {
        Self(number.max(0))
    }

    /// Returns the place at an index of a list; `None` if there is no such index.
    #[must_use]
    pub fn of(list: u64, index: u64) -> Option<Self> {
        let number = list.checked_mul(PLACES)?.checked_add(index)?;
        let number = i64::try_from(number).ok()?;
        (index < PLACES).then_some(Self(number))
    }

    /// Returns the number of the list.
    #[must_use]
    pub fn list(self) -> u64 {
        self.0.unsigned_abs() / PLACES
    }

    /// Returns the index within the list.
    #[must_use]
    pub fn index(self) -> u64 {
        self.0.unsigned_abs() % PLACES
    }

    /// Returns the number, counted through all lists.
    #[must_use]
    pub const fn number(self) -> i64 {
        self.0
    }
}

/// A status list without its proof.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StatusList<'a> {
    /// The service that publishes it.
    pub issuer: &'a IssuerAddress,
    /// Number of the list.
    pub list: u64,
    /// The revoked badges of this list.
    pub revoked: Vec<StatusPlace>,
    /// Time from which it is valid, RFC 3339 in whole seconds.
    pub valid_from: String,
    /// Time until which it is valid: an old copy must not hide a revocation.
    pub valid_until: String,
}

impl StatusList<'_> {
    /// Returns the list with its proof.
    ///
    /// # Errors
    /// If a place belongs to another list, or an address is not an address.
    pub fn sign(&self, signer: BadgeSigner<'_>) -> anyhow::Result<Value> {
        let encoded = encode_bits(&self.bits()?)?;
        Ok(signer.add_proof(self.credential(&encoded), &self.quads(&encoded)?))
    }

    fn bits(&self) -> anyhow::Result<Vec<u8>> {
        let mut bits = vec![0_u8; usize::try_from(PLACES / 8)?];
        for place in &self.revoked {
            ensure!(place.list() == self.list, "{place:?} is not in list {}", self.list);
            let index = usize::try_from(place.index())?;
            // The first bit is the highest of the first byte.
            bits[index / 8] |= 0x80 >> (index % 8);
        }
        Ok(bits)
    }

    fn credential(&self, encoded: &str) -> Value {
        let id = self.issuer.status_list(self.list);
        json!({
            "@context": [CREDENTIALS_CONTEXT],
            "id": id,
            "type": ["VerifiableCredential", "BitstringStatusListCredential"],
            "issuer": self.issuer.did,
            "validFrom": self.valid_from,
            "validUntil": self.valid_until,
            "credentialSubject": {
                "id": format!("{id}#list"),
                "type": "BitstringStatusList",
                "statusPurpose": "revocation",
                "encodedList": encoded,
            },
        })
    }

    pub(super) fn quads(&self, encoded: &str) -> anyhow::Result<String> {
        let id = self.issuer.status_list(self.list);
        let subject = format!("{id}#list");
        let credentials = |name: &str| format!("{CREDENTIALS}{name}");
        let statuses = |name: &str| format!("{STATUS}{name}");
        check_address(&id)?;
        let mut quads = Quads::default();
        quads.add_type(&id, &credentials("VerifiableCredential"));
        quads.add_type(&id, &statuses("BitstringStatusListCredential"));
        quads.add_node(&id, &credentials("issuer"), &self.issuer.did);
        for (property, value) in [("validFrom", &self.valid_from), ("validUntil", &self.valid_until)] {
            quads.add_typed(&id, &credentials(property), TypedValue { value, datatype: DATE_TIME });
        }
        quads.add_node(&id, &credentials("credentialSubject"), &subject);
        quads.add_type(&subject, &statuses("BitstringStatusList"));
        quads.add_text(&subject, &statuses("statusPurpose"), "revocation");
        let encoded = TypedValue { value: encoded, datatype: "https://w3id.org/security#multibase" };
        quads.add_typed(&subject, &statuses("encodedList"), encoded);
        Ok(quads.canonical())
    }
}

/// Packs bits with GZIP, and encodes them as Multibase in base64url.
fn encode_bits(bits: &[u8]) -> anyhow::Result<String> {
    let mut packer = GzEncoder::new(Vec::new(), Compression::best());
    packer.write_all(bits)?;
    Ok(format!("u{}", BASE64URL_NOPAD.encode(&packer.finish()?)))
}
