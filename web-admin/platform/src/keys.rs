//! Ed25519 keys as text: 64 hexadecimal digits; signatures have 128.

use data_encoding::HEXLOWER_PERMISSIVE;
use ed25519_dalek::{Signature, Verifier, VerifyingKey};

/// Parses a public key; returns `None` if it is malformed or weak.
#[must_use]
pub fn public_key(text: &str) -> Option<VerifyingKey> {
    let bytes: [u8; 32] = HEXLOWER_PERMISSIVE.decode(text.as_bytes()).ok()?.try_into().ok()?;
    VerifyingKey::from_bytes(&bytes).ok().filter(|key| !key.is_weak())
}

/// Returns whether `signature` is a valid signature of `signed` by `key`.
#[must_use]
pub fn is_signed(key: &str, signed: &[u8], signature: &str) -> bool {
    let signature =
        HEXLOWER_PERMISSIVE.decode(signature.as_bytes()).ok().and_then(|bytes| Signature::from_slice(&bytes).ok());
    public_key(key).zip(signature).is_some_and(|(key, signature)| key.verify(signed, &signature).is_ok())
}
