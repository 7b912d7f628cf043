//! Reads recording files within a resource budget, and hashes files.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use data_encoding::HEXLOWER;
use recording::{Budget, ReadError, Recording};
use sha2::{Digest, Sha256};

/// Resource budget for reading a recording: enough for half an hour at 1 kHz. `Service::parsing`
/// limits how many are read concurrently.
const BUDGET: Budget = Budget { kept_bytes: 384 << 20, unpacked_bytes: 1 << 30, messages: 3_000_000 };

/// Reads an untrusted recording within the budget. Blocks.
///
/// # Errors
/// Fails if it cannot be read.
pub fn read(path: &Path) -> Result<Recording, ReadError> {
    Recording::read_within(BufReader::new(File::open(path)?), BUDGET)
}

/// Returns the SHA-256 of a file, lower-case hexadecimal, and its size in bytes. Blocks.
///
/// # Errors
/// Fails if it cannot be read.
pub fn hash_file(path: &Path) -> std::io::Result<(String, u64)> {
    let (mut file, mut hash, mut size) = (File::open(path)?, Sha256::new(), 0);
    let mut piece = vec![0; 1 << 16];
    loop {
        match file.read(&mut piece)? {
            0 => return Ok((HEXLOWER.encode(&hash.finalize()), size)),
            read => {
                hash.update(&piece[..read]);
                size += read as u64;
            }
        }
    }
}
