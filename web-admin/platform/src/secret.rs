//! Secrets: random tokens, password hashing, masking, and constant-time comparison.

use std::sync::{Mutex, PoisonError};

use argon2::password_hash::phc::{Output, ParamsString, PasswordHash, Salt};
use argon2::password_hash::try_generate_salt;
use argon2::{Algorithm, Argon2, Block, Params, Version};
use data_encoding::HEXLOWER;
use model::search_key::compose_text;
use sha2::{Digest, Sha256};

/// Returns 32 random bytes from the operating system, in hexadecimal.
///
/// # Errors
/// Fails if the operating system's random source fails.
pub fn random_hex() -> anyhow::Result<String> {
    Ok(HEXLOWER.encode(&random_16()?) + &HEXLOWER.encode(&random_16()?))
}

/// Returns random bytes from the operating system.
///
/// # Errors
/// Fails if the operating system's random source fails.
pub fn random_bytes<const N: usize>() -> anyhow::Result<[u8; N]> {
    let mut bytes = [0; N];
    for part in bytes.chunks_mut(16) {
        part.copy_from_slice(&random_16()?[..part.len()]);
    }
    Ok(bytes)
}

/// Returns 16 bytes from argon2's salt generator, which takes them from the operating system and is
/// fit for any secret.
fn random_16() -> anyhow::Result<[u8; 16]> {
    try_generate_salt().map_err(|e| anyhow::anyhow!("the operating system's random source failed: {e}"))
}

/// Returns a password that is easy to dictate and type: 16 characters of an alphabet of 32, that is
/// 80 bits.
///
/// # Errors
/// Fails if the operating system's random source fails.
pub fn random_password() -> anyhow::Result<String> {
    // Without 0, 1, l and o, which are easily confused.
    const LETTERS: &[u8; 32] = b"23456789abcdefghijkmnpqrstuvwxyz";
    Ok(random_16()?.iter().map(|byte| char::from(LETTERS[usize::from(byte % 32)])).collect())
}

/// Returns a code that is easy to read and type: at most 16 letters of an alphabet of 32, that is 5
/// bits each.
///
/// # Errors
/// Fails if the operating system's random source fails.
pub fn random_code(letters: usize) -> anyhow::Result<String> {
    // Without 0, 1, I and O, which are easily confused.
    const LETTERS: &[u8; 32] = b"23456789ABCDEFGHJKLMNPQRSTUVWXYZ";
    Ok(random_16()?.iter().take(letters).map(|byte| char::from(LETTERS[usize::from(byte % 32)])).collect())
}

/// Normalizes a typed code for hashing and comparison: removes separators and converts to upper
/// case.
#[must_use]
pub fn plain_code(typed: &str) -> String {
    typed.chars().filter(char::is_ascii_alphanumeric).map(|letter| letter.to_ascii_uppercase()).collect()
}

/// Returns a slow, deterministic hash of a short code within a realm, suitable for lookups. Takes
/// tens of milliseconds: call it where blocking is allowed.
///
/// # Errors
/// Fails if the cost is outside argon2's range.
pub fn code_hash(code: &str, realm: &[u8; 16], cost: PasswordCost) -> anyhow::Result<[u8; 32]> {
    let mut hash = [0; 32];
    hash_into(&argon2(cost)?, code.as_bytes(), realm, &mut hash).map_err(|e| anyhow::anyhow!("argon2: {e}"))?;
    Ok(hash)
}

/// Pool of memory for hashing. Freed memory would stay with the allocator, once for every thread
/// that has ever hashed.
static MEMORY: Mutex<Vec<Vec<Block>>> = Mutex::new(Vec::new());

fn hash_into(argon2: &Argon2<'_>, secret: &[u8], salt: &[u8], hash: &mut [u8]) -> argon2::Result<()> {
    let memory = || MEMORY.lock().unwrap_or_else(PoisonError::into_inner);
    let mut blocks = memory().pop().unwrap_or_default();
    blocks.resize(argon2.params().block_count().max(blocks.len()), Block::default());
    let done = argon2.hash_password_into_with_memory(secret, salt, hash, &mut blocks);
    memory().push(blocks);
    done
}

