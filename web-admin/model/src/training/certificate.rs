//! Certificates of course mastery: signed, and verifiable without this service.
//!
//! A certificate consists of a statement, the public key, and an Ed25519 signature over the text of
//! the statement. It is JSON, either embedded in a readable page or alone. `docs/certificates.md`
//! specifies the format for other programs.

use anyhow::{Context, ensure};
use data_encoding::{HEXLOWER, HEXLOWER_PERMISSIVE};
use ed25519_dalek::{Signature, Signer, SigningKey, Verifier, VerifyingKey};
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

/// Disclaimer of every signed statement about a person.
pub const SCOPE: &str = "Simulated performance only; no statement about competence with patients.";
/// Supported versions of the format.
const KNOWN: std::ops::RangeInclusive<u32> = 1..=Statement::FORMAT;
/// Start of the certificate in a page.
const OPENING: &str = "<script type=\"application/json\" id=\"certificate\">";
/// Start of the certificate in a PDF.
const ATTACHED: &[u8] = b"{\"statement\":";
/// End of the certificate in a page.
const CLOSING: &str = "</script>";

/// The certified statement. All of it is data or English, because programs read it; the page around
/// it is for people.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Statement {
    /// Version of the format.
    pub format: u32,
    /// Name of the school.
    pub school: String,
    /// Name of the person who mastered the course.
    pub trainee: String,
    /// Their number at the school's registrar, where it is known. Layouts 1 and 2 did not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub registrar_id: Option<String>,
    /// The course's id.
    pub curriculum_id: String,
    /// Title of the course.
    pub course: String,
    /// SHA-256 of the course's document.
    pub curriculum_sha256: String,
    /// Mastery rule, as text.
    pub rule: String,
    /// Kind of attempts that the school accepts, as text. Missing in format 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub attempts: Option<String>,
    /// Exercises and the times at which they were mastered, RFC 3339.
    pub exercises: Vec<(String, String)>,
    /// Time of issue, RFC 3339.
    pub issued_at: String,
    /// Limits of the statement.
    pub scope: String,
}

impl Statement {
    /// The layout that is written today.
    pub const FORMAT: u32 = 3;
}

/// A signed statement. The signature covers the text of `statement`, byte for byte.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// A [`Statement`] as JSON.
    pub statement: String,
    /// Ed25519 public key, in hexadecimal.
    pub public_key: String,
    /// Ed25519 signature, in hexadecimal.
    pub signature: String,
}

impl Certificate {
    /// Returns JSON for embedding in a page: `<` is escaped, so that no name can end the
    /// surrounding element.
    ///
    /// # Errors
    /// If the serialization fails, which does not happen.
    pub fn in_page(&self) -> serde_json::Result<String> {
        Ok(serde_json::to_string(self)?.replace('<', "\\u003c"))
    }
}

/// Signs a statement.
///
/// # Errors
/// If the serialization fails, which does not happen.
pub fn sign_statement(key: &SigningKey, statement: &Statement) -> anyhow::Result<Certificate> {
    Ok(sign_text(key, &serde_json::to_string(statement)?))
}

/// Signs another kind of text with the same key. The text must not be parseable as a [`Statement`].
#[must_use]
pub fn sign_text(key: &SigningKey, text: &str) -> Certificate {
    let signature = HEXLOWER.encode(&key.sign(text.as_bytes()).to_bytes());
    Certificate { statement: text.to_owned(), public_key: public_key(key), signature }
}

/// Returns the public key in hexadecimal. Once published, it lets anyone check a certificate.
#[must_use]
pub fn public_key(key: &SigningKey) -> String {
    HEXLOWER.encode(&key.verifying_key().to_bytes())
}

/// Verifies a certificate, in a page or as JSON, with the public key published by the school.
/// Returns its statement.
///
/// # Errors
/// If it is not a certificate, was signed with another key, or was modified.
pub fn check_certificate(file: &[u8], published_key: &str) -> anyhow::Result<Statement> {
    let certificate: Certificate = serde_json::from_str(json_of(file)?).context("not a certificate")?;
    let text = checked_text(&certificate, published_key)?;
    let statement: Statement = serde_json::from_str(text).context("a statement of an unknown version")?;
    ensure!(KNOWN.contains(&statement.format), "format {}; allowed: 1 to {}", statement.format, Statement::FORMAT);
    Ok(statement)
}

/// Returns the signed text, if the signature is valid for the published key.
///
/// # Errors
/// If it was signed with another key, or was modified.
pub fn checked_text<'a>(certificate: &'a Certificate, published_key: &str) -> anyhow::Result<&'a str> {
    let published = published_key.trim().to_lowercase();
    ensure!(
        certificate.public_key == published,
        "signed with the key {}, not with {published}",
        certificate.public_key
    );
    let bytes: [u8; 32] = HEXLOWER_PERMISSIVE
        .decode(published.as_bytes())?
        .try_into()
        .ok()
        .context("a public key has 64 hexadecimal digits")?;
    let key = VerifyingKey::from_bytes(&bytes).context("not a public key")?;
    let signature = HEXLOWER_PERMISSIVE.decode(certificate.signature.as_bytes())?;
    let signature = Signature::from_slice(&signature).context("not a signature")?;
    key.verify(certificate.statement.as_bytes(), &signature)
        .ok()
        .context("the signature does not match this statement")?;
    Ok(&certificate.statement)
}

