//! `web-admin move`: moves a school from SQLite to PostgreSQL or back; it is served until shortly
//! before the end.

use std::path::{Path, PathBuf};
use std::time::Duration;

use acts::operations::moving::{CopiedRecordings, EndLock, MoveReport, SchoolMove};
use clap::Args;
use platform::clock::Clock;
use platform::config::{Config, ConfigError};
use store::locks::LockError;
use store::operations::moving::{CarriedTable, DatabaseMove, MoveError};

use super::{CommandFailure, recordings_place, say_line};

/// Interval at which the lock on the source is retried while it is still served.
const BETWEEN_LOOKS: Duration = Duration::from_secs(1);

/// Options of `web-admin move`.
#[derive(Debug, Args)]
pub struct MoveArgs {
    /// The database to move: a sqlite: URL or a path, or a postgres:// URL
    #[arg(long, value_name = "URL")]
    from: String,
    /// The database to move to, of the other engine; it must be empty
    #[arg(long, value_name = "URL")]
    to: String,
    /// Data folder of the service that has served the school so far
    #[arg(long, value_name = "DIR", default_value = "data", env = "STYLET_DATA_DIR")]
    from_data_dir: PathBuf,
    /// Data folder of the service that will serve it [default: the same]
    #[arg(long, value_name = "DIR")]
    to_data_dir: Option<PathBuf>,
    /// Its recordings: a folder, a file:// URL, or s3://BUCKET/PREFIX with the usual AWS_ variables
    /// [default: recordings in the data folder]
    #[arg(long, value_name = "URL")]
    from_recordings: Option<String>,
    /// Where to move them: an empty place, or one that an earlier move has copied to [default:
    /// recordings in the data folder to move to]
    #[arg(long, value_name = "URL")]
    to_recordings: Option<String>,
}

impl From<MoveError> for CommandFailure {
    fn from(error: MoveError) -> Self {
        match error {
            MoveError::Refused { .. } => Self::Usage(error.to_string()),
            MoveError::Failed { .. } => Self::Work(error.into()),
        }
    }
}

/// Returns data folder and recordings of one end of the move; `option` is named in errors about the
/// recordings.
fn config_of(data_dir: &Path, recordings: Option<&str>, option: &'static str) -> Result<Config, CommandFailure> {
    let mut config = Config::in_folder(data_dir);
    if let Some(given) = recordings {
        config.keep_recordings_in(recordings_place(given).map_err(|refused| ConfigError { option, ..refused })?);
    }
    Ok(config)
}

/// Reports a refused move as a usage error, at whichever step it was found.
fn sort_failure(error: anyhow::Error) -> CommandFailure {
    match error.downcast::<MoveError>() {
        Ok(error) => error.into(),
        Err(error) => CommandFailure::Work(error),
    }
}

pub(super) async fn run_move(args: &MoveArgs) -> Result<(), CommandFailure> {
    let databases = DatabaseMove::parse(&args.from, &args.to)?;
    let to_data_dir = args.to_data_dir.as_deref().unwrap_or(&args.from_data_dir);
    let from = config_of(&args.from_data_dir, args.from_recordings.as_deref(), "--from-recordings")?;
    let to = config_of(to_data_dir, args.to_recordings.as_deref(), "--to-recordings")?;
    let (source, target, clock) = (databases.source(), databases.target(), Clock::system());
    let mut moving = SchoolMove::begin(databases, from, to, clock.now()).await.map_err(sort_failure)?;
    let copied = moving.copy_recordings().await.map_err(sort_failure)?;
    say_recordings(&moving, &copied);
    let held = hold_source(&mut moving, &source, &clock).await?;
    let since = clock.now();
    let report = moving.finish(&held).await.map_err(sort_failure)?;
    let held_s = clock.now().duration_since(since).as_secs_f64();
    say_rows(&report);
    if !report.findings.is_empty() {
        report.findings.iter().for_each(say_line);
        say_line(format_args!("{} findings: nothing was moved into {target}", report.findings.len()));
        return Err(CommandFailure::Found);
    }
    say_line(format_args!("moved {source} to {target}; not served for {held_s:.1} s"));
    for left in &report.left_behind {
        say_line(format_args!("not moved, copy manually: {left}"));
    }
    say_line(format_args!(
        "serve {target} from now on, and no longer {source}: changes written there would be missing here. Keep the old place until you have a backup of the new one"
    ));
    Ok(())
}

/// Locks the source as soon as it is no longer served; recordings that arrive until then are copied
/// meanwhile.
async fn hold_source(moving: &mut SchoolMove, source: &str, clock: &Clock) -> Result<EndLock, CommandFailure> {
    let mut is_told = false;
    loop {
        match moving.hold_source(clock.now()).await {
            Ok(held) => return Ok(held),
            Err(LockError::Held { place, holder }) if !is_told => {
                say_line(format_args!(
                    "{place}: in use by {holder}. Stop the service that serves {source}: the move waits for that"
                ));
                is_told = true;
            }
            Err(LockError::Held { .. }) => {}
            Err(error) => return Err(anyhow::Error::from(error).into()),
        }
        moving.copy_recordings().await.map_err(sort_failure)?;
        tokio::time::sleep(BETWEEN_LOOKS).await;
    }
}

fn say_recordings(moving: &SchoolMove, CopiedRecordings { named, copied, .. }: &CopiedRecordings) {
    match moving.recording_places() {
        Some([from, to]) => {
            say_line(format_args!("recordings: {named} in {from}, of which {copied} were copied to {to}"))
        }
        None => say_line(format_args!("recordings: {named}, not moved")),
    }
}

/// Prints the rows that were moved, and the hashes by which they were compared.
fn say_rows(report: &MoveReport) {
    let MoveReport { recordings, tables, audit_rows, audit_head, forgotten_uploads, .. } = report;
    let CopiedRecordings { named, copied, .. } = recordings;
    say_line(format_args!("since then: {copied} more recordings; all {named} were read and match the stored hash"));
    for CarriedTable { name, rows, sha256 } in tables {
        say_line(format_args!("{name}: {rows} rows of hash {sha256}"));
    }
    let rows: u64 = tables.iter().map(|table| table.rows).sum();
    say_line(format_args!("{rows} rows in {} tables, read back and compared", tables.len()));
    say_line(format_args!("{audit_rows} audit rows and every grade checked; the audit log ends in {audit_head}"));
    if *forgotten_uploads > 0 {
        say_line(format_args!("unfinished uploads, which the senders must restart: {forgotten_uploads}"));
    }
}
