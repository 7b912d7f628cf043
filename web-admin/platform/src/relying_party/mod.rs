//! The relying party of WebAuthn Level 3 (<https://www.w3.org/TR/webauthn-3/>): requests passkeys
//! from browsers and verifies the responses. Attestation is not requested ("none"), so attestation
//! statements are neither trusted nor verified.

use data_encoding::BASE64URL_NOPAD;
use model::ids::PersonId;
use ring::digest::{SHA256, digest};
use serde::{Deserialize, Serialize};
use serde_json::json;
use url::Url;

use crate::config::Config;
use crate::secret;

mod authenticator_data;
mod base64url;
mod cbor;
mod credential_key;
mod record;
#[cfg(test)]
mod tests;
mod verification;
mod violation;

pub use record::CredentialRecord;
pub use verification::PasskeyAccount;

/// Name shown by browsers.
const NAME: &str = "Stylet";
/// How long a browser waits for an authenticator, in ms.
const TIMEOUT_MS: u32 = 300_000;

/// The relying party of this service. Passkeys are bound to its host name and usable only from its
/// pages.
#[derive(Clone, Debug)]
pub struct RelyingParty {
    id: String,
    id_hash: [u8; 32],
    origin: String,
    any_local_port: bool,
}

/// Why a response was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnswerRefused {
    /// It does not match the request: its origin, challenge, key or format is wrong.
    Wrong,
    /// The signature counter has not increased: the passkey may have been cloned.
    Copied,
}

/// The user for whom a passkey is registered.
#[derive(Clone, Copy, Debug)]
pub struct PasskeyOwner<'a> {
    /// Id, stored by the authenticator as the user handle.
    pub id: PersonId,
    /// Address, by which users distinguish their accounts.
    pub email: &'a str,
    /// Name.
    pub name: &'a str,
}

/// 32 random bytes that the response must repeat, in base64url.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Challenge(String);

/// A signature request. The response must contain the challenge, signed by one of the credentials.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AssertionRequest {
    challenge: Challenge,
    /// Ids of the allowed credentials, in base64url.
    allowed: Vec<String>,
}

impl Challenge {
    /// Creates a random challenge.
    ///
    /// # Errors
    /// Fails if the operating system's random source fails.
    pub fn random() -> anyhow::Result<Self> {
        Ok(Self(BASE64URL_NOPAD.encode(&secret::random_bytes::<32>()?)))
    }

    /// Compares a text with this challenge in constant time.
    fn is_equal_to(&self, other: &str) -> bool {
        let differences =
            self.0.bytes().zip(other.bytes()).fold(0, |differences, (own, byte)| differences | (own ^ byte));
        self.0.len() == other.len() && differences == 0
    }
}

impl RelyingParty {
    /// Returns the relying party of a service. Returns `None` if its host has no name, or if the
    /// connection is not a secure context: browsers have no passkeys for such a host.
    #[must_use]
    pub fn of(config: &Config) -> Option<Self> {
        let on_trial = config.public_url.is_none() && config.listen.ip().is_loopback();
        let address = if on_trial { format!("http://localhost:{}", config.listen.port()) } else { config.address() };
        let url = Url::parse(&address).ok()?;
        let id = url.domain()?.to_owned();
        if url.scheme() != "https" && id != "localhost" {
            return None;
        }
        // On trial the system may have chosen the port, so any port of localhost is accepted.
        Some(Self {
            id_hash: sha256(id.as_bytes()),
            id,
            origin: url.origin().ascii_serialization(),
            any_local_port: on_trial,
        })
    }

    /// Returns the origin of the pages that may use passkeys, as a browser writes it.
    #[must_use]
    pub fn origin(&self) -> &str {
        &self.origin
    }

    /// Returns whether a page of `origin` may use this party's passkeys.
    fn is_own(&self, origin: &str) -> bool {
        origin == self.origin || self.any_local_port && is_localhost(origin)
    }

    /// Returns the options for `navigator.credentials.create`, in JSON. An authenticator that
    /// already holds one of the known credentials creates no other.
    #[must_use]
    pub fn creation_options(
        &self,
        owner: PasskeyOwner<'_>,
        challenge: &Challenge,
        known: &[CredentialRecord],
    ) -> String {
        let algorithms = credential_key::OFFERED.map(|number| json!({ "type": "public-key", "alg": number }));
        let known =
            known.iter().map(|record| json!({ "type": "public-key", "id": BASE64URL_NOPAD.encode(&record.id) }));
        json!({ "publicKey": {
            "rp": { "id": self.id, "name": NAME },
            "user": { "id": user_handle(owner.id), "name": owner.email, "displayName": owner.name },
            "challenge": challenge,
            "pubKeyCredParams": algorithms,
            "timeout": TIMEOUT_MS,
            "excludeCredentials": known.collect::<Vec<_>>(),
            "authenticatorSelection": {
                "residentKey": "discouraged", "requireResidentKey": false, "userVerification": "required",
            },
            "attestation": "none",
            // Enforcing the policy would exclude authenticators that do not support it.
            "extensions": {
                "credentialProtectionPolicy": "userVerificationRequired",
                "enforceCredentialProtectionPolicy": false,
                "credProps": true,
                "uvm": true,
            },
        } })
        .to_string()
    }

    /// Creates a request for a signature by one of the known credentials. Returns it with the
    /// options for `navigator.credentials.get`, in JSON.
    #[must_use]
    pub fn request_options(&self, challenge: Challenge, known: &[CredentialRecord]) -> (AssertionRequest, String) {
        let allowed: Vec<_> = known.iter().map(|record| BASE64URL_NOPAD.encode(&record.id)).collect();
        let descriptors = known.iter().zip(&allowed).map(|(record, id)| match &record.transports {
            Some(transports) => json!({ "type": "public-key", "id": id, "transports": transports }),
            None => json!({ "type": "public-key", "id": id }),
        });
        let options = json!({ "publicKey": {
            "challenge": challenge,
            "timeout": TIMEOUT_MS,
            "rpId": self.id,
            "allowCredentials": descriptors.collect::<Vec<_>>(),
            "userVerification": "required",
        } });
        (AssertionRequest { challenge, allowed }, options.to_string())
    }
}

fn is_localhost(origin: &str) -> bool {
    Url::parse(origin).is_ok_and(|url| {
        url.scheme() == "http" && url.domain() == Some("localhost") && url.origin().ascii_serialization() == origin
    })
}

/// Returns the user handle stored by the authenticator: the person's id, in base64url.
fn user_handle(person: PersonId) -> String {
    BASE64URL_NOPAD.encode(person.uuid().as_bytes())
}

fn sha256(bytes: &[u8]) -> [u8; 32] {
    let mut hash = [0; 32];
    hash.copy_from_slice(digest(&SHA256, bytes).as_ref());
    hash
}
