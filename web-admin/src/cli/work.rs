//! `web-admin work`: runs the background work of a service, without pages and the API; also the
//! startup code shared with `web-admin serve`.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use acts::audit::audit_checkpoints;
use acts::audit::checkpoint_store::StatementStore;
use acts::auth::web_sessions::WebSessions;
use acts::error::error_chain;
use acts::letters::notices;
use acts::operations::inspection::begin_inspection;
use acts::operations::key_files::make_missing_keys;
use acts::operations::{upkeep, verification};
use acts::people::course_rosters;
use acts::privacy::erasure_store::ErasureStore;
use acts::privacy::{erasing, retention};
use acts::recordings::uploads;
use acts::training::learning_records::sending;
use acts::training::{badges, deadlines, grade_delivery};
use acts::{SPANS, recordings, replicas};
use anyhow::Context;
use clap::{Args, ValueEnum};
use platform::clock::Clock;
use platform::config::{Config, anchor_mail, mail_to};
use platform::helper::Helper;
use platform::locks::DataLock;
use platform::scanning::Scanner;
use rustix::process::{getpid, kill_process};
use store::locks::LockError;
use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio::sync::Mutex;
use tokio::task::JoinHandle;
use tower_sessions::ExpiredDeletion;
use tracing_subscriber::filter::{FilterExt, filter_fn};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{EnvFilter, Layer};

use super::{CommandFailure, StorageArgs, say_line};
use crate::telemetry::Telemetry;
use crate::{AppState, outbox, worker};

/// Interval at which expired data are deleted.
const TIDY_EVERY: Duration = Duration::from_secs(600);
/// Interval at which the lock on the database is checked, and taken again if the server has lost
/// it.
const HOLD_EVERY: Duration = Duration::from_secs(5);

/// Time for which a shutdown waits for a mail that is being sent.
const LONGEST_LETTER: Duration = Duration::from_secs(5);

/// Options shared by `web-admin work` and `web-admin serve`.
#[derive(Debug, Args)]
pub struct WorkArgs {
    #[command(flatten)]
    storage: StorageArgs,
    /// Public URL of this service, the base of links in emails and to viewers [default: http:// and
    /// the listen address; for viewers, the address in the visitor's request]
    #[arg(long, value_name = "URL", env = "STYLET_PUBLIC_URL")]
    public_url: Option<String>,
    /// Mail: a smtp: or smtps: URL with user and password, or a folder for .eml files [default:
    /// mail in the data folder]
    #[arg(long, value_name = "URL", env = "STYLET_MAIL", hide_env_values = true)]
    mail: Option<String>,
    /// Sender address of emails
    #[arg(long, value_name = "ADDRESS", default_value = "Stylet <stylet@localhost>", env = "STYLET_MAIL_FROM")]
    mail_from: String,
    /// Recipient of a daily email with the last hash of the audit log, to be kept elsewhere
    /// [default: none; the hash is also stored in statements/ of the data folder or the bucket]
    #[arg(long, value_name = "ADDRESS", env = "STYLET_ANCHOR_MAIL")]
    anchor_mail: Option<String>,
    /// Format of the log on standard error
    #[arg(long, value_enum, default_value = "text", env = "STYLET_LOG_FORMAT")]
    log_format: LogFormat,
    /// Socket of ClamAV's clamd, such as /run/clamav/clamd.ctl: it scans recordings before they are
    /// read; infected recordings are refused and not stored [default: no scan]
    #[arg(long, value_name = "PATH", env = "STYLET_CLAMD")]
    clamd: Option<PathBuf>,
    /// Maximum time to scan a recording, in s
    #[arg(long, value_name = "S", default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..=3000))]
    scan_s: u64,
    /// Recordings that are scored in parallel, 0 to leave scoring to other services; if there are
    /// several, one slot is reserved for a second school [default: one less than there are cores, 2
    /// to 4]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=64))]
    judges: Option<u16>,
    /// Maximum memory of each scoring process, in MB
    #[arg(long, value_name = "MB", default_value_t = 2000, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    judge_mb: u64,
    /// Maximum time to score a recording, in s
    #[arg(long, value_name = "S", default_value_t = 300, value_parser = clap::value_parser!(u64).range(1..=86_400))]
    judge_s: u64,
    /// Maximum time that the start waits for the check of the database, in s; a longer check
    /// continues while the service runs
    #[arg(long, value_name = "S", default_value_t = 1, value_parser = clap::value_parser!(u64).range(0..=86_400))]
    check_s: u64,
}