fn argon2(cost: PasswordCost) -> anyhow::Result<Argon2<'static>> {
    let params = Params::new(cost.memory_kib, cost.passes, 1, None).map_err(|e| anyhow::anyhow!("argon2: {e}"))?;
    Ok(Argon2::new(Algorithm::Argon2id, Version::V0x13, params))
}

/// Returns the hash under which a token is stored.
#[must_use]
pub fn token_sha256(token: &str) -> [u8; 32] {
    Sha256::digest(token.as_bytes()).into()
}

/// Compares two secrets by their hashes, so that the time does not reveal where they differ.
#[must_use]
pub fn same(a: &str, b: &str) -> bool {
    let (a, b) = (token_sha256(a), token_sha256(b));
    a.iter().zip(&b).fold(0, |differences, (x, y)| differences | (x ^ y)) == 0
}

/// Masks a hexadecimal secret for a page: random bytes, then the secret XORed with them. Otherwise
/// the length of a compressed page would reveal the secret to an attacker who chooses part of the
/// page (BREACH).
///
/// # Errors
/// Fails if it is not hexadecimal, or the operating system's random source fails.
pub fn mask(secret: &str) -> anyhow::Result<String> {
    let secret = HEXLOWER.decode(secret.as_bytes())?;
    let mut shown = Vec::with_capacity(2 * secret.len());
    while shown.len() < secret.len() {
        shown.extend(random_16()?);
    }
    shown.truncate(secret.len());
    for (at, byte) in secret.iter().enumerate() {
        shown.push(byte ^ shown[at]);
    }
    Ok(HEXLOWER.encode(&shown))
}

/// Returns the secret of a masked text; `None` if the text is not masked.
#[must_use]
pub fn unmask(shown: &str) -> Option<String> {
    let bytes = HEXLOWER.decode(shown.as_bytes()).ok()?;
    let (mask, masked) = bytes.split_at(bytes.len() / 2);
    let secret: Vec<u8> = mask.iter().zip(masked).map(|(a, b)| a ^ b).collect();
    (mask.len() == masked.len()).then(|| HEXLOWER.encode(&secret))
}

/// Hashes a password with a fresh salt, in PHC format. Takes tens of milliseconds: call it where
/// blocking is allowed.
///
/// # Errors
/// Fails if the cost is outside argon2's range.
pub fn hash_password(password: &str, cost: PasswordCost) -> anyhow::Result<String> {
    let (argon2, salt) = (argon2(cost)?, random_16()?);
    let mut hash = [0; Params::DEFAULT_OUTPUT_LEN];
    hash_into(&argon2, compose_text(password).as_bytes(), &salt, &mut hash)
        .map_err(|e| anyhow::anyhow!("argon2: {e}"))?;
    let told = |e: argon2::password_hash::phc::Error| anyhow::anyhow!("argon2: {e}");
    let phc = PasswordHash {
        algorithm: Algorithm::Argon2id.ident(),
        version: Some(Version::V0x13.into()),
        params: ParamsString::try_from(argon2.params()).map_err(|e| anyhow::anyhow!("argon2: {e}"))?,
        salt: Some(Salt::new(&salt).map_err(told)?),
        hash: Some(Output::new(&hash).map_err(told)?),
    };
    Ok(phc.to_string())
}

/// Returns whether a password matches a hash, regardless of its Unicode normalization. An
/// unreadable hash matches no password.
#[must_use]
pub fn password_fits(password: &str, hash: &str) -> bool {
    let Ok(parsed) = PasswordHash::new(hash) else { return false };
    let fits = |password: &str| hash_of(password, &parsed).is_some_and(|found| parsed.hash == Some(found));
    let composed = compose_text(password);
    // An earlier version hashed passwords without normalizing them.
    fits(&composed) || composed != password && fits(password)
}

