//! Encryption at rest: seals secrets (ChaCha20-Poly1305) with a key in a file outside the database,
//! so that a copy of the database alone reveals none.

use std::fs::{DirBuilder, OpenOptions};
use std::io::Write;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use chacha20poly1305::aead::{Aead, Payload};
use chacha20poly1305::{ChaCha20Poly1305, KeyInit, Nonce};
use data_encoding::HEXLOWER_PERMISSIVE;

use crate::secret;

/// File name of the key in the key folder; 64 hexadecimal digits.
pub const KEY_FILE: &str = "second-factor-key";
/// Length of a nonce, in bytes.
const NONCE: usize = 12;

/// Seals a secret. The owner's id is authenticated, so that it opens for the same owner only.
///
/// # Errors
/// Fails if the key cannot be read or created.
pub fn seal(keys_dir: &Path, owner: &[u8; 16], plain: &[u8]) -> anyhow::Result<Vec<u8>> {
    let nonce = secret::random_bytes::<NONCE>()?;
    let sealed = cipher(keys_dir)?.encrypt(&Nonce::from(nonce), Payload { msg: plain, aad: owner });
    let sealed = sealed.ok().context("a secret could not be sealed")?;
    Ok([nonce.as_slice(), &sealed].concat())
}

/// Opens a sealed secret of an owner.
///
/// # Errors
/// Fails if the key is wrong or cannot be read, or the sealed secret was changed or belongs to
/// another owner.
pub fn open(keys_dir: &Path, owner: &[u8; 16], sealed: &[u8]) -> anyhow::Result<Vec<u8>> {
    let (nonce, sealed) = sealed.split_first_chunk::<NONCE>().context("too short for a sealed secret")?;
    let opened = cipher(keys_dir)?.decrypt(&Nonce::from(*nonce), Payload { msg: sealed, aad: owner });
    opened.ok().with_context(|| format!("a sealed secret does not open: {KEY_FILE} is not the key that sealed it"))
}

fn cipher(keys_dir: &Path) -> anyhow::Result<ChaCha20Poly1305> {
    Ok(ChaCha20Poly1305::new(&file_key(&keys_dir.join(KEY_FILE))?.into()))
}

/// Returns the key in a file, creating it on first use.
///
/// # Errors
/// Fails if it cannot be read or created, or is malformed.
pub fn file_key(path: &Path) -> anyhow::Result<[u8; 32]> {
    if !path.exists() {
        make_key(path).with_context(|| {
            let folder = path.parent().unwrap_or(path).display();
            format!(
                "cannot create {}; with write access, `web-admin keys --keys DIR` creates the keys missing in {folder}",
                path.display()
            )
        })?;
    }
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let key: Option<[u8; 32]> =
        HEXLOWER_PERMISSIVE.decode(text.trim().as_bytes()).ok().and_then(|bytes| bytes.try_into().ok());
    key.with_context(|| format!("{}: allowed: 64 hexadecimal digits", path.display()))
}

/// Restores a key file from a backup: 64 hexadecimal digits. An existing key is never overwritten.
///
/// # Errors
/// Fails if it is not a key, another key exists, or the disk fails.
pub fn restore_file_key(path: &Path, digits: &str) -> anyhow::Result<()> {
    let key = digits.trim();
    ensure!(key.len() == 64 && HEXLOWER_PERMISSIVE.decode(key.as_bytes()).is_ok(), "allowed: 64 hexadecimal digits");
    if !path.exists() {
        put_key(path, key).with_context(|| format!("cannot create {}", path.display()))?;
    }
    let found = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    ensure!(found.trim() == key, "{}: already contains another key; move it away first", path.display());
    Ok(())
}

fn make_key(path: &Path) -> anyhow::Result<()> {
    put_key(path, &secret::random_hex()?)
}

/// Writes a key under a temporary name first, so that concurrent requests create a single key and a
/// crash leaves no partial one.
fn put_key(path: &Path, key: &str) -> anyhow::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    DirBuilder::new().recursive(true).mode(0o700).create(folder)?;
    let part = PathBuf::from(format!("{}.{}", path.display(), uuid::Uuid::new_v4()));
    let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&part)?;
    file.write_all(key.as_bytes())?;
    file.sync_all()?;
    // Linking fails if the name exists: then a concurrent request has created the key.
    let linked = std::fs::hard_link(&part, path);
    std::fs::remove_file(&part)?;
    match linked {
        Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => Err(error.into()),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    //! A copy of the database, another person's row or a changed byte must not reveal a secret.

    use super::*;

    #[test]
    fn only_the_same_key_and_owner_open_what_was_sealed() {
        let (folder, other) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
        let sealed = seal(folder.path(), &[1; 16], b"secret").expect("sealed");
        assert_eq!(open(folder.path(), &[1; 16], &sealed).expect("opened"), b"secret");
        assert!(!sealed.windows(6).any(|part| part == b"secret"));
        assert_ne!(seal(folder.path(), &[1; 16], b"secret").expect("sealed"), sealed, "sealed twice it looks another");
        assert!(open(folder.path(), &[2; 16], &sealed).is_err(), "somebody else's row");
        assert!(open(other.path(), &[1; 16], &sealed).is_err(), "another folder's key");
        for at in 0..sealed.len() {
            let mut changed = sealed.clone();
            changed[at] ^= 1;
            assert!(open(folder.path(), &[1; 16], &changed).is_err(), "byte {at} was changed");
        }
        assert!(open(folder.path(), &[1; 16], &sealed[..8]).is_err());
    }
}
