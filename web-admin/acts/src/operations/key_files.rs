//! Key files of a service: in the data folder or in a folder shared by replicas, never in the
//! database.

use std::path::Path;

use platform::sealing;

use crate::training::certificates;

/// A key file. A backup contains it only sealed with a passphrase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeyFile {
    /// File name in the key folder.
    pub name: &'static str,
    /// File name in a backup.
    pub(crate) sealed: &'static str,
    /// Purpose, as text.
    pub does: &'static str,
}

/// All keys.
pub const KEYS: [KeyFile; 2] = [
    KeyFile { name: certificates::KEY_FILE, sealed: "certificate-key.sealed", does: "signs certificates" },
    KeyFile {
        name: sealing::KEY_FILE,
        sealed: "second-factor-key.sealed",
        does: "opens the secrets of second factors",
    },
];

/// Generates the keys that are missing in a folder.
///
/// # Errors
/// Fails if one cannot be created, or an existing file is not a key.
pub fn make_missing_keys(keys_dir: &Path) -> anyhow::Result<()> {
    KEYS.iter().try_for_each(|key| sealing::file_key(&keys_dir.join(key.name)).map(drop))
}
