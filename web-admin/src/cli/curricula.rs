//! `web-admin curricula`: publishes documents.

use std::path::PathBuf;

use acts::authoring::{importing, instruments, publishing};
use clap::{Args, Subcommand};

use super::{CommandFailure, StorageArgs, say_line};

/// `web-admin curricula …`
#[derive(Debug, Subcommand)]
pub enum CurriculaCommand {
    /// Publishes every course and instrument in a folder; unchanged documents are skipped
    Import(ImportArgs),
}

/// Options of `web-admin curricula import`.
#[derive(Debug, Args)]
pub struct ImportArgs {
    /// Folder of a course, of instruments, or of several courses with a folder `instruments` next
    /// to them
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    #[command(flatten)]
    storage: StorageArgs,
    /// School, created if it is missing [default: the only one there is]
    #[arg(long)]
    school: Option<String>,
}

pub(super) async fn run_curricula(command: &CurriculaCommand) -> Result<(), CommandFailure> {
    let CurriculaCommand::Import(args) = command;
    let courses = publishing::courses_in(&args.folder)
        .map_err(|error| CommandFailure::Usage(format!("{}: {error}", args.folder.display())))?;
    let instruments = instruments::documents_in(&args.folder)
        .map_err(|error| CommandFailure::Usage(format!("{}: {error}", args.folder.display())))?;
    if courses.is_empty() && instruments.is_empty() {
        return Err(CommandFailure::Usage(format!(
            "{}: contains neither a course.toml, nor folders with one, nor instruments",
            args.folder.display()
        )));
    }
    let state = args.storage.open().await?;
    let school = args.school.as_deref();
    if !instruments.is_empty() {
        importing::import_instruments(&state, school, &instruments).await?.iter().for_each(say_line);
    }
    for course in courses {
        importing::import_course(&state, school, &course).await?.iter().for_each(say_line);
    }
    state.db.close().await;
    Ok(())
}
