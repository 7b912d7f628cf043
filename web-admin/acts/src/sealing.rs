//! Secrets at rest: sealed (ChaCha20-Poly1305) with a key in a file beside the database, so that a copy of the database alone
//! opens none.

use std::fs::{DirBuilder, OpenOptions};
use std::io::Write;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use chacha20poly1305::aead::{Aead, Payload};
use chacha20poly1305::{ChaCha20Poly1305, KeyInit, Nonce};
use data_encoding::HEXLOWER_PERMISSIVE;

use crate::secret;

/// The key's file in the folder of the keys, 64 hexadecimal digits.
pub const KEY_FILE: &str = "second-factor-key";
/// Bytes of a nonce.
const NONCE: usize = 12;

/// Seals a secret; it opens for the same owner alone.
///
/// # Errors
/// When the key cannot be read or made.
pub fn seal(keys_dir: &Path, owner: &[u8; 16], plain: &[u8]) -> anyhow::Result<Vec<u8>> {
    let nonce = secret::random_bytes::<NONCE>()?;
    let sealed = cipher(keys_dir)?.encrypt(&Nonce::from(nonce), Payload { msg: plain, aad: owner });
    let sealed = sealed.ok().context("a secret could not be sealed")?;
    Ok([nonce.as_slice(), &sealed].concat())
}

/// Opens what was sealed for an owner.
///
/// # Errors
/// When the key is another or cannot be read, or what was sealed was changed or is somebody else's.
pub fn open(keys_dir: &Path, owner: &[u8; 16], sealed: &[u8]) -> anyhow::Result<Vec<u8>> {
    let (nonce, sealed) = sealed.split_first_chunk::<NONCE>().context("too short for a sealed secret")?;
    let opened = cipher(keys_dir)?.decrypt(&Nonce::from(*nonce), Payload { msg: sealed, aad: owner });
    opened.ok().with_context(|| format!("a sealed secret does not open: {KEY_FILE} is not the key that sealed it"))
}

fn cipher(keys_dir: &Path) -> anyhow::Result<ChaCha20Poly1305> {
    Ok(ChaCha20Poly1305::new(&file_key(&keys_dir.join(KEY_FILE))?.into()))
}

/// The key in a file, made when it is first needed.
///
/// # Errors
/// When it cannot be read or made, or is none.
pub fn file_key(path: &Path) -> anyhow::Result<[u8; 32]> {
    if !path.exists() {
        make_key(path).with_context(|| {
            let folder = path.parent().unwrap_or(path).display();
            format!(
                "cannot make {}; where one may write, `web-admin keys --keys DIR` makes what {folder} lacks",
                path.display()
            )
        })?;
    }
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let key: Option<[u8; 32]> =
        HEXLOWER_PERMISSIVE.decode(text.trim().as_bytes()).ok().and_then(|bytes| bytes.try_into().ok());
    key.with_context(|| format!("{}: allowed are 64 hexadecimal digits", path.display()))
}

/// Takes a file's key from a backup: 64 hexadecimal digits. One that is there already is never overwritten.
///
/// # Errors
/// When it is no key, another one is there, or the disk refuses.
pub fn restore_file_key(path: &Path, digits: &str) -> anyhow::Result<()> {
    let key = digits.trim();
    ensure!(key.len() == 64 && HEXLOWER_PERMISSIVE.decode(key.as_bytes()).is_ok(), "allowed are 64 hexadecimal digits");
    if !path.exists() {
        put_key(path, key).with_context(|| format!("cannot make {}", path.display()))?;
    }
    let found = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    ensure!(found.trim() == key, "{}: another key is there; move it away first", path.display());
    Ok(())
}

fn make_key(path: &Path) -> anyhow::Result<()> {
    put_key(path, &secret::random_hex()?)
}

/// Written whole under another name first: two requests at once make one key, and a crash none.
fn put_key(path: &Path, key: &str) -> anyhow::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    DirBuilder::new().recursive(true).mode(0o700).create(folder)?;
    let part = PathBuf::from(format!("{}.{}", path.display(), uuid::Uuid::new_v4()));
    let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&part)?;
    file.write_all(key.as_bytes())?;
    file.sync_all()?;
    // A link fails where the name is taken: whoever was first has made the key.
    let linked = std::fs::hard_link(&part, path);
    std::fs::remove_file(&part)?;
    match linked {
        Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => Err(error.into()),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    //! Fails when a copy of the database, another person's row or a changed byte gives a secret away.

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