/// Returns the JSON embedded in a page or attached to a PDF, or the whole file.
fn json_of(file: &[u8]) -> anyhow::Result<&str> {
    if file.starts_with(b"%PDF-") {
        return attached_json(file);
    }
    let text = std::str::from_utf8(file).context("not a certificate")?;
    let Some((_, inside)) = text.split_once(OPENING) else { return Ok(text) };
    let (json, after) = inside.split_once(CLOSING).context("not a certificate: the page is truncated")?;
    ensure!(!after.contains(OPENING), "not a certificate: the page contains more than one");
    Ok(json)
}

/// Returns the JSON attached to a PDF of this service, which stores it without compression.
fn attached_json(file: &[u8]) -> anyhow::Result<&str> {
    let mut places = file.windows(ATTACHED.len()).enumerate().filter(|(_, window)| *window == ATTACHED);
    let (at, _) = places.next().context("not a certificate: nothing is attached")?;
    ensure!(places.next().is_none(), "not a certificate: the file contains more than one");
    let mut values = serde_json::Deserializer::from_slice(&file[at..]).into_iter::<IgnoredAny>();
    values.next().context("not a certificate")?.context("not a certificate: the file is truncated")?;
    std::str::from_utf8(&file[at..at + values.byte_offset()]).context("not a certificate")
}

#[cfg(test)]
mod tests {
    //! Checks that modified certificates and those signed with another key are rejected, as JSON
    //! and in a page.

    use super::*;

    fn key_pair(seed: u8) -> SigningKey {
        SigningKey::from_bytes(&[seed; 32])
    }

    fn sample() -> Statement {
        let file = include_str!("../../../../tests/data/certificate/statement.json");
        serde_json::from_str(file).expect("a statement")
    }

    fn page(json: &str) -> Vec<u8> {
        format!("<!doctype html><p>Ada</p>{OPENING}{json}{CLOSING}\n</html>").into_bytes()
    }

    #[test]
    fn a_page_is_what_is_signed_inside_it() {
        let ours = key_pair(7);
        let certificate = sign_statement(&ours, &sample()).expect("signed");
        let (key, json) = (certificate.public_key.clone(), certificate.in_page().expect("JSON"));
        assert_eq!(check_certificate(&page(&json), &key).expect("genuine"), sample());
        let [forged, unsigned] = [("Ada", "Bob"), (certificate.signature.as_str(), &"0".repeat(128))]
            .map(|(from, to)| page(&json.replace(from, to)));
        assert!(check_certificate(&forged, &key).is_err() && check_certificate(&unsigned, &key).is_err());
        let twice = [page(&json), page(&json)].concat();
        assert!(check_certificate(&twice, &key).expect_err("which one?").to_string().contains("more than one"));
        let whole = page(&json);
        for end in 0..whole.len() - 20 {
            assert!(check_certificate(&whole[..end], &key).is_err(), "cut after {end} bytes");
        }
    }

    #[test]
    fn a_pdf_is_what_is_attached_to_it() {
        let ours = key_pair(7);
        let certificate = sign_statement(&ours, &sample()).expect("signed");
        let (key, json) = (certificate.public_key.clone(), certificate.in_page().expect("JSON"));
        let pdf = |json: &str| [b"%PDF-1.7\n\xff stream\n", json.as_bytes(), b"\nendstream\n%%EOF"].concat();
        assert_eq!(check_certificate(&pdf(&json), &key).expect("genuine"), sample());
        assert!(check_certificate(&pdf(&json.replace("Ada", "Bob")), &key).is_err());
        assert!(check_certificate(&[pdf(&json), pdf(&json)].concat(), &key).is_err(), "which one?");
        assert!(check_certificate(b"%PDF-1.7", &key).is_err() && check_certificate(&pdf("{}"), &key).is_err());
    }

    #[test]
    fn a_certificate_verifies_and_a_changed_one_does_not() {
        let ours = key_pair(7);
        let certificate = sign_statement(&ours, &sample()).expect("signed");
        let published = public_key(&ours);
        let file = |certificate: &Certificate| serde_json::to_vec(certificate).expect("JSON");
        assert_eq!(check_certificate(&file(&certificate), &published).expect("genuine"), sample());
        let forged = Certificate { statement: certificate.statement.replace("Ada", "Bob"), ..certificate.clone() };
        assert!(check_certificate(&file(&forged), &published).is_err());
        let other = key_pair(8);
        let foreign = sign_statement(&other, &sample()).expect("signed");
        assert!(check_certificate(&file(&foreign), &published).is_err(), "another school's key");
        let swapped = Certificate { public_key: published.clone(), ..foreign };
        assert!(check_certificate(&file(&swapped), &published).is_err());
        assert!(
            check_certificate(b"{}", &published).is_err() && check_certificate(&file(&certificate), "no key").is_err()
        );
    }

    #[test]
    fn a_certificate_of_before_is_still_one() {
        let ours = key_pair(7);
        let before = Statement { format: 1, attempts: None, registrar_id: None, ..sample() };
        let certificate = sign_statement(&ours, &before).expect("signed");
        assert!(!certificate.statement.contains("attempts"));
        let checked = check_certificate(&serde_json::to_vec(&certificate).expect("JSON"), &certificate.public_key);
        assert_eq!(checked.expect("genuine"), before);
        let later = sign_statement(&ours, &Statement { format: Statement::FORMAT + 1, ..sample() }).expect("signed");
        assert!(check_certificate(&serde_json::to_vec(&later).expect("JSON"), &later.public_key).is_err());
    }
}
