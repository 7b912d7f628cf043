//! `web-admin backup`: writes everything to one file while the service runs.

use std::path::{Path, PathBuf};

use acts::operations::backup;
use acts::operations::key_files::{KEYS, KeyFile};
use clap::Args;
use platform::clock::Clock;

use super::{CommandFailure, StorageArgs, say_line};

/// Options of `web-admin backup`.
#[derive(Debug, Args)]
pub struct BackupArgs {
    /// File to create; an existing file is never overwritten
    #[arg(long, value_name = "FILE")]
    to: PathBuf,
    /// File with a passphrase on one line, at least 12 characters: the keys of certificates and
    /// second factors are included in the backup, encrypted with it
    #[arg(long, value_name = "FILE")]
    passphrase_file: Option<PathBuf>,
    #[command(flatten)]
    storage: StorageArgs,
}

pub(super) async fn run_backup(args: &BackupArgs) -> Result<(), CommandFailure> {
    if args.to.exists() {
        return Err(CommandFailure::Usage(format!(
            "--to: \"{}\" already exists; a backup is never overwritten: choose another file",
            args.to.display()
        )));
    }
    let config = args.storage.config()?;
    let passphrase = args.passphrase_file.as_deref().map(read_passphrase).transpose()?;
    let made = backup::make(&config, &args.to, passphrase.as_deref(), Clock::system().now()).await?;
    say_line(format_args!(
        "{}: {} recordings and the database with {} audit rows, verified; the audit log ends in {}",
        args.to.display(),
        made.recordings,
        made.audit_rows,
        made.audit_head
    ));
    for KeyFile { name, does, .. } in KEYS {
        let key = config.keys_dir.join(name);
        match (key.exists(), passphrase.is_some()) {
            (true, true) => say_line(format_args!(
                "sealed in the backup: {}, which {does}; without the passphrase it is lost",
                key.display()
            )),
            (true, false) => say_line(format_args!(
                "not in the backup: {}, which {does}; include it with --passphrase-file, or keep a separate copy that only you can read",
                key.display()
            )),
            (false, _) => {}
        }
    }
    Ok(())
}

/// Reads the passphrase from a file and checks it.
pub(super) fn read_passphrase(file: &Path) -> Result<String, CommandFailure> {
    let refused =
        |why: &dyn std::fmt::Display| CommandFailure::Usage(format!("--passphrase-file: {}: {why}", file.display()));
    let text = std::fs::read_to_string(file).map_err(|error| refused(&error))?;
    backup::passphrase::check(&text).map_err(|error| refused(&error))
}
