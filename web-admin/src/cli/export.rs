//! `web-admin export`: exports a school's attempts for research.

use std::fs;
use std::path::PathBuf;

use acts::people::admin_commands;
use acts::studies::research;
use anyhow::Context;
use clap::Args;

use super::{CommandFailure, StorageArgs, say_line};
use crate::research::{ResearchOrder, write_research_tables};

/// Writes a school's attempts for research, as Parquet tables under pseudonyms with a codebook
///
/// attempts.parquet, metrics.parquet and codebook.json; with --samples also every sample of every
/// recording. Includes attempts of trainees, and of staff who have agreed to the use of theirs;
/// attempts of guests belong to the data of their study. Names, addresses and student numbers are
/// not exported.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  web-admin export --data-dir school --out tables")]
pub struct ExportArgs {
    #[command(flatten)]
    storage: StorageArgs,
    /// School [default: the only one there is]
    #[arg(long)]
    school: Option<String>,
    /// Folder for the tables; created if it is missing. Existing tables are not replaced
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Also write samples.parquet, with every sample of every recording
    #[arg(long)]
    samples: bool,
}

pub(super) async fn run_export(args: &ExportArgs) -> Result<(), CommandFailure> {
    let state = args.storage.open().await?;
    let school = admin_commands::find_school(&state, args.school.as_deref()).await?;
    let order = ResearchOrder { folder: args.out.clone(), samples: args.samples };
    if let Some(taken) = order.files().into_iter().find(|file| file.exists()) {
        return Err(CommandFailure::Usage(format!("{}: already exists; choose another folder", taken.display())));
    }
    fs::create_dir_all(&args.out).with_context(|| args.out.display().to_string())?;
    let counts = write_research_tables(&state, school.id, &order).await?;
    research::note_research_export(&state, school.id, &counts).await.map_err(anyhow::Error::from)?;
    say_line(format_args!(
        "{} attempts, {} values of metrics, {} samples",
        counts.attempts, counts.metrics, counts.samples
    ));
    let held_back = counts.of_guests + counts.of_staff;
    if held_back > 0 {
        say_line(format_args!(
            "{held_back} attempts excluded: {} of guests, {} of staff who have not agreed",
            counts.of_guests, counts.of_staff
        ));
    }
    if counts.unread > 0 {
        say_line(format_args!("{} recordings could not be read", counts.unread));
    }
    state.db.close().await;
    Ok(())
}
