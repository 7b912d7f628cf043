//! Reasons for rejecting a response, for the log: one variant per rule.

/// A rule of WebAuthn, section 7.1 or 7.2, that a response violates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Violation {
    /// The response is not the JSON of a public-key credential.
    #[error("the answer is not the JSON of a public-key credential")]
    Answer,
    /// The client data is not JSON, or lacks a member.
    #[error("the client data cannot be read")]
    ClientData,
    /// The client data belongs to another ceremony.
    #[error("the client data has another type")]
    Type,
    /// The client data contains another challenge.
    #[error("the client data contains another challenge")]
    Challenge,
    /// The client data comes from a page of another origin.
    #[error("the client data has another origin")]
    Origin,
    /// The page was embedded in another origin's page.
    #[error("the client data is from a page embedded in another origin")]
    CrossOrigin,
    /// The attestation object is not CBOR, or lacks a member.
    #[error("the attestation object cannot be read")]
    AttestationObject,
    /// The authenticator data is too short, too long, or contains invalid CBOR.
    #[error("the authenticator data cannot be read")]
    AuthenticatorData,
    /// The authenticator data is for another relying party.
    #[error("the authenticator data is for another relying party")]
    RelyingParty,
    /// The user was not present.
    #[error("the user was not present")]
    NotPresent,
    /// The user was not verified.
    #[error("the user was not verified")]
    NotVerified,
    /// The backup flags contradict each other or the credential record.
    #[error("the backup flags contradict each other or the credential record")]
    Backup,
    /// A registration without a credential, or an assertion with one.
    #[error("the authenticator data belongs to another challenge")]
    Ceremony,
    /// The credential's id is empty or too long.
    #[error("the credential's id is empty or too long")]
    CredentialId,
    /// The key is for an algorithm that was not offered.
    #[error("the key is for an algorithm that was not offered")]
    Algorithm,
    /// The key has the wrong type or length, or is not a point on its curve.
    #[error("the public key is not valid for its algorithm")]
    PublicKey,
    /// The credential was not requested, or has been removed since.
    #[error("the credential was not requested, or is no longer registered")]
    NotAllowed,
    /// The user handle belongs to another person.
    #[error("the user handle belongs to another person")]
    UserHandle,
    /// The signature was not made by the credential's key.
    #[error("the signature is not valid")]
    Signature,
    /// The signature counter has not increased.
    #[error("the signature counter has not increased")]
    SignCount,
}
