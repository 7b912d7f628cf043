//! Reads recording files within a resource budget.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use recording::{Budget, ReadError, Recording};

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
