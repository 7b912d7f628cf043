//! `web-admin curricula`: publishing documents.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::user::choose_school;
use super::{Failure, Storage, say};
use acts::publishing;
use acts::publishing::Refused;
use acts::surveys;

/// `web-admin curricula …`
#[derive(Debug, Subcommand)]
pub enum CurriculaCommand {
    /// Publishes every course and instrument in a folder; what is known already stays as it is
    Import(ImportArgs),
}

/// What to publish where.
#[derive(Debug, Args)]
pub struct ImportArgs {
    /// Folder of a course, of instruments, or of several courses with `instruments` beside them
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
    let instruments = surveys::documents_in(&args.folder)
        .map_err(|error| Failure::Usage(format!("{}: {error}", args.folder.display())))?;
    if courses.is_empty() && instruments.is_empty() {
        return Err(Failure::Usage(format!(
            "{}: holds no course.toml, nor does a folder in it, and no instruments",
            args.folder.display()
        )));
    }
    let state = args.storage.open().await?;
    if !instruments.is_empty() {
        import_instruments(&state, &instruments, args.school.as_deref()).await?;
    }
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
    let published = published.map_err(failure)?;
    surveys::course_surveys(&mut tx, school.id, state.clock.now()).await?;
    tx.commit().await?;
    published.iter().for_each(say);
    Ok(())
}

/// Publishes instruments, all of them or none.
async fn import_instruments(state: &crate::AppState, files: &[PathBuf], school: Option<&str>) -> Result<(), Failure> {
    let mut tx = state.db.write().await?;
    let school = choose_school(&mut tx, state, school).await?;
    let mut published = Vec::new();
    for file in files {
        let done = surveys::publish(&mut tx, school.id, file, state.clock.now()).await;
        published.push(done.map_err(failure)?);
    }
    surveys::course_surveys(&mut tx, school.id, state.clock.now()).await?;
    tx.commit().await?;
    published.iter().for_each(say);
    Ok(())
}

fn failure(refused: Refused) -> Failure {
    match refused {
        Refused::Document(words) => Failure::Usage(words),
        Refused::Work(error) => Failure::Work(error),
    }
}
