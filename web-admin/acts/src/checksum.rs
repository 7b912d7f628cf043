//! The checksum that a piece may carry, and whether it fits.

use data_encoding::BASE64;
use sha1::Sha1;
use sha2::{Digest, Sha256};

use crate::error::Error;

/// What a piece must hash to.
#[derive(Clone, Debug)]
pub struct Checksum {
    digest: Digesting,
    expected: Vec<u8>,
}

#[derive(Clone, Debug)]
enum Digesting {
    Sha256(Sha256),
    Sha1(Sha1),
}

impl Checksum {
    /// The algorithms there are, as `Tus-Checksum-Algorithm` lists them.
    pub const ALGORITHMS: &str = "sha256,sha1";

    /// From the header `Upload-Checksum`: an algorithm, and a hash in base64.
    ///
    /// # Errors
    /// When the algorithm is another, or the hash is none of its.
    pub fn parse(header: &str) -> Result<Self, Error> {
        let (algorithm, hash) = header.split_once(' ').unwrap_or((header, ""));
        let (digest, length) = match algorithm {
            "sha256" => (Digesting::Sha256(Sha256::new()), 32),
            "sha1" => (Digesting::Sha1(Sha1::new()), 20),
            _ => return Err(refused(header)),
        };
        let expected = BASE64.decode(hash.as_bytes()).ok().filter(|hash| hash.len() == length);
        Ok(Self { digest, expected: expected.ok_or_else(|| refused(header))? })
    }

    /// From the header `Content-Digest` (RFC 9530): hashes by algorithm, as `sha-256=:…:`. None where it names no algorithm of ours:
    /// others may be passed over.
    ///
    /// # Errors
    /// When what stands at `sha-256` is no such hash.
    pub fn of_content(header: &str) -> Result<Option<Self>, Error> {
        let members = header.split(',').filter_map(|member| member.trim().split_once('='));
        let Some((_, hash)) = members.into_iter().find(|(algorithm, _)| *algorithm == "sha-256") else {
            return Ok(None);
        };
        let hash = hash.strip_prefix(':').and_then(|rest| rest.strip_suffix(':'));
        let hash = hash.and_then(|hash| BASE64.decode(hash.as_bytes()).ok()).filter(|hash| hash.len() == 32);
        let refused = || {
            Error::BadRequest(format!("Content-Digest: \"{header}\"; allowed is sha-256=:HASH:, the hash in base64"))
        };
        Ok(Some(Self { digest: Digesting::Sha256(Sha256::new()), expected: hash.ok_or_else(refused)? }))
    }

    /// Takes in the next bytes of the piece.
    pub fn update(&mut self, bytes: &[u8]) {
        match &mut self.digest {
            Digesting::Sha256(digest) => digest.update(bytes),
            Digesting::Sha1(digest) => digest.update(bytes),
        }
    }

    /// Whether the bytes so far are the ones that were meant.
    #[must_use]
    pub fn fits(&self) -> bool {
        match &self.digest {
            Digesting::Sha256(digest) => digest.clone().finalize().as_slice() == self.expected,
            Digesting::Sha1(digest) => digest.clone().finalize().as_slice() == self.expected,
        }
    }
}

fn refused(header: &str) -> Error {
    let allowed = "allowed are sha256 and sha1, each followed by a space and its hash in base64";
    Error::BadRequest(format!("Upload-Checksum: \"{header}\"; {allowed}"))
}
