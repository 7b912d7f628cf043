//! Checksums of uploaded chunks.

use data_encoding::BASE64;
use sha1::Sha1;
use sha2::{Digest, Sha256};

use crate::error::Error;

/// The expected checksum of a chunk.
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
    /// Supported algorithms, as listed in `Tus-Checksum-Algorithm`.
    pub const ALGORITHMS: &str = "sha256,sha1";

    /// Parses the header `Upload-Checksum`: an algorithm and a base64 hash.
    ///
    /// # Errors
    /// Fails if the algorithm is not supported, or the hash is malformed.
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

    /// Parses the header `Content-Digest` (RFC 9530), such as `sha-256=:…:`. Returns `None` if it
    /// contains no `sha-256`: the RFC lets recipients ignore other algorithms.
    ///
    /// # Errors
    /// Fails if the value of `sha-256` is malformed.
    pub fn of_content(header: &str) -> Result<Option<Self>, Error> {
        let members = header.split(',').filter_map(|member| member.trim().split_once('='));
        let Some((_, hash)) = members.into_iter().find(|(algorithm, _)| *algorithm == "sha-256") else {
            return Ok(None);
        };
        let hash = hash.strip_prefix(':').and_then(|rest| rest.strip_suffix(':'));
        let hash = hash.and_then(|hash| BASE64.decode(hash.as_bytes()).ok()).filter(|hash| hash.len() == 32);
        let refused =
            || Error::BadRequest(format!("Content-Digest: \"{header}\"; allowed: sha-256=:HASH:, the hash in base64"));
        Ok(Some(Self { digest: Digesting::Sha256(Sha256::new()), expected: hash.ok_or_else(refused)? }))
    }

    /// Hashes the next bytes of the chunk.
    pub fn update(&mut self, bytes: &[u8]) {
        match &mut self.digest {
            Digesting::Sha256(digest) => digest.update(bytes),
            Digesting::Sha1(digest) => digest.update(bytes),
        }
    }

    /// Returns whether the bytes so far match the expected checksum.
    #[must_use]
    pub fn fits(&self) -> bool {
        match &self.digest {
            Digesting::Sha256(digest) => digest.clone().finalize().as_slice() == self.expected,
            Digesting::Sha1(digest) => digest.clone().finalize().as_slice() == self.expected,
        }
    }
}

fn refused(header: &str) -> Error {
    let allowed = "allowed: sha256 or sha1, followed by a space and the hash in base64";
    Error::BadRequest(format!("Upload-Checksum: \"{header}\"; {allowed}"))
}
