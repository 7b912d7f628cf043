//! The keys of a service: files of their own, in the data folder or in another that several services share, and in no database.

use std::path::Path;

use crate::{certificates, sealing};

/// A key in a file, which is in a backup only sealed with a passphrase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeyFile {
    /// Its name in the folder of the keys.
    pub name: &'static str,
    /// Its name in a backup.
    pub(crate) sealed: &'static str,
    /// What it does, in words.
    pub does: &'static str,
}

/// Every such key.
pub const KEYS: [KeyFile; 2] = [
    KeyFile { name: certificates::KEY_FILE, sealed: "certificate-key.sealed", does: "signs certificates" },
    KeyFile {
        name: sealing::KEY_FILE,
        sealed: "second-factor-key.sealed",
        does: "opens the secrets of second factors",
    },
];

/// Makes every key of a folder that is not there yet.
///
/// # Errors
/// When one cannot be made, or what is there is no key.
pub fn make_missing_keys(keys_dir: &Path) -> anyhow::Result<()> {
    KEYS.iter().try_for_each(|key| sealing::file_key(&keys_dir.join(key.name)).map(drop))
}
