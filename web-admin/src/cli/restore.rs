//! `web-admin restore`: a backup into an empty place, all of it or nothing.

use std::path::PathBuf;

use clap::Args;

use super::{Failure, Storage, say};
use crate::backup::{self, Refused};
use crate::clock::Clock;
use crate::locks::DataLock;

/// What to restore where.
#[derive(Debug, Args)]
pub struct RestoreArgs {
    /// A file that `web-admin backup` made
    #[arg(value_name = "FILE")]
    from: PathBuf,
    #[command(flatten)]
    storage: Storage,
}

pub(super) async fn run(args: &RestoreArgs) -> Result<(), Failure> {
    let config = args.storage.config()?;
    let _lock = DataLock::take(&config, "web-admin restore", Clock::system().now())?;
    let restored = backup::restore(&config, &args.from).await.map_err(|refused| match refused {
        Refused::Input(words) => Failure::Usage(words),
        Refused::Work(error) => Failure::Work(error),
    })?;
    say(format_args!(
        "restored {} recordings and the database with {} audit rows; the audit log ends in {}",
        restored.recordings, restored.audit_rows, restored.audit_head
    ));
    Ok(())
}
