//! The commands of `web-admin`. Exit status: 0 success, 1 failure or findings, 2 usage error.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use acts::operations::key_files::{KEYS, KeyFile};
use acts::operations::{key_files, upkeep};
use acts::people::admin_commands::RegistryError;
use clap::{Args, Parser, Subcommand};
use platform::clock::Clock;
use platform::config;
use platform::config::{Config, ConfigError, RecordingsPlace};

use crate::AppState;

mod backup;
mod bench;
mod certificate;
mod curricula;
mod demo;
mod exam;
mod export;
mod judge;
mod moving;
mod rescore;
mod restore;
mod retain;
mod serve;
mod user;
mod verify;
mod work;

/// Trainees' records, scores, curricula and progress.
#[derive(Debug, Parser)]
#[command(name = "web-admin", version, propagate_version = true)]
struct WebAdminCli {
    #[command(subcommand)]
    command: WebAdminCommand,
}

#[derive(Debug, Subcommand)]
enum WebAdminCommand {
    /// Serves pages and the API; creates and migrates the database as needed
    Serve(serve::ServeArgs),
    /// Scores recordings, sends mail and runs all other background work, without serving pages,
    /// next to other services on the same database
    Work(work::WorkArgs),
    /// Creates the database, or migrates it to the current schema
    Migrate(StorageArgs),
    /// Adds people and gives them access
    #[command(subcommand)]
    User(user::UserCommand),
    /// Publishes curricula
    #[command(subcommand)]
    Curricula(curricula::CurriculaCommand),
    /// Creates a demonstration school with people, a course and simulated attempts; prints the
    /// accounts
    Demo(demo::DemoArgs),
    /// Shows the scores of attempts under the current rubric of their exercise; with --apply, adds
    /// those scores
    Rescore(rescore::RescoreArgs),
    /// Creates missing keys, for services that only read them; prints where all keys are
    Keys(StorageArgs),
    /// Retries quarantined recordings and uploads, which crashed the service or its scoring process
    /// twice
    Retry(StorageArgs),
    /// Checks the database, every recording and the audit log; prints each finding and exits with
    /// status 1 if there is any
    Verify(verify::VerifyArgs),
    /// Writes the database and every recording to one file, while the service runs, and verifies it
    Backup(backup::BackupArgs),
    /// Restores a backup into an empty place
    Restore(restore::RestoreArgs),
    /// Moves a school from SQLite to PostgreSQL or back, and its recordings to another place, all
    /// or nothing, compared row by row and byte by byte; the service has to stop only for the last
    /// part. The old place is left unchanged
    Move(moving::MoveArgs),
    /// Warns and erases people past their school's retention period, as the service does once a
    /// day; with --dry-run, only prints them
    Retain(retain::RetainArgs),
    /// Checks certificates, and prints the key that signs them
    #[command(subcommand)]
    Certificate(certificate::CertificateCommand),
    /// Checks exam files
    #[command(subcommand)]
    Exam(exam::ExamCommand),
    Export(export::ExportArgs),
    Bench(bench::BenchArgs),
    /// Runs one job on untrusted input for the service: scores or reads a recording, previews a
    /// draft, reads a workbook or a picture
    #[command(hide = true)]
    Judge(judge::JudgeArgs),
    /// Prints the API's OpenAPI description
    Openapi,
}

/// Options for where the data are stored.
#[derive(Clone, Debug, Args)]
pub struct StorageArgs {
    /// Folder for all data of the service
    #[arg(long, value_name = "DIR", default_value = "data", env = "STYLET_DATA_DIR")]
    data_dir: PathBuf,
    /// Folder of the keys that sign certificates and encrypt second factors, shared by all services
    /// on a database [default: the data folder]
    #[arg(long, value_name = "DIR", env = "STYLET_KEYS")]
    keys: Option<PathBuf>,
    /// Database: a sqlite: URL or a path [default: stylet.db in the data folder], or a postgres://
    /// URL if the program is built for PostgreSQL
    #[arg(long, value_name = "URL", env = "STYLET_DATABASE", hide_env_values = true)]
    database: Option<String>,
    /// Recordings: a folder, a file:// URL, or s3://BUCKET/PREFIX with the usual AWS_ variables
    /// [default: recordings in the data folder]
    #[arg(long, value_name = "URL", env = "STYLET_RECORDINGS")]
    recordings: Option<String>,
}

impl StorageArgs {
    /// Returns the configuration for these options.
    ///
    /// # Errors
    /// When the database or the place of the recordings is not supported.
    pub fn config(&self) -> Result<Config, CommandFailure> {
        let mut config = Config::in_folder(&self.data_dir);
        if let Some(given) = &self.database {
            config.database = config::database_address(given)?;
        }
        if let Some(given) = &self.keys {
            config.keys_dir.clone_from(given);
        }
        if let Some(given) = &self.recordings {
            config.keep_recordings_in(recordings_place(given)?);
        }
        Ok(config)
    }

