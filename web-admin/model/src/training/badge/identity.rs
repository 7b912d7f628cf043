//! The identity of an issuer: its `did:web` and its key as Multikey.

use anyhow::{Context, ensure};
use ed25519_dalek::{SigningKey, VerifyingKey};
use serde_json::{Value, json};
use url::Url;

/// Digits of base58btc.
const DIGITS: &[u8; 58] = b"123456789ABCDEFGHJKLMNPQRSTUVWXYZabcdefghijkmnopqrstuvwxyz";
/// Prefix of base58btc in Multibase.
const BASE58BTC: char = 'z';
/// Prefix of an Ed25519 public key in Multicodec.
const ED25519_PUBLIC: [u8; 2] = [0xed, 0x01];

/// A service that issues badges: its address, and its identity that follows from the address.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IssuerAddress {
    /// Address without a slash at its end.
    pub url: String,
    /// Its `did:web`.
    pub did: String,
}

impl IssuerAddress {
    /// Returns the issuer at an address.
    ///
    /// # Errors
    /// If it is not an address with a host, or has a path: then its document is not at
    /// `/.well-known/did.json`.
    pub fn of(address: &str) -> anyhow::Result<Self> {
        let url = Url::parse(address).context("not an address")?;
        let host = url.host_str().context("an address without a host")?;
        ensure!(url.path() == "/" && url.query().is_none(), "{address}: an issuer of badges has no path");
        // A colon separates the parts of a did, so that of a port or an IPv6 address is escaped.
        let host = host.replace(':', "%3A").replace('[', "%5B").replace(']', "%5D");
        let port = url.port().map(|port| format!("%3A{port}")).unwrap_or_default();
        Ok(Self { url: url.as_str().trim_end_matches('/').to_owned(), did: format!("did:web:{host}{port}") })
    }

    /// Returns the id of a key of this issuer.
    #[must_use]
    pub fn key_id(&self, key: &VerifyingKey) -> String {
        format!("{}#{}", self.did, multikey(key))
    }

    /// Returns the address of a status list.
    #[must_use]
    pub fn status_list(&self, list: u64) -> String {
        format!("{}/badges/status/{list}", self.url)
    }

    /// Returns the document at `/.well-known/did.json`, with the key that signs.
    #[must_use]
    pub fn did_document(&self, key: &SigningKey) -> Value {
        let key = key.verifying_key();
        let id = self.key_id(&key);
        json!({
            "@context": ["https://www.w3.org/ns/did/v1", "https://w3id.org/security/multikey/v1"],
            "id": self.did,
            "verificationMethod": [{
                "id": id,
                "type": "Multikey",
                "controller": self.did,
                "publicKeyMultibase": multikey(&key),
            }],
            "assertionMethod": [id],
        })
    }
}

/// Returns a public key as Multikey.
#[must_use]
pub fn multikey(key: &VerifyingKey) -> String {
    multibase(&[&ED25519_PUBLIC[..], key.as_bytes()].concat())
}

/// Returns the value of a digit of base58btc.
pub(super) fn digit_value(digit: u8) -> Option<u32> {
    (0..).zip(DIGITS).find(|(_, known)| **known == digit).map(|(value, _)| value)
}

/// Returns bytes as Multibase in base58btc.
pub(super) fn multibase(bytes: &[u8]) -> String {
    let zeros = bytes.iter().take_while(|&&byte| byte == 0).count();
    // Digits of the number, the least significant one first.
    let mut digits: Vec<u8> = Vec::with_capacity(bytes.len() * 2);
    for &byte in bytes {
        let mut carry = u32::from(byte);
        for digit in &mut digits {
            carry += u32::from(*digit) << 8;
            // Below 58.
            *digit = (carry % 58) as u8;
            carry /= 58;
        }
        while carry > 0 {
            digits.push((carry % 58) as u8);
            carry /= 58;
        }
    }
    let zeros = std::iter::repeat_n(0, zeros);
    let digits = zeros.chain(digits.into_iter().rev()).map(|digit| char::from(DIGITS[usize::from(digit)]));
    std::iter::once(BASE58BTC).chain(digits).collect()
}

#[cfg(test)]
mod tests {
    //! Programs of others find the key of a badge by its issuer, so both must follow the
    //! recommendations.

    use super::*;

    #[test]
    fn bytes_are_written_in_base58btc() {
        // Examples of the draft "The Base58 Encoding Scheme".
        assert_eq!(multibase(b"Hello World!"), "z2NEpo7TZRRrLZSi2U");
        assert_eq!(multibase(&[0x00, 0x00, 0x28, 0x7f, 0xb4, 0xcd]), "z11233QC4");
        assert_eq!(multibase(&[]), "z");
        let key = SigningKey::from_bytes(&[7; 32]).verifying_key();
        assert_eq!(multikey(&key), "z6MkvDqGT54cXesYGvABpF1UapVNwjCqRcafi4Px6Thv5T3Z");
    }

    #[test]
    fn an_issuer_is_named_by_its_host() {
        for (address, did) in [
            ("https://stylet.example", "did:web:stylet.example"),
            ("https://stylet.example/", "did:web:stylet.example"),
            ("https://Stylet.Example:8443", "did:web:stylet.example%3A8443"),
            ("http://127.0.0.1:4000", "did:web:127.0.0.1%3A4000"),
            ("https://größe.example", "did:web:xn--gre-6ka8i.example"),
            ("http://[::1]:80", "did:web:%5B%3A%3A1%5D"),
        ] {
            let issuer = IssuerAddress::of(address).expect(address);
            assert_eq!(issuer.did, did);
            assert!(!issuer.url.ends_with('/') && issuer.url.is_ascii(), "{}", issuer.url);
        }
        for address in ["", "stylet.example", "https://stylet.example/below", "https://stylet.example?x", "urn:x"] {
            assert!(IssuerAddress::of(address).is_err(), "{address}");
        }
    }
}
