//! `web-admin curricula`: publishing documents.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::user::choose_school;
use super::{Failure, Storage, say};
use crate::publishing::{self, Refused};

/// `web-admin curricula …`
#[derive(Debug, Subcommand)]
pub enum CurriculaCommand {
    /// Publishes every course in a folder; what is known already stays as it is
    Import(ImportArgs),
}

/// What to publish where.
#[derive(Debug, Args)]
pub struct ImportArgs {
    /// Folder of a course, or of several
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    #[command(flatten)]
    storage: Storage,
    /// School, made where it is missing [default: the only one there is]
    #[arg(long)]
    school: Option<String>,
}

pub(super) async fn run(command: &CurriculaCommand) -> Result<(), Failure> {
    let CurriculaCommand::Import(args) = command;
    let courses = publishing::courses_in(&args.folder)
        .map_err(|error| Failure::Usage(format!("{}: {error}", args.folder.display())))?;
    if courses.is_empty() {
        return Err(Failure::Usage(format!(
            "{}: holds no course.toml, nor does a folder in it",
            args.folder.display()
        )));
    }
    let state = args.storage.open().await?;
    for course in courses {
        import(&state, &course, args.school.as_deref()).await?;
    }
    state.db.close().await;
    Ok(())
}

/// Publishes one course, all of it or nothing.
async fn import(state: &crate::AppState, course: &Path, school: Option<&str>) -> Result<(), Failure> {
    let mut tx = state.db.write().await?;
    let school = choose_school(&mut tx, state, school).await?;
    let published = publishing::course(&mut tx, school.id, course, state.clock.now()).await;
    let published = published.map_err(|refused| match refused {
        Refused::Document(words) => Failure::Usage(words),
        Refused::Work(error) => Failure::Work(error),
    })?;
    tx.commit().await?;
    published.iter().for_each(say);
    Ok(())
}
