//! This machine as a training station: the school it has joined, its token, and its signing key.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use data_encoding::{HEXLOWER, HEXLOWER_PERMISSIVE};
use ed25519_dalek::{Signer, SigningKey};
use recording::{AttemptHashes, Session, Signature, signature};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use tempfile::Builder;
use uuid::Uuid;

use crate::exit::{Failure, Outcome};
use crate::{folders, new_file};

/// The school that this station has joined.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pairing {
    /// Address of the service, without a trailing slash.
    pub server: String,
    /// The school's name.
    pub school: String,
    /// Name of the station at the school.
    pub name: String,
    /// The bearer token. Never printed.
    pub token: String,
}

/// Returns the path of the pairing's file.
///
/// # Errors
/// If the environment names no home directory.
pub fn file() -> Result<PathBuf, Failure> {
    Ok(folders::secrets()?.join("station.json"))
}

impl Pairing {
    /// Loads the pairing of this machine, if it has one.
    ///
    /// # Errors
    /// If the file exists and cannot be read.
    pub fn load() -> Result<Option<Self>, Failure> {
        let file = file()?;
        let refused = |why: String| Failure::refused(&file, format_args!("{why}; pair this station again"));
        match fs::read(&file) {
            Ok(bytes) => serde_json::from_slice(&bytes).map(Some).map_err(|error| refused(error.to_string())),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(refused(error.to_string())),
        }
    }

    /// Saves the pairing, readable by this user only, and replaces an earlier one.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self) -> Outcome {
        write(&file()?, self)
    }
}

/// Writes a file for this user only, and replaces an earlier one.
fn write(file: &Path, content: &impl Serialize) -> Outcome {
    let written = || -> std::io::Result<()> {
        let folder = file.parent().unwrap_or(Path::new("."));
        fs::create_dir_all(folder)?;
        // A temporary file is created with permissions for its owner only, and keeps them when it
        // is renamed. On Windows it has those of the folder, the user's local data: for the user,
        // administrators and the system.
        let mut new = Builder::new().prefix(".station-").tempfile_in(folder)?;
        new.write_all(serde_json::to_string_pretty(content)?.as_bytes())?;
        new_file::persist(new, file)?;
        new_file::sync_folder(folder)
    };
    written().map_err(|error| Failure::work(format_args!("{}: {error}", file.display())))
}

/// The key that signs this station's recordings: created when the station joins a school, and never
/// sent anywhere.
#[derive(Serialize, Deserialize)]
pub struct StationKey {
    /// The station's id at its school.
    pub station: Uuid,
    /// Ed25519 private key, 64 hexadecimal digits.
    key: String,
}

impl StationKey {
    /// Returns the path of the key's file.
    ///
    /// # Errors
    /// If the environment names no home directory.
    pub fn file() -> Result<PathBuf, Failure> {
        Ok(folders::data()?.join("station-key.json"))
    }

    /// Loads the key of this machine, if it has one.
    ///
    /// # Errors
    /// If the file exists and cannot be read, or holds no valid key.
    pub fn load() -> Result<Option<Self>, Failure> {
        let file = Self::file()?;
        let refused = |why: String| Failure::refused(&file, format_args!("{why}; pair this station again"));
        match fs::read(&file) {
            Ok(bytes) => match serde_json::from_slice::<Self>(&bytes) {
                Ok(key) if seed(&key.key).is_some() => Ok(Some(key)),
                Ok(_) => Err(refused("key: allowed: 64 hexadecimal digits".to_owned())),
                Err(error) => Err(refused(error.to_string())),
            },
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(refused(error.to_string())),
        }
    }

    /// Saves the key, readable by this user only, and replaces an earlier one.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self) -> Outcome {
        write(&Self::file()?, self)
    }

    /// Signs the hashes of an attempt in a session; `None` if the key is invalid.
    pub fn sign(&self, session: &Session, hashes: &AttemptHashes) -> Option<Signature> {
        let key = SigningKey::from_bytes(&seed(&self.key)?);
        let signed = key.sign(&signature::signed_statement(session, self.station, hashes));
        Some(Signature { station: self.station, ed25519: HEXLOWER.encode(&signed.to_bytes()) })
    }
}

/// A private key without a station.
pub struct NewKey([u8; 32]);

impl NewKey {
    /// Creates a key from three random UUIDs of the operating system, 366 random bits.
    pub fn random() -> Self {
        let mut hash = Sha256::new();
        (0..3).for_each(|_| hash.update(Uuid::new_v4().as_bytes()));
        Self(hash.finalize().into())
    }

    /// Returns the public key, 64 hexadecimal digits.
    pub fn public(&self) -> String {
        HEXLOWER.encode(SigningKey::from_bytes(&self.0).verifying_key().as_bytes())
    }

    /// Assigns the key to a station.
    pub fn for_station(self, station: Uuid) -> StationKey {
        StationKey { station, key: HEXLOWER.encode(&self.0) }
    }
}

fn seed(hex: &str) -> Option<[u8; 32]> {
    HEXLOWER_PERMISSIVE.decode(hex.as_bytes()).ok()?.try_into().ok()
}
