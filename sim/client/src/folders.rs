//! Folders for the user's data (the XDG base directories, or their counterparts on Windows).

use std::path::PathBuf;

use crate::exit::Failure;

/// Returns the folder for settings.
///
/// # Errors
/// If the environment names no home directory.
pub fn config() -> Result<PathBuf, Failure> {
    place(&["XDG_CONFIG_HOME", "APPDATA"], ".config")
}

/// Returns the folder for the station's token. Windows copies the folder for settings to other
/// computers of the user, where the token is not valid.
///
/// # Errors
/// If the environment names no home directory.
pub fn secrets() -> Result<PathBuf, Failure> {
    if cfg!(windows) { data() } else { config() }
}

/// Returns the folder for the outbox and the station's key.
///
/// # Errors
/// If the environment names no home directory.
pub fn data() -> Result<PathBuf, Failure> {
    place(&["XDG_DATA_HOME", "LOCALAPPDATA"], ".local/share")
}

/// Returns our folder in the first absolute folder named by a variable, otherwise in a folder in
/// the user's home directory.
fn place(variables: &[&str], below_home: &str) -> Result<PathBuf, Failure> {
    let named = |name: &&str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let base = variables.iter().find_map(named).or_else(|| named(&"HOME").map(|home| home.join(below_home)));
    base.map(|base| base.join("stylet")).ok_or_else(|| {
        Failure::input(format_args!("neither {} nor HOME is set: no folder to store data in", variables[0]))
    })
}
