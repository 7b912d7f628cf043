//! Data Integrity proofs by the cryptosuite `eddsa-rdfc-2022`.

use anyhow::{Context, ensure};
use ed25519_dalek::{Signature, Signer, SigningKey, Verifier, VerifyingKey};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use super::identity::{IssuerAddress, digit_value, multibase};
use super::quads::{BLANK, Quads, TypedValue};

/// Datatype of times.
pub(super) const DATE_TIME: &str = "http://www.w3.org/2001/XMLSchema#dateTime";
/// Prefix of the security vocabulary.
const SECURITY: &str = "https://w3id.org/security#";

/// What signs a document.
#[derive(Clone, Copy, Debug)]
pub struct BadgeSigner<'a> {
    /// The issuer.
    pub issuer: &'a IssuerAddress,
    /// Its key.
    pub key: &'a SigningKey,
    /// Time of the signature, RFC 3339 in whole seconds.
    pub created: &'a str,
}

impl BadgeSigner<'_> {
    /// Adds a proof to a document with these canonical N-Quads.
    pub(super) fn add_proof(self, mut document: Value, quads: &str) -> Value {
        let method = self.issuer.key_id(&self.key.verifying_key());
        let signature = self.key.sign(&signed_bytes(self.created, &method, quads));
        let mut proof = proof_options(self.created, &method);
        proof["proofValue"] = multibase(&signature.to_bytes()).into();
        document["proof"] = proof;
        document
    }
}

/// Verifies a proof for a document with these canonical N-Quads.
///
/// # Errors
/// If the proof has other members, names another key, or does not match.
pub(super) fn check_proof(proof: &Value, quads: &str, method: &str, key: &VerifyingKey) -> anyhow::Result<()> {
    let text = |member: &str| proof[member].as_str().with_context(|| format!("proof without {member}"));
    let (created, value) = (text("created")?, text("proofValue")?);
    let mut options = proof_options(created, method);
    options["proofValue"] = value.into();
    ensure!(*proof == options, "the proof is not one by {method}");
    let signature = decode_signature(value).context("proofValue: not a signature in base58btc")?;
    let matches = key.verify(&signed_bytes(created, method, quads), &signature);
    matches.ok().context("the signature does not match this badge")
}

fn proof_options(created: &str, method: &str) -> Value {
    json!({
        "type": "DataIntegrityProof",
        "cryptosuite": "eddsa-rdfc-2022",
        "created": created,
        "verificationMethod": method,
        "proofPurpose": "assertionMethod",
    })
}

/// Returns the canonical N-Quads of the options of a proof.
pub(super) fn option_quads(created: &str, method: &str) -> String {
    let of = |name: &str| format!("{SECURITY}{name}");
    let mut quads = Quads::default();
    quads.add_type(BLANK, &of("DataIntegrityProof"));
    quads.add_typed(BLANK, "http://purl.org/dc/terms/created", TypedValue { value: created, datatype: DATE_TIME });
    let suite = TypedValue { value: "eddsa-rdfc-2022", datatype: &of("cryptosuiteString") };
    quads.add_typed(BLANK, &of("cryptosuite"), suite);
    quads.add_node(BLANK, &of("proofPurpose"), &of("assertionMethod"));
    quads.add_node(BLANK, &of("verificationMethod"), method);
    quads.canonical()
}

/// Returns the bytes that are signed: the hashes of the options and of the document.
fn signed_bytes(created: &str, method: &str, quads: &str) -> Vec<u8> {
    [Sha256::digest(option_quads(created, method)), Sha256::digest(quads)].concat()
}

/// Decodes a signature in base58btc. Only the encoding that [`multibase`] writes is accepted.
fn decode_signature(value: &str) -> Option<Signature> {
    let mut bytes = [0_u8; 64];
    for digit in value.strip_prefix('z')?.bytes() {
        let mut carry = digit_value(digit)?;
        for byte in bytes.iter_mut().rev() {
            carry += u32::from(*byte) * 58;
            *byte = carry.to_le_bytes()[0];
            carry >>= 8;
        }
        if carry > 0 {
            return None;
        }
    }
    (multibase(&bytes) == value).then(|| Signature::from_bytes(&bytes))
}
