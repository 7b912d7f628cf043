//! Authenticator data (WebAuthn, section 6.1): the bytes that an authenticator signs.

use super::cbor::CborReader;
use super::credential_key::CredentialKey;
use super::violation::Violation;

/// Maximum length of a credential id, in bytes.
const LONGEST_ID: usize = 1023;

const USER_PRESENT: u8 = 1;
const USER_VERIFIED: u8 = 1 << 2;
const BACKUP_ELIGIBLE: u8 = 1 << 3;
const BACKED_UP: u8 = 1 << 4;
const HAS_CREDENTIAL: u8 = 1 << 6;
const HAS_EXTENSIONS: u8 = 1 << 7;

/// Parsed authenticator data; trailing bytes are an error.
#[derive(Debug)]
pub(super) struct AuthenticatorData<'a> {
    /// SHA-256 of the id of the relying party.
    pub rp_id_hash: &'a [u8; 32],
    flags: u8,
    /// Number of signatures counted by the authenticator; 0 if it does not count.
    pub sign_count: u32,
    /// The new credential, in a registration.
    pub credential: Option<AttestedCredential<'a>>,
}

/// Attested credential data (WebAuthn, section 6.5.1).
#[derive(Debug)]
pub(super) struct AttestedCredential<'a> {
    /// Id of the credential.
    pub id: &'a [u8],
    /// Its public key.
    pub key: CredentialKey,
}

impl<'a> AuthenticatorData<'a> {
    /// Parses the data.
    pub(super) fn read(bytes: &'a [u8]) -> Result<Self, Violation> {
        let (rp_id_hash, rest) = bytes.split_first_chunk().ok_or(Violation::AuthenticatorData)?;
        let ([flags, count @ ..], mut rest) = rest.split_first_chunk::<5>().ok_or(Violation::AuthenticatorData)?;
        let mut credential = None;
        if flags & HAS_CREDENTIAL != 0 {
            let (read, after) = AttestedCredential::read(rest)?;
            (credential, rest) = (Some(read), after);
        }
        if flags & HAS_EXTENSIONS != 0 {
            let mut extensions = CborReader::new(rest);
            extensions.map().ok_or(Violation::AuthenticatorData)?;
            rest = extensions.rest();
        }
        if !rest.is_empty() {
            return Err(Violation::AuthenticatorData);
        }
        Ok(Self { rp_id_hash, flags: *flags, sign_count: u32::from_be_bytes(*count), credential })
    }

    const fn has(&self, flag: u8) -> bool {
        self.flags & flag != 0
    }

    /// Returns whether the user was present, for example touched the authenticator.
    pub(super) const fn user_present(&self) -> bool {
        self.has(USER_PRESENT)
    }

    /// Returns whether the authenticator has verified its user.
    pub(super) const fn user_verified(&self) -> bool {
        self.has(USER_VERIFIED)
    }

    /// Returns whether the credential may be copied to other devices.
    pub(super) const fn backup_eligible(&self) -> bool {
        self.has(BACKUP_ELIGIBLE)
    }

    /// Returns whether the credential is currently backed up.
    pub(super) const fn backed_up(&self) -> bool {
        self.has(BACKED_UP)
    }
}

impl<'a> AttestedCredential<'a> {
    /// Parses the data and returns it with the remaining bytes. The model of the authenticator
    /// (AAGUID) is not used.
    fn read(bytes: &'a [u8]) -> Result<(Self, &'a [u8]), Violation> {
        let (_aaguid, rest) = bytes.split_first_chunk::<16>().ok_or(Violation::AuthenticatorData)?;
        let (length, rest) = rest.split_first_chunk().ok_or(Violation::AuthenticatorData)?;
        let (id, rest) =
            rest.split_at_checked(u16::from_be_bytes(*length).into()).ok_or(Violation::AuthenticatorData)?;
        if id.is_empty() || id.len() > LONGEST_ID {
            return Err(Violation::CredentialId);
        }
        let mut reader = CborReader::new(rest);
        let key = CredentialKey::read(&reader.map().ok_or(Violation::AuthenticatorData)?)?;
        Ok((Self { id, key }, reader.rest()))
    }
}