/// Hashes a password with the salt and cost of another hash. `Output` compares in constant time.
fn hash_of(password: &str, like: &PasswordHash) -> Option<Output> {
    let version = like.version.map(Version::try_from).transpose().ok()?.unwrap_or_default();
    let algorithm = Algorithm::try_from(like.algorithm.as_str()).ok()?;
    let argon2 = Argon2::new(algorithm, version, Params::try_from(like).ok()?);
    let (salt, mut hash) = (like.salt?, [0; Output::MAX_LENGTH]);
    let hash = hash.get_mut(..like.hash?.len())?;
    hash_into(&argon2, password.as_bytes(), &salt, hash).ok()?;
    Output::new(hash).ok()
}

/// Cost parameters of password hashing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PasswordCost {
    /// Memory, in KiB.
    pub memory_kib: u32,
    /// Number of passes over the memory.
    pub passes: u32,
}

impl PasswordCost {
    /// OWASP's recommendation for argon2id and the default of the argon2 crate: 19 MiB, two passes.
    pub const RECOMMENDED: Self = Self { memory_kib: 19 * 1024, passes: 2 };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_masked_secret_looks_different_each_time_and_is_the_same() {
        let secret = random_hex().unwrap();
        let (one, other) = (mask(&secret).unwrap(), mask(&secret).unwrap());
        assert!(one != other && !one.contains(&secret[..16]), "{one} {other}");
        assert_eq!((unmask(&one), unmask(&other)), (Some(secret.clone()), Some(secret.clone())));
        assert_ne!(unmask(&secret), Some(secret), "what is not masked is no token");
        assert_eq!((unmask("abc"), unmask("zz"), unmask("ab")), (None, None, None));
        assert!(mask("no hexadecimal").is_err());
    }

    #[test]
    fn only_the_right_password_fits() {
        let hash = hash_password("correct horse", PasswordCost { memory_kib: 8, passes: 1 }).unwrap();
        assert!(hash.starts_with("$argon2id$"), "{hash}");
        assert!(password_fits("correct horse", &hash));
        assert!(!password_fits("correct horsf", &hash));
        assert!(!password_fits("correct horse", "not a hash"));
        // Made by the reference implementation of argon2 at another cost.
        let theirs = "$argon2id$v=19$m=256,t=2,p=1$c29tZXNhbHQ$nf65EOgLrQMR/uIPnA4rEsF5h7TKyQwu9U1bMCHGi/4";
        assert!(password_fits("password", theirs) && !password_fits("Password", theirs));
    }

    #[test]
    fn password_hashing_keeps_memory_only_for_concurrent_hashes() {
        let cost = PasswordCost { memory_kib: 64, passes: 1 };
        for _ in 0..20 {
            std::thread::spawn(move || hash_password("correct horse", cost).unwrap()).join().unwrap();
        }
        // Other tests hash concurrently.
        let kept = MEMORY.lock().unwrap().len();
        assert!((1..10).contains(&kept), "{kept} times the memory of a hash");
    }

    #[test]
    fn the_same_is_the_same_and_nothing_else_is() {
        assert!(same("abc", "abc"));
        assert!(!same("abc", "abd") && !same("abc", "ab") && !same("", "a"));
    }

    #[test]
    fn a_code_is_the_same_however_it_is_typed_and_hashes_by_realm() {
        let cost = PasswordCost { memory_kib: 8, passes: 1 };
        let hash = |code: &str, realm| code_hash(&plain_code(code), &[realm; 16], cost).unwrap();
        assert_eq!(hash("abc-def", 1), hash(" ABC DEF ", 1));
        assert_ne!(hash("ABCDEF", 1), hash("ABCDEF", 2));
        assert_ne!(hash("ABCDEF", 1), hash("ABCDEG", 1));
    }

    #[test]
    fn secrets_do_not_repeat() {
        assert_ne!(random_hex().unwrap(), random_hex().unwrap());
        assert_eq!(random_password().unwrap().len(), 16);
    }
}
