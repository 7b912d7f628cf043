//! Seals a secret with a passphrase: XChaCha20-Poly1305 with a key derived by argon2id from the
//! passphrase and a salt.

use anyhow::Context;
use chacha20poly1305::aead::{Aead, KeyInit};
use chacha20poly1305::{XChaCha20Poly1305, XNonce};
use data_encoding::{HEXLOWER, HEXLOWER_PERMISSIVE};
use platform::secret;
use platform::secret::PasswordCost;
use serde::{Deserialize, Serialize};

/// Minimum length of a passphrase, in characters.
pub const MIN_PASSPHRASE: usize = 12;
/// Cost of trying one passphrase: 64 MiB, three passes. High, because backups are stored for years.
const COST: PasswordCost = PasswordCost { memory_kib: 64 * 1024, passes: 3 };
/// Maximum cost that a sealed file may demand: the file sets the cost of opening it, so a crafted
/// one could exhaust memory.
const MOST: PasswordCost = PasswordCost { memory_kib: 1024 * 1024, passes: 16 };
/// Version of the layout.
const FORMAT: u32 = 1;

/// A sealed secret as stored.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sealed {
    format: u32,
    memory_kib: u32,
    passes: u32,
    /// 16 bytes, hexadecimal.
    salt: String,
    /// 24 bytes, hexadecimal.
    nonce: String,
    /// Hexadecimal.
    sealed: String,
}

/// Seals a secret. Takes about 0.1 s and 64 MiB.
///
/// # Errors
/// Fails if the operating system's random source fails.
pub fn seal(what: &[u8], passphrase: &str) -> anyhow::Result<Vec<u8>> {
    let random = HEXLOWER_PERMISSIVE.decode((secret::random_hex()? + &secret::random_hex()?).as_bytes())?;
    let (salt, nonce): ([u8; 16], [u8; 24]) = (random[..16].try_into()?, random[16..40].try_into()?);
    let sealed = cipher(passphrase, &salt, COST)?
        .encrypt(&XNonce::from(nonce), what)
        .map_err(|_| anyhow::anyhow!("the secret cannot be sealed"))?;
    Ok(serde_json::to_vec_pretty(&Sealed {
        format: FORMAT,
        memory_kib: COST.memory_kib,
        passes: COST.passes,
        salt: HEXLOWER.encode(&salt),
        nonce: HEXLOWER.encode(&nonce),
        sealed: HEXLOWER.encode(&sealed),
    })?)
}

/// Opens a sealed secret.
///
/// # Errors
/// Fails if the passphrase is wrong, the file was changed, or it is not a sealed secret.
pub fn open(file: &[u8], passphrase: &str) -> anyhow::Result<Vec<u8>> {
    let sealed: Sealed = serde_json::from_slice(file).context("not a sealed secret")?;
    let Sealed { format, memory_kib, passes, salt, nonce, sealed } = sealed;
    anyhow::ensure!(format == FORMAT, "sealed in format {format}; allowed: {FORMAT}");
    let most = memory_kib <= MOST.memory_kib && passes <= MOST.passes;
    anyhow::ensure!(
        most,
        "requires {memory_kib} KiB and {passes} passes; allowed: {} and {}",
        MOST.memory_kib,
        MOST.passes
    );
    let salt: [u8; 16] = HEXLOWER_PERMISSIVE.decode(salt.as_bytes())?.try_into().ok().context("a salt has 16 bytes")?;
    let nonce: [u8; 24] =
        HEXLOWER_PERMISSIVE.decode(nonce.as_bytes())?.try_into().ok().context("a nonce has 24 bytes")?;
    cipher(passphrase, &salt, PasswordCost { memory_kib, passes })?
        .decrypt(&XNonce::from(nonce), HEXLOWER_PERMISSIVE.decode(sealed.as_bytes())?.as_slice())
        .map_err(|_| anyhow::anyhow!("wrong passphrase, or the file was changed"))
}

fn cipher(passphrase: &str, salt: &[u8; 16], cost: PasswordCost) -> anyhow::Result<XChaCha20Poly1305> {
    let key = secret::code_hash(passphrase, salt, cost)?;
    XChaCha20Poly1305::new_from_slice(&key).context("a key has 32 bytes")
}

/// Reads a passphrase from the text of a file, without its line ending.
///
/// # Errors
/// Fails if the passphrase is too short, or there is more than one line.
pub fn check(text: &str) -> anyhow::Result<String> {
    let line = text.trim_end_matches(['\r', '\n']);
    anyhow::ensure!(!line.contains('\n'), "contains more than one line; a passphrase is one line");
    let characters = line.chars().count();
    anyhow::ensure!(
        characters >= MIN_PASSPHRASE,
        "the passphrase has {characters} characters; at least {MIN_PASSPHRASE} are needed"
    );
    Ok(line.to_owned())
}

#[cfg(test)]
mod tests {
    //! A backup alone must not reveal the keys in it.

    use super::*;

    #[test]
    fn only_its_passphrase_opens_it_and_no_byte_may_change() {
        let sealed = seal(b"a secret", "seven green horses").unwrap();
        assert!(!sealed.windows(8).any(|part| part == b"a secret"));
        assert_eq!(open(&sealed, "seven green horses").unwrap(), b"a secret");
        let other = open(&sealed, "seven green horse").unwrap_err().to_string();
        assert!(other.contains("wrong passphrase"), "{other}");
        assert_ne!(sealed, seal(b"a secret", "seven green horses").unwrap(), "twice is two salts");
        let text = String::from_utf8(sealed).unwrap();
        let mut changed: serde_json::Value = serde_json::from_str(&text).unwrap();
        changed["sealed"] = changed["sealed"].as_str().unwrap().replace(['0', '1'], "2").into();
        assert!(open(changed.to_string().as_bytes(), "seven green horses").is_err());
        changed["memory_kib"] = u32::MAX.into();
        assert!(open(changed.to_string().as_bytes(), "x").unwrap_err().to_string().contains("allowed"));
    }

    #[test]
    fn a_passphrase_is_a_long_line() {
        assert_eq!(check("seven green horses\r\n").unwrap(), "seven green horses");
        for (text, why) in [("short\n", "5 characters"), ("", "0 characters"), ("two lines of\nwords", "more than one")]
        {
            assert!(check(text).unwrap_err().to_string().contains(why), "{text}");
        }
    }
}