    /// Opens the state of the service at this place.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub async fn open(&self) -> Result<AppState, CommandFailure> {
        Ok(AppState::open(self.config()?, Clock::system()).await?)
    }
}

/// Parses the place of recordings; settings of buckets are read from the environment.
fn recordings_place(given: &str) -> Result<RecordingsPlace, ConfigError> {
    let environment =
        std::env::vars_os().filter_map(|(name, value)| Some((name.into_string().ok()?, value.into_string().ok()?)));
    config::recordings_place(given, environment)
}

/// Why a command failed.
#[derive(Debug)]
pub enum CommandFailure {
    /// The arguments or the input were wrong.
    Usage(String),
    /// The work failed.
    Work(anyhow::Error),
    /// A check has findings, which are printed already.
    Found,
}

impl From<ConfigError> for CommandFailure {
    fn from(error: ConfigError) -> Self {
        Self::Usage(error.to_string())
    }
}

impl From<anyhow::Error> for CommandFailure {
    fn from(error: anyhow::Error) -> Self {
        Self::Work(error)
    }
}

impl From<RegistryError> for CommandFailure {
    fn from(error: RegistryError) -> Self {
        match error {
            RegistryError::Usage(words) => Self::Usage(words),
            RegistryError::Work(error) => Self::Work(error),
        }
    }
}

impl From<store::Error> for CommandFailure {
    fn from(error: store::Error) -> Self {
        Self::Work(anyhow::Error::new(error).context("database"))
    }
}

impl From<std::io::Error> for CommandFailure {
    fn from(error: std::io::Error) -> Self {
        Self::Work(error.into())
    }
}

impl CommandFailure {
    /// Prints the failure in one line, and returns the exit status.
    fn report(self) -> ExitCode {
        let (words, code) = match self {
            Self::Usage(words) => (words, 2),
            Self::Work(error) => (format!("{error:#}"), 1),
            Self::Found => return ExitCode::from(1),
        };
        // If standard error is closed, there is no other place to report to.
        let _ = writeln!(std::io::stderr(), "web-admin: {words}");
        ExitCode::from(code)
    }
}

/// Prints a line of a command's output. A closed pipe is not a failure of the command.
fn say_line(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// Runs the program.
#[must_use]
pub fn main() -> ExitCode {
    let command = match WebAdminCli::try_parse() {
        Ok(cli) => cli.command,
        Err(refused) => refused.exit(),
    };
    if let WebAdminCommand::Judge(args) = &command {
        return match judge::run_judge(args) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => CommandFailure::Work(error).report(),
        };
    }
    let runtime = match tokio::runtime::Runtime::new() {
        Ok(runtime) => runtime,
        Err(error) => return CommandFailure::from(error).report(),
    };
    match runtime.block_on(run_command(command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

async fn run_command(command: WebAdminCommand) -> Result<(), CommandFailure> {
    match command {
        WebAdminCommand::Serve(args) => serve::run_serve(&args).await,
        WebAdminCommand::Work(args) => work::run_work(&args).await,
        WebAdminCommand::Migrate(storage) => {
            storage.open().await?.db.close().await;
            say_line("the database is up to date");
            Ok(())
        }
        WebAdminCommand::User(command) => user::run_user(&command).await,
        WebAdminCommand::Curricula(command) => curricula::run_curricula(&command).await,
        WebAdminCommand::Demo(args) => demo::run_demo(&args).await,
        WebAdminCommand::Rescore(args) => rescore::run_rescore(&args).await,
        WebAdminCommand::Keys(storage) => {
            let folder = storage.config()?.keys_dir;
            key_files::make_missing_keys(&folder)?;
            for KeyFile { name, does, .. } in KEYS {
                say_line(format_args!("{}, which {does}", folder.join(name).display()));
            }
            Ok(())
        }
        WebAdminCommand::Retry(storage) => {
            let state = storage.open().await?;
            let forgiven = upkeep::forgive_deaths(&state).await.map_err(anyhow::Error::from)?;
            state.db.close().await;
            say_line(format_args!(
                "released {forgiven} recordings and uploads; the service retries them within ten minutes"
            ));
            Ok(())
        }
        WebAdminCommand::Judge(args) => Ok(judge::run_judge(&args)?),
        WebAdminCommand::Verify(args) => verify::run_verify(&args).await,
        WebAdminCommand::Export(args) => export::run_export(&args).await,
        WebAdminCommand::Backup(args) => backup::run_backup(&args).await,
        WebAdminCommand::Restore(args) => restore::run_restore(&args).await,
        WebAdminCommand::Move(args) => moving::run_move(&args).await,
        WebAdminCommand::Retain(args) => retain::run_retain(&args).await,
        WebAdminCommand::Certificate(command) => certificate::run_certificate(&command),
        WebAdminCommand::Exam(command) => exam::run_exam(&command),
        WebAdminCommand::Bench(args) => bench::run_bench(&args).await,
        WebAdminCommand::Openapi => {
            let description = routes_api::description();
            say_line(serde_json::to_string_pretty(&description).map_err(anyhow::Error::from)?);
            Ok(())
        }
    }
}
