//! What the commands of `xtask` and the system tests share: the root of the tree, and its packages with their licences.

pub mod licences;
pub mod notices;

use std::path::{Path, PathBuf};

/// The root of the project.
#[must_use]
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map_or_else(PathBuf::new, Path::to_path_buf)
}

/// The dependency graph of the default features and of `features`, separated by commas, on this platform.
///
/// # Errors
/// When `cargo metadata` refuses the workspace.
pub fn read_metadata(features: &str) -> Result<cargo_metadata::Metadata, cargo_metadata::Error> {
    read_metadata_for(&format!("{}-unknown-linux-gnu", std::env::consts::ARCH), features)
}

/// The same on another platform, by its target triple.
///
/// # Errors
/// When `cargo metadata` refuses the workspace.
pub fn read_metadata_for(target: &str, features: &str) -> Result<cargo_metadata::Metadata, cargo_metadata::Error> {
    let (platform, features) = (format!("--filter-platform={target}"), format!("--features={features}"));
    cargo_metadata::MetadataCommand::new()
        .manifest_path(root().join("Cargo.toml"))
        .other_options(["--locked".to_owned(), platform, features])
        .exec()
}