impl WorkArgs {
    /// Returns the configuration for these options.
    ///
    /// # Errors
    /// When the value of an option is not supported.
    pub(super) fn config(&self) -> Result<Config, CommandFailure> {
        let mut config = self.storage.config()?;
        let time = Duration::from_secs(self.scan_s);
        config.scanner = self.clamd.clone().map(|socket| Scanner { socket, time });
        let program = std::env::current_exe().context("cannot find this program's file")?;
        config.helper = Some(Helper { program, memory_mb: self.judge_mb, time: Duration::from_secs(self.judge_s) });
        config.judges = self.judges.map_or_else(default_judges, usize::from);
        config.public_url = self.public_url.as_ref().map(|url| url.trim_end_matches('/').to_owned());
        config.mail_from.clone_from(&self.mail_from);
        if let Some(given) = &self.mail {
            config.mail = mail_to(given)?;
        }
        config.anchor_mail = self.anchor_mail.as_deref().map(anchor_mail).transpose()?;
        Ok(config)
    }
}

/// Runs the background work until a signal.
pub(super) async fn run_work(args: &WorkArgs) -> Result<(), CommandFailure> {
    let shift = Shift::begin(args, args.config()?, "web-admin work").await?;
    let mut signals = Signals::listen()?;
    let background = shift.work();
    say_line("Working");
    signals.wait().await;
    background.stop(&shift.state).await;
    tracing::info!("stopped");
    shift.end().await
}

/// Leaves one core for pages, and at least one scoring slot for recordings that wait behind an
/// expensive one.
fn default_judges() -> usize {
    let cores = thread::available_parallelism().map_or(1, Into::into);
    cores.saturating_sub(1).clamp(2, 4)
}

/// A service from its start to its end.
pub(super) struct Shift {
    /// State shared by all tasks.
    pub(super) state: AppState,
    telemetry: Option<Telemetry>,
    lock: Arc<Mutex<DataLock>>,
}

impl Shift {
    /// Takes the lock on the data and runs the startup steps; `purpose` is shown to other processes
    /// that find the data locked.
    pub(super) async fn begin(args: &WorkArgs, config: Config, purpose: &str) -> Result<Self, CommandFailure> {
        let telemetry = Telemetry::of_environment()?;
        start_log(args.log_format, telemetry.as_ref());
        make_missing_keys(&config.keys_dir)?;
        let lock = DataLock::join(&config, purpose, Clock::system().now()).await?;
        verification::refuse_lost_database(&config).await?;
        let inspection = begin_inspection(&config, Duration::from_secs(args.check_s)).await?;
        let state = AppState { inspection, ..AppState::open(config, Clock::system()).await? };
        state.recordings.check().await.with_context(|| format!("--recordings: {}", state.recordings.place()))?;
        let cleared =
            recordings::clear_uploads(&state.config.uploads_dir()).context("cannot clear unfinished uploads")?;
        tracing::info!(cleared, "cleared unfinished uploads");
        carry_over(&state).await.context("failed to copy the data folder into the bucket")?;
        let erased = erasing::catch_up(&state).await.context("failed to repeat erasures")?;
        if erased > 0 {
            tracing::warn!(people = erased, "repeated erasures: erased people were in the database");
        }
        let buried = if state.db.is_shared() {
            replicas::succeed(&state).await
        } else {
            replicas::mark_others_dead(&state).await
        };
        buried.map_err(anyhow::Error::from)?;
        replicas::tell_set_aside(&state).await.map_err(anyhow::Error::from)?;
        Ok(Self { state, telemetry, lock: Arc::new(Mutex::new(lock)) })
    }

    /// Starts the background tasks.
    pub(super) fn work(&self) -> BackgroundTasks {
        let state = &self.state;
        let mut tasks = vec![
            tokio::spawn(outbox::run_outbox(state.clone())),
            tokio::spawn(deadlines::run(state.service.clone())),
            tokio::spawn(grade_delivery::run(state.service.clone())),
            tokio::spawn(course_rosters::run(state.service.clone())),
            tokio::spawn(notices::run(state.service.clone())),
            tokio::spawn(retention::run(state.service.clone())),
            tokio::spawn(audit_checkpoints::run(state.service.clone())),
            tokio::spawn(badges::run(state.service.clone())),
            tokio::spawn(sending::run(state.service.clone())),
            tokio::spawn(tidy_up(state.clone())),
        ];
        tasks.extend((state.config.judges > 0).then(|| tokio::spawn(worker::run_worker(state.clone()))));
        if state.db.is_shared() {
            tasks.push(tokio::spawn(replicas::run(state.service.clone())));
            tasks.push(tokio::spawn(hold_on(Arc::clone(&self.lock))));
        }
        tasks.extend(self.telemetry.as_ref().map(|telemetry| tokio::spawn(telemetry.send_figures(state.clone()))));
        BackgroundTasks(tasks)
    }

