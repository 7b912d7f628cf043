//! `web-admin restore`: restores a backup into an empty place, all or nothing.

use std::path::{Path, PathBuf};

use acts::operations::backup;
use acts::operations::backup::{KeysRestored, RestoreRefused, RestoreRequest, RestoreSummary};
use acts::privacy::erasures::{Erasure, ErasureList};
use clap::Args;
use platform::clock::Clock;
use platform::locks::DataLock;

use super::{CommandFailure, StorageArgs, say_line};

/// Options of `web-admin restore`.
#[derive(Debug, Args)]
pub struct RestoreArgs {
    /// A file written by `web-admin backup`
    #[arg(value_name = "FILE")]
    from: PathBuf,
    /// A list of erasures kept elsewhere, such as erasures.jsonl of the old data folder: people
    /// erased since the backup was made are erased again. The list in the backup and the one in the
    /// data folder are always applied
    #[arg(long, value_name = "FILE")]
    erasures: Option<PathBuf>,
    /// File with the passphrase of `backup --passphrase-file`: the keys in the backup are restored,
    /// too
    #[arg(long, value_name = "FILE")]
    passphrase_file: Option<PathBuf>,
    #[command(flatten)]
    storage: StorageArgs,
}

pub(super) async fn run_restore(args: &RestoreArgs) -> Result<(), CommandFailure> {
    let config = args.storage.config()?;
    let _lock = DataLock::take(&config, "web-admin restore", Clock::system().now()).await?;
    let erasures = args.erasures.as_deref().map(erasures_in).transpose()?.unwrap_or_default();
    let passphrase = args.passphrase_file.as_deref().map(super::backup::read_passphrase).transpose()?;
    let wanted = RestoreRequest { erasures, passphrase };
    let restored = backup::restore(&config, &args.from, &wanted).await.map_err(|refused| match refused {
        RestoreRefused::Input(words) => CommandFailure::Usage(words),
        RestoreRefused::Work(error) => CommandFailure::Work(error),
    })?;
    let RestoreSummary { report: restored, erased_again, keys } = restored;
    if erased_again > 0 {
        say_line(format_args!("people erased again, because they were erased after the backup: {erased_again}"));
    }
    say_line(format_args!(
        "restored {} recordings and the database with {} audit rows; the audit log ends in {}",
        restored.recordings, restored.audit_rows, restored.audit_head
    ));
    match keys {
        KeysRestored::Restored => say_line("keys restored"),
        KeysRestored::StaySealed => {
            say_line("the backup contains keys that were not restored: use --passphrase-file");
        }
        KeysRestored::NotInIt => {}
    }
    Ok(())
}

fn erasures_in(file: &Path) -> Result<Vec<Erasure>, CommandFailure> {
    if !file.is_file() {
        return Err(CommandFailure::Usage(format!("--erasures: \"{}\" is not a file", file.display())));
    }
    ErasureList::at(file).read().map_err(|unreadable| CommandFailure::Usage(format!("--erasures: {unreadable}")))
}
