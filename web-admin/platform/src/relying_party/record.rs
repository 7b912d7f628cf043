//! Credential records (WebAuthn, section 4): the stored data of a passkey.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::authenticator_data::{AttestedCredential, AuthenticatorData};
use super::base64url;
use super::credential_key::CredentialKey;

/// The stored data of a passkey. Its JSON format is that of webauthn-rs 0.6, used by earlier
/// versions.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CredentialRecord {
    #[serde(rename = "cred_id", with = "base64url")]
    pub(super) id: Vec<u8>,
    #[serde(rename = "cred")]
    pub(super) key: CredentialKey,
    #[serde(rename = "counter")]
    pub(super) sign_count: u32,
    pub(super) transports: Option<Vec<String>>,
    pub(super) backup_eligible: bool,
    pub(super) backup_state: bool,
    /// Other members, stored unchanged: they document the registration, and no decision depends on
    /// them.
    #[serde(flatten)]
    pub(super) registration: Map<String, Value>,
}

/// The outermost object of the JSON.
#[derive(Serialize, Deserialize)]
struct StoredPasskey<R> {
    cred: R,
}

impl CredentialRecord {
    /// Creates the record of a new credential, whose user was verified and whose attestation is
    /// "none".
    pub(super) fn new(credential: AttestedCredential<'_>, data: &AuthenticatorData<'_>) -> Self {
        let registration = [
            ("user_verified", json!(true)),
            ("registration_policy", json!("required")),
            ("extensions", json!({})),
            ("attestation", json!({ "data": "None", "metadata": "None" })),
            ("attestation_format", json!("none")),
        ];
        Self {
            id: credential.id.to_vec(),
            key: credential.key,
            sign_count: data.sign_count,
            transports: None,
            backup_eligible: data.backup_eligible(),
            backup_state: data.backed_up(),
            registration: registration.map(|(name, value)| (name.to_owned(), value)).into_iter().collect(),
        }
    }

    /// Parses a record from the database.
    ///
    /// # Errors
    /// Fails if it is not JSON of this format.
    pub fn from_json(json: &str) -> serde_json::Result<Self> {
        serde_json::from_str::<StoredPasskey<Self>>(json).map(|stored| stored.cred)
    }

    /// Serializes the record for the database.
    ///
    /// # Errors
    /// Never fails in practice: every member can be represented in JSON.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string(&StoredPasskey { cred: self })
    }

    /// Id of the credential.
    #[must_use]
    pub fn id(&self) -> &[u8] {
        &self.id
    }

    /// Returns the number of signatures counted by the authenticator; 0 if it does not count.
    #[must_use]
    pub const fn sign_count(&self) -> u32 {
        self.sign_count
    }
}
