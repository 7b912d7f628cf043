//! `web-admin backup`: everything into one file, while the service runs.

use std::path::PathBuf;

use clap::Args;

use super::{Failure, Storage, say};
use crate::backup;
use crate::certificates;
use crate::clock::Clock;
use crate::sealing;

/// What to back up where to.
#[derive(Debug, Args)]
pub struct BackupArgs {
    /// File to make; one that exists is never overwritten
    #[arg(long, value_name = "FILE")]
    to: PathBuf,
    #[command(flatten)]
    storage: Storage,
}

pub(super) async fn run(args: &BackupArgs) -> Result<(), Failure> {
    if args.to.exists() {
        return Err(Failure::Usage(format!(
            "--to: \"{}\" exists; a backup is never overwritten: name another file",
            args.to.display()
        )));
    }
    let config = args.storage.config()?;
    let made = backup::make(&config, &args.to, Clock::system().now()).await?;
    say(format_args!(
        "{}: {} recordings and the database with {} audit rows, read back and checked; the audit log ends in {}",
        args.to.display(),
        made.recordings,
        made.audit_rows,
        made.audit_head
    ));
    for (file, does) in
        [(certificates::KEY_FILE, "signs certificates"), (sealing::KEY_FILE, "opens the secrets of second factors")]
    {
        let key = config.data_dir.join(file);
        if key.exists() {
            say(format_args!(
                "not in it: {}, which {does}; keep a copy of its own, where only you read it",
                key.display()
            ));
        }
    }
    Ok(())
}
