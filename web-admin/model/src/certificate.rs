//! Certificates that a course was mastered: signed, and verifiable without this service.
//!
//! A certificate is what is certified, the public key, and an Ed25519 signature over the first part as it is written: in
//! JSON, inside a page that a person can read, or alone. `docs/certificates.md` is its description for whoever reads one
//! without this program.

use anyhow::{Context, ensure};
use data_encoding::{HEXLOWER, HEXLOWER_PERMISSIVE};
use ed25519_dalek::{Signature, Signer, SigningKey, Verifier, VerifyingKey};
use serde::{Deserialize, Serialize};

/// Versions that are understood.
const KNOWN: std::ops::RangeInclusive<u32> = 1..=Statement::FORMAT;
/// Begins the certificate in a page.
const OPENING: &str = "<script type=\"application/json\" id=\"certificate\">";
/// Ends it.
const CLOSING: &str = "</script>";

/// What is certified. All of it is data or English: it is read by a program, and the page around it speaks to people.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Statement {
    /// Version of this layout.
    pub format: u32,
    /// The school.
    pub school: String,
    /// Who mastered the course.
    pub trainee: String,
    /// Their number at the school's registrar, where it is known. Layouts 1 and 2 did not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub registrar_id: Option<String>,
    /// The course's id.
    pub curriculum_id: String,
    /// The course's title.
    pub course: String,
    /// SHA-256 of the course's document.
    pub curriculum_sha256: String,
    /// Its mastery rule in words.
    pub rule: String,
    /// By which attempts the school certifies, in words. Layout 1 did not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub attempts: Option<String>,
    /// Each exercise, and since when it is mastered, RFC 3339.
    pub exercises: Vec<(String, String)>,
    /// When this was issued, RFC 3339.
    pub issued_at: String,
    /// What it does not say.
    pub scope: String,
}

impl Statement {
    /// The layout that is written today.
    pub const FORMAT: u32 = 3;
}

/// A signed statement, as it is handed out. The signature is over the text of `statement`, byte for byte.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// A [`Statement`] in JSON.
    pub statement: String,
    /// Ed25519 public key, hexadecimal.
    pub public_key: String,
    /// Ed25519 signature, hexadecimal.
    pub signature: String,
}

impl Certificate {
    /// As JSON that may stand in a page: no name in it ends the element that it stands in.
    ///
    /// # Errors
    /// Never, but for JSON's own.
    pub fn in_page(&self) -> serde_json::Result<String> {
        Ok(serde_json::to_string(self)?.replace('<', "\\u003c"))
    }
}

/// Signs a statement.
///
/// # Errors
/// Never, but for JSON's own.
pub fn sign_statement(key: &SigningKey, statement: &Statement) -> anyhow::Result<Certificate> {
    Ok(sign_text(key, &serde_json::to_string(statement)?))
}

/// Signs a text of another kind with the same key. It must not be readable as a [`Statement`].
#[must_use]
pub fn sign_text(key: &SigningKey, text: &str) -> Certificate {
    let signature = HEXLOWER.encode(&key.sign(text.as_bytes()).to_bytes());
    Certificate { statement: text.to_owned(), public_key: public_key(key), signature }
}

/// The public key, hexadecimal: published, it lets anybody check a certificate.
#[must_use]
pub fn public_key(key: &SigningKey) -> String {
    HEXLOWER.encode(&key.verifying_key().to_bytes())
}

/// Checks a certificate, a page or JSON alone, against the public key that the school has published, and says what it states.
///
/// # Errors
/// When it is no certificate, of another key, or was changed.
pub fn check_certificate(file: &[u8], published_key: &str) -> anyhow::Result<Statement> {
    let certificate: Certificate = serde_json::from_str(json_of(file)?).context("not a certificate")?;
    let text = checked_text(&certificate, published_key)?;
    let statement: Statement = serde_json::from_str(text).context("a statement of another version")?;
    ensure!(KNOWN.contains(&statement.format), "format {}; allowed are 1 to {}", statement.format, Statement::FORMAT);
    Ok(statement)
}

/// The signed text, when the published key has signed it.
///
/// # Errors
/// When another key has, or it was changed.
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
    key.verify(certificate.statement.as_bytes(), &signature).ok().context("the signature is not of this statement")?;
    Ok(&certificate.statement)
}

/// The certificate in a page, or the file itself.
fn json_of(file: &[u8]) -> anyhow::Result<&str> {
    let text = std::str::from_utf8(file).context("not a certificate")?;
    let Some((_, inside)) = text.split_once(OPENING) else { return Ok(text) };
    let (json, after) = inside.split_once(CLOSING).context("not a certificate: the page is cut short")?;
    ensure!(!after.contains(OPENING), "not a certificate: the page holds more than one");
    Ok(json)
}

#[cfg(test)]
mod tests {
    //! Fails when a changed certificate, or one of another key, is taken for good, alone or in a page.

    use super::*;

    fn key_pair(seed: u8) -> SigningKey {
        SigningKey::from_bytes(&[seed; 32])
    }

    fn sample() -> Statement {
        let file = include_str!("../../../tests/data/certificate/statement.json");
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