    /// Releases all leases, closes the database, and sends the remaining telemetry.
    pub(super) async fn end(self) -> Result<(), CommandFailure> {
        replicas::leave(&self.state).await.map_err(anyhow::Error::from)?;
        self.state.db.close().await;
        if let Some(telemetry) = self.telemetry {
            tokio::task::spawn_blocking(|| telemetry.end()).await.map_err(anyhow::Error::from)?;
        }
        Ok(())
    }
}

/// Copies erasures and checkpoints from the data folder to the bucket, if they were written before
/// the bucket was configured.
async fn carry_over(state: &AppState) -> anyhow::Result<()> {
    let (config, recordings) = (&state.config, &state.recordings);
    ErasureStore::of(config, recordings).carry_over(config).await?;
    StatementStore::of(config, recordings).carry_over(config).await
}

/// The running background tasks.
pub(super) struct BackgroundTasks(Vec<JoinHandle<()>>);

impl BackgroundTasks {
    /// Aborts the tasks: work that is not stored yet is repeated later. A mail that is being sent
    /// is given time to finish.
    pub(super) async fn stop(self, state: &AppState) {
        let _none_in_hand = tokio::time::timeout(LONGEST_LETTER, state.letter_in_hand.lock()).await;
        self.0.iter().for_each(JoinHandle::abort);
    }
}

/// Format of a log entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LogFormat {
    /// A line of text.
    Text,
    /// A JSON object per line with named fields, for log collectors.
    Json,
}

/// Logs to standard error, filtered by `RUST_LOG`, and exports spans if a collector is configured.
fn start_log(format: LogFormat, telemetry: Option<&Telemetry>) {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("info"));
    let filter = filter.and(filter_fn(|metadata| metadata.target() != SPANS));
    let log = tracing_subscriber::fmt::layer().with_writer(std::io::stderr);
    let log = match format {
        LogFormat::Text => log.with_ansi(std::io::stderr().is_terminal()).boxed(),
        LogFormat::Json => log.json().flatten_event(true).with_span_list(false).boxed(),
    };
    tracing_subscriber::registry().with(log.with_filter(filter)).with(telemetry.map(Telemetry::layer)).init();
}

/// The signals that stop the service.
pub(super) struct Signals {
    interrupt: Signal,
    terminate: Signal,
}

impl Signals {
    pub(super) fn listen() -> anyhow::Result<Self> {
        let listen = |kind| signal(kind).context("cannot listen for signals");
        Ok(Self { interrupt: listen(SignalKind::interrupt())?, terminate: listen(SignalKind::terminate())? })
    }

    pub(super) async fn wait(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
        }
    }
}

/// Takes the shared lock on the database again whenever the server has lost it. If another process
/// holds the database exclusively by then, this service stops as on SIGTERM.
async fn hold_on(lock: Arc<Mutex<DataLock>>) {
    loop {
        tokio::time::sleep(HOLD_EVERY).await;
        match lock.lock().await.rejoin_if_lost().await {
            Ok(()) => {}
            Err(held @ LockError::Held { .. }) => {
                tracing::error!(cause = %held, "database is in use by another service; stopping");
                if let Err(error) = kill_process(getpid(), rustix::process::Signal::TERM) {
                    tracing::error!(cause = error_chain(&error), "failed to stop this service");
                }
                return;
            }
            Err(unusable) => tracing::warn!(cause = %unusable, "failed to renew the database lock"),
        }
    }
}

/// Deletes expired data periodically.
async fn tidy_up(state: AppState) {
    let sessions = WebSessions::new(state.db.clone(), state.clock.clone());
    loop {
        if let Err(error) = sessions.delete_expired().await {
            tracing::warn!(cause = error_chain(&error), "failed to delete expired sessions");
        }
        if let Err(error) = uploads::tidy(&state).await {
            tracing::warn!(cause = error_chain(&error), "failed to clear unfinished uploads");
        }
        if let Err(error) = erasing::remove_left(&state).await {
            tracing::warn!(cause = error_chain(&error), "failed to delete recordings of erased people");
        }
        if let Err(error) = upkeep::forget_expired(&state).await {
            tracing::warn!(cause = error_chain(&error), "failed to delete expired records");
        }
        state.rate_limit_log.tidy();
        state.refusals.tidy();
        tokio::time::sleep(TIDY_EVERY).await;
    }
}
