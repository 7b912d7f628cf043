//! Verifies responses, rule by rule: WebAuthn, section 7.1 (registration) and section 7.2
//! (assertion).

use data_encoding::BASE64URL_NOPAD;
use model::ids::PersonId;
use serde::Deserialize;
use serde::de::{DeserializeOwned, IgnoredAny};

use super::authenticator_data::AuthenticatorData;
use super::cbor::{CborItem, CborReader};
use super::violation::Violation;
use super::{
    AnswerRefused, AssertionRequest, Challenge, CredentialRecord, RelyingParty, base64url, sha256, user_handle,
};

/// The person who is to sign, and their passkeys.
#[derive(Clone, Copy, Debug)]
pub struct PasskeyAccount<'a> {
    /// The person.
    pub person_id: PersonId,
    /// Current records of their passkeys.
    pub records: &'a [CredentialRecord],
}

/// The response of a browser (`PublicKeyCredential`).
#[derive(Deserialize)]
struct BrowserAnswer<R> {
    #[serde(rename = "type")]
    kind: String,
    #[serde(rename = "rawId", with = "base64url")]
    raw_id: Vec<u8>,
    response: R,
}

/// The authenticator's response to a registration.
#[derive(Deserialize)]
struct AttestationResponse {
    #[serde(rename = "clientDataJSON", with = "base64url")]
    client_data: Vec<u8>,
    #[serde(rename = "attestationObject", with = "base64url")]
    attestation_object: Vec<u8>,
}

/// The authenticator's response to a signature request.
#[derive(Deserialize)]
struct AssertionResponse {
    #[serde(rename = "clientDataJSON", with = "base64url")]
    client_data: Vec<u8>,
    #[serde(rename = "authenticatorData", with = "base64url")]
    authenticator_data: Vec<u8>,
    #[serde(with = "base64url")]
    signature: Vec<u8>,
    #[serde(rename = "userHandle")]
    user_handle: Option<String>,
}

/// Data about the request that the browser had the authenticator sign (`CollectedClientData`).
#[derive(Deserialize)]
struct ClientData {
    #[serde(rename = "type")]
    kind: String,
    challenge: String,
    origin: String,
    #[serde(rename = "crossOrigin")]
    cross_origin: Option<bool>,
    #[serde(rename = "topOrigin")]
    top_origin: Option<IgnoredAny>,
}

impl RelyingParty {
    /// Verifies the response to a registration, and returns the record of the new credential.
    ///
    /// # Errors
    /// Fails if the response violates a rule.
    pub fn verify_registration(&self, answer: &str, challenge: &Challenge) -> Result<CredentialRecord, AnswerRefused> {
        self.register(answer, challenge).map_err(refuse)
    }

    /// Verifies an assertion by one of a person's passkeys, and returns its updated record.
    ///
    /// # Errors
    /// Fails if the response violates a rule, or the signature counter has not increased.
    pub fn verify_assertion(
        &self,
        answer: &str,
        request: &AssertionRequest,
        account: PasskeyAccount<'_>,
    ) -> Result<CredentialRecord, AnswerRefused> {
        self.authenticate(answer, request, account).map_err(refuse)
    }

    pub(super) fn register(&self, answer: &str, challenge: &Challenge) -> Result<CredentialRecord, Violation> {
        let BrowserAnswer { response, .. } = read_answer::<AttestationResponse>(answer)?;
        self.check_client_data(&response.client_data, "webauthn.create", challenge)?;
        let mut data = AuthenticatorData::read(attested_data(&response.attestation_object)?)?;
        self.check_authenticator_data(&data)?;
        let credential = data.credential.take().ok_or(Violation::Ceremony)?;
        Ok(CredentialRecord::new(credential, &data))
    }

