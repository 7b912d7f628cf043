//! The key that signs certificates, stored in the key folder and generated on first use.

use std::path::Path;

use ed25519_dalek::SigningKey;
use model::CurrentPerson;
use model::ids::PersonId;
use model::training::certificate;
use platform::sealing;
use serde_json::json;
use store::audit::AuditEntry;
use store::training::curricula::TaughtCurriculum;

use crate::error::Error;
use crate::service::Service;

/// File name of the private key in the key folder; 64 hexadecimal digits.
pub const KEY_FILE: &str = "certificate-key";

/// Returns the service's signing key, generating it if it does not exist.
///
/// # Errors
/// Fails if it cannot be read or created.
pub fn signing_key(keys_dir: &Path) -> anyhow::Result<SigningKey> {
    Ok(SigningKey::from_bytes(&sealing::file_key(&keys_dir.join(KEY_FILE))?))
}

/// Returns the public key of this service, hexadecimal.
///
/// # Errors
/// Fails if the key cannot be read or created.
pub fn public_key(keys_dir: &Path) -> anyhow::Result<String> {
    Ok(certificate::public_key(&signing_key(keys_dir)?))
}

/// Records in the audit log that a certificate was issued to a trainee.
pub async fn note_issued(
    state: &Service,
    by: &CurrentPerson,
    trainee: PersonId,
    course: &TaughtCurriculum,
) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    AuditEntry::by(by, "certificate.issued", trainee)
        .with(json!({ "curriculum_id": course.curriculum_id, "sha256": course.sha256 }))
        .append(&mut tx, state.clock.now())
        .await?;
    Ok(tx.commit().await?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_key_is_made_once_and_for_its_owner_alone() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(public_key(folder.path()).expect("made"), public_key(folder.path()).expect("kept"));
        let mode = std::fs::metadata(folder.path().join(KEY_FILE)).expect("a file").permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
    }
}
