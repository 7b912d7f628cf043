//! Where this program keeps things for its user (the XDG base directories, and their like on Windows).

use std::path::PathBuf;

use crate::exit::Failure;

/// Folder for settings and the station's token.
///
/// # Errors
/// When the environment names no home.
pub fn config() -> Result<PathBuf, Failure> {
    place(&["XDG_CONFIG_HOME", "APPDATA"], ".config")
}

/// Folder for attempts that wait.
///
/// # Errors
/// When the environment names no home.
pub fn data() -> Result<PathBuf, Failure> {
    place(&["XDG_DATA_HOME", "LOCALAPPDATA"], ".local/share")
}

/// The first of the variables that names an absolute folder, else a folder in the user's home; in it, ours.
fn place(variables: &[&str], below_home: &str) -> Result<PathBuf, Failure> {
    let named = |name: &&str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let base = variables.iter().find_map(named).or_else(|| named(&"HOME").map(|home| home.join(below_home)));
    base.map(|base| base.join("stylet")).ok_or_else(|| {
        Failure::input(format_args!("neither {} nor HOME names a folder: where may things be kept?", variables[0]))
    })
}