    pub(super) fn authenticate(
        &self,
        answer: &str,
        request: &AssertionRequest,
        account: PasskeyAccount<'_>,
    ) -> Result<CredentialRecord, Violation> {
        let BrowserAnswer { raw_id, response, .. } = read_answer::<AssertionResponse>(answer)?;
        ensure(request.allowed.contains(&BASE64URL_NOPAD.encode(&raw_id)), Violation::NotAllowed)?;
        let record = account.records.iter().find(|record| record.id == raw_id).ok_or(Violation::NotAllowed)?;
        // Some browsers send an empty handle instead of none.
        let handle = response.user_handle.as_deref().filter(|handle| !handle.is_empty());
        ensure(handle.is_none_or(|handle| handle == user_handle(account.person_id)), Violation::UserHandle)?;
        self.check_client_data(&response.client_data, "webauthn.get", &request.challenge)?;
        let data = AuthenticatorData::read(&response.authenticator_data)?;
        ensure(data.credential.is_none(), Violation::Ceremony)?;
        self.check_authenticator_data(&data)?;
        check_backup(record, &data)?;
        let signed = [response.authenticator_data.as_slice(), &sha256(&response.client_data)].concat();
        record.key.verify(&signed, &response.signature)?;
        let counts = data.sign_count > 0 || record.sign_count > 0;
        ensure(!counts || data.sign_count > record.sign_count, Violation::SignCount)?;
        Ok(CredentialRecord {
            sign_count: data.sign_count,
            backup_eligible: data.backup_eligible(),
            backup_state: data.backed_up(),
            ..record.clone()
        })
    }

    fn check_client_data(&self, json: &[u8], kind: &str, challenge: &Challenge) -> Result<(), Violation> {
        let data: ClientData = serde_json::from_slice(json).map_err(|_| Violation::ClientData)?;
        ensure(data.kind == kind, Violation::Type)?;
        ensure(challenge.is_equal_to(&data.challenge), Violation::Challenge)?;
        ensure(self.is_own(&data.origin), Violation::Origin)?;
        ensure(data.cross_origin != Some(true) && data.top_origin.is_none(), Violation::CrossOrigin)
    }

    fn check_authenticator_data(&self, data: &AuthenticatorData<'_>) -> Result<(), Violation> {
        ensure(*data.rp_id_hash == self.id_hash, Violation::RelyingParty)?;
        ensure(data.user_present(), Violation::NotPresent)?;
        ensure(data.user_verified(), Violation::NotVerified)?;
        ensure(data.backup_eligible() || !data.backed_up(), Violation::Backup)
    }
}

/// Checks the backup flags. A credential may become eligible for backup later, for example by an
/// update of its device, and may only be backed up after that. It stays eligible.
fn check_backup(record: &CredentialRecord, data: &AuthenticatorData<'_>) -> Result<(), Violation> {
    let kept = if record.backup_eligible { data.backup_eligible() } else { !data.backed_up() };
    ensure(kept, Violation::Backup)
}

/// Returns the authenticator data in an attestation object. The statement may be of any format,
/// since none was requested.
fn attested_data(object: &[u8]) -> Result<&[u8], Violation> {
    let mut reader = CborReader::new(object);
    let map = reader.map().filter(|_| reader.rest().is_empty()).ok_or(Violation::AttestationObject)?;
    let item = |name| map.get(&CborItem::Text(name));
    match (item("fmt"), item("attStmt"), item("authData")) {
        (Some(CborItem::Text(_)), Some(CborItem::Other), Some(CborItem::Bytes(data))) => Ok(*data),
        _ => Err(Violation::AttestationObject),
    }
}

fn read_answer<R: DeserializeOwned>(answer: &str) -> Result<BrowserAnswer<R>, Violation> {
    let answer: BrowserAnswer<R> = serde_json::from_str(answer).map_err(|_| Violation::Answer)?;
    ensure(answer.kind == "public-key", Violation::Answer)?;
    Ok(answer)
}

const fn ensure(holds: bool, otherwise: Violation) -> Result<(), Violation> {
    if holds { Ok(()) } else { Err(otherwise) }
}

fn refuse(violation: Violation) -> AnswerRefused {
    tracing::warn!(why = %violation, "passkey response rejected");
    if violation == Violation::SignCount { AnswerRefused::Copied } else { AnswerRefused::Wrong }
}
