//! Files of recordings: read within what one may cost, and hashed.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use data_encoding::HEXLOWER;
use recording::{Budget, ReadError, Recording};
use sha2::{Digest, Sha256};

/// What a recording may cost when it is read: half an hour at 1 kHz. As many are read at once as `Service::parsing` lets through.
const BUDGET: Budget = Budget { kept_bytes: 384 << 20, unpacked_bytes: 1 << 30, messages: 3_000_000 };

/// Reads a stranger's recording, within what one may cost. Blocks.
///
/// # Errors
/// When it cannot be read.
pub fn read(path: &Path) -> Result<Recording, ReadError> {
    Recording::read_within(BufReader::new(File::open(path)?), BUDGET)
}

/// SHA-256 of a file, lower-case hexadecimal, and its size in bytes. Blocks.
///
/// # Errors
/// When it cannot be read.
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
