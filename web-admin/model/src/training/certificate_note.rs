//! The short form of a certificate, with its own signature: short enough for the QR code on a
//! printed certificate, with which anyone can check it on a page of the service. It is not stored;
//! the signature is sufficient.

use anyhow::{Context, ensure};
use data_encoding::BASE64URL_NOPAD;
use ed25519_dalek::{Signature, Signer, SigningKey, Verifier};
use serde::{Deserialize, Serialize};

/// Who mastered which course, and when. It cannot be parsed as a
/// [`Statement`](crate::training::certificate::Statement), which is signed with the same key.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertificateNote {
    /// Version of the format.
    pub note: u32,
    /// Name of the school.
    pub school: String,
    /// Name of the person who mastered the course.
    pub trainee: String,
    /// Title of the course.
    pub course: String,
    /// Time at which the certificate was issued, RFC 3339.
    pub issued_at: String,
}

/// Maximum length of a note in a URL, in characters: it limits the work for decoding.
const LONGEST: usize = 4000;

impl CertificateNote {
    /// Version of the format that is written.
    pub const VERSION: u32 = 1;

    /// Returns the query of the page that checks the note: `of` is the note and `by` the signature,
    /// both in base64url.
    ///
    /// # Errors
    /// If the serialization fails, which does not happen.
    pub fn signed_query(&self, key: &SigningKey) -> serde_json::Result<String> {
        let text = serde_json::to_string(self)?;
        let by = BASE64URL_NOPAD.encode(&key.sign(text.as_bytes()).to_bytes());
        Ok(format!("of={}&by={by}", BASE64URL_NOPAD.encode(text.as_bytes())))
    }

    /// Verifies and parses a note.
    ///
    /// # Errors
    /// If it is not a note, was modified, or was signed with another key.
    pub fn check(of: &str, by: &str, key: &SigningKey) -> anyhow::Result<Self> {
        ensure!(of.len() <= LONGEST, "of: {} characters; at most {LONGEST} are allowed", of.len());
        let text = BASE64URL_NOPAD.decode(of.as_bytes()).context("of: not base64")?;
        let signature = BASE64URL_NOPAD.decode(by.as_bytes()).context("by: not base64")?;
        let signature = Signature::from_slice(&signature).context("by: a signature has 64 bytes")?;
        key.verifying_key().verify(&text, &signature).ok().context("the signature does not match this note")?;
        let note: Self = serde_json::from_slice(&text).context("a note of an unknown version")?;
        ensure!(note.note == Self::VERSION, "note {}; allowed: {}", note.note, Self::VERSION);
        Ok(note)
    }
}

#[cfg(test)]
mod tests {
    //! Checks that modified notes, those signed with another key, and complete statements are
    //! rejected.

    use super::*;
    use crate::training::certificate::sign_text;

    fn note() -> CertificateNote {
        CertificateNote {
            note: CertificateNote::VERSION,
            school: "Nordklinik".to_owned(),
            trainee: "Ada Größer".to_owned(),
            course: "Lower back".to_owned(),
            issued_at: "2026-11-23T22:00:00Z".to_owned(),
        }
    }

    fn parts(query: &str) -> (String, String) {
        let (of, by) = query.split_once("&by=").expect("two parts");
        (of.trim_start_matches("of=").to_owned(), by.to_owned())
    }

    #[test]
    fn a_note_is_checked_by_its_key_alone() {
        let key = SigningKey::from_bytes(&[7; 32]);
        let (of, by) = parts(&note().signed_query(&key).expect("JSON"));
        assert_eq!(CertificateNote::check(&of, &by, &key).expect("genuine"), note());
        let other = CertificateNote { trainee: "Bob".to_owned(), ..note() };
        let forged = parts(&other.signed_query(&SigningKey::from_bytes(&[8; 32])).expect("JSON"));
        assert!(CertificateNote::check(&forged.0, &forged.1, &key).is_err(), "another key");
        assert!(CertificateNote::check(&forged.0, &by, &key).is_err(), "another name");
        for (of, by) in [("", ""), ("x", by.as_str()), (of.as_str(), "AAAA"), (&"A".repeat(5000), &by)] {
            assert!(CertificateNote::check(of, by, &key).is_err(), "{of} {by}");
        }
        let statement = sign_text(&key, "{\"format\":2}");
        let signature = data_encoding::HEXLOWER.decode(statement.signature.as_bytes()).expect("hexadecimal");
        let statement = BASE64URL_NOPAD.encode(statement.statement.as_bytes());
        assert!(CertificateNote::check(&statement, &BASE64URL_NOPAD.encode(&signature), &key).is_err());
    }
}
