//! `web-admin serve`.

use std::io::IsTerminal;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::Duration;

use acts::clock::Clock;
use acts::config::{UploadQuota, anchor_mail, mail_to, origin};
use acts::helper::Helper;
use acts::inspection::begin_inspection;
use acts::locks::DataLock;
use acts::scanning::Scanner;
use acts::upkeep::{self, SetAside};
use acts::web_sessions::WebSessions;
use acts::{SPANS, anchoring, deadlines, erasing, notices, recordings, retention, uploads, verification};
use anyhow::Context;
use clap::{Args, ValueEnum};
use store::people;
use tokio::net::TcpListener;
use tokio::signal::unix::{Signal, SignalKind, signal};
use tower_sessions::ExpiredDeletion;
use tracing_subscriber::filter::{FilterExt, filter_fn};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{EnvFilter, Layer};

use super::{CommandFailure, StorageArgs, say_line};
use crate::serving::{self, ConnectionLimits};
use crate::telemetry::Telemetry;
use crate::{AppState, outbox, routes, worker};

/// How often what has expired is thrown away.
const TIDY_EVERY: Duration = Duration::from_secs(600);

/// How to serve.
#[derive(Debug, Args)]
pub struct ServeArgs {
    /// Address and port to listen on
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1:8080", env = "STYLET_LISTEN")]
    listen: SocketAddr,
    #[command(flatten)]
    storage: StorageArgs,
    /// A proxy in front speaks TLS and sets X-Forwarded-For: cookies become Secure
    #[arg(long, env = "STYLET_BEHIND_TLS")]
    behind_tls: bool,
    /// Where people find this service: links in mails and to viewers begin with it [default: http:// and the address listened
    /// on; to viewers, the address that the visitor came by]
    #[arg(long, value_name = "URL", env = "STYLET_PUBLIC_URL")]
    public_url: Option<String>,
    /// Origin whose pages may upload with a token from a browser, as https://lab.example.org; may be given several times, or
    /// several with commas [default: none]
    #[arg(long, value_name = "ORIGIN", value_delimiter = ',', env = "STYLET_ALLOW_ORIGIN")]
    allow_origin: Vec<String>,
    /// Mail: a smtp: or smtps: URL with user and password, or a folder for .eml files [default: mail in the data folder]
    #[arg(long, value_name = "URL", env = "STYLET_MAIL", hide_env_values = true)]
    mail: Option<String>,
    /// Whom mail is from
    #[arg(long, value_name = "ADDRESS", default_value = "Stylet <stylet@localhost>", env = "STYLET_MAIL_FROM")]
    mail_from: String,
    /// Who is mailed once a day by which hash the audit log ends, to keep it elsewhere [default: nobody; it is in the data folder's
    /// statements/ anyway]
    #[arg(long, value_name = "ADDRESS", env = "STYLET_ANCHOR_MAIL")]
    anchor_mail: Option<String>,
    /// Bearer token that /metrics asks for; without one, /metrics is not there behind TLS
    #[arg(long, value_name = "TOKEN", env = "STYLET_METRICS_TOKEN", hide_env_values = true)]
    metrics_token: Option<String>,
    /// How an entry of the log on standard error is written
    #[arg(long, value_enum, default_value = "text", env = "STYLET_LOG_FORMAT")]
    log_format: LogFormat,
    /// Largest upload, in MB
    #[arg(long, value_name = "MB", default_value_t = 512, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    max_upload_mb: u64,
    /// Socket of ClamAV's clamd, as /run/clamav/clamd.ctl: it scans recordings before anything else reads them, and what it finds
    /// something in is refused and kept nowhere [default: nothing is scanned]
    #[arg(long, value_name = "PATH", env = "STYLET_CLAMD")]
    clamd: Option<PathBuf>,
    /// Longest that scanning a recording may take, in s
    #[arg(long, value_name = "S", default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..=3000))]
    scan_s: u64,
    /// Free room on the disk of the recordings, in MB, below which no upload is taken
    #[arg(long, value_name = "MB", default_value_t = 1000)]
    reserve_mb: u64,
    /// Uploads in pieces that a person or a station may have begun and not ended
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u64).range(1..))]
    owner_uploads: u64,
    /// What those may come to when they are whole, in MB
    #[arg(long, value_name = "MB", default_value_t = 4000, value_parser = clap::value_parser!(u64).range(1..))]
    owner_mb: u64,
    /// As --owner-uploads, for all of a school together
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u64).range(1..))]
    school_uploads: u64,
    /// As --owner-mb, for all of a school together
    #[arg(long, value_name = "MB", default_value_t = 100_000, value_parser = clap::value_parser!(u64).range(1..))]
    school_mb: u64,
    /// Recordings that are judged at once; of several, one is kept free for a second school [default: one less than there are cores, 2 to 4]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=64))]
    judges: Option<u16>,
    /// Most memory, in MB, of each process that judges a recording
    #[arg(long, value_name = "MB", default_value_t = 2000, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    judge_mb: u64,
    /// Longest that judging a recording may take, in s
    #[arg(long, value_name = "S", default_value_t = 300, value_parser = clap::value_parser!(u64).range(1..=86_400))]
    judge_s: u64,
    /// Longest that looking what a draft of an exercise comes to may take, in s
    #[arg(long, value_name = "S", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=20))]
    preview_s: u64,
    /// Longest that the start waits until the database is looked through, in s; what takes longer goes on while the service serves
    #[arg(long, value_name = "S", default_value_t = 2, value_parser = clap::value_parser!(u64).range(0..=86_400))]
    check_s: u64,
    /// How long, in s, /readyz says that the service is about to stop, before it does: so that a proxy in front of several sends
    /// nobody there any more
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = clap::value_parser!(u64).range(0..=3600))]
    leave_s: u64,
}

pub(super) async fn run_serve(args: &ServeArgs) -> Result<(), CommandFailure> {
    let telemetry = Telemetry::of_environment()?;
    start_log(args.log_format, telemetry.as_ref());
    let mut config = args.storage.config()?;
    config.listen = args.listen;
    config.behind_tls = args.behind_tls;
    config.metrics_token.clone_from(&args.metrics_token);
    config.max_upload_bytes = args.max_upload_mb * 1_000_000;
    let time = Duration::from_secs(args.scan_s);
    config.scanner = args.clamd.clone().map(|socket| Scanner { socket, time });
    config.reserve_bytes = args.reserve_mb.saturating_mul(1_000_000);
    let quota = |uploads, mb: u64| UploadQuota { uploads, bytes: mb.saturating_mul(1_000_000) };
    config.owner_quota = quota(args.owner_uploads, args.owner_mb);
    config.school_quota = quota(args.school_uploads, args.school_mb);
    let program = std::env::current_exe().context("cannot find this program's file")?;
    config.helper = Some(Helper { program, memory_mb: args.judge_mb, time: Duration::from_secs(args.judge_s) });
    config.judges = args.judges.map_or_else(default_judges, usize::from);
    config.preview_time = Duration::from_secs(args.preview_s);
    config.public_url = args.public_url.as_ref().map(|url| url.trim_end_matches('/').to_owned());
    config.allowed_origins = args.allow_origin.iter().map(|given| origin(given)).collect::<Result<_, _>>()?;
    config.mail_from.clone_from(&args.mail_from);
    if let Some(given) = &args.mail {
        config.mail = mail_to(given)?;
    }
    config.anchor_mail = args.anchor_mail.as_deref().map(anchor_mail).transpose()?;
    let _lock = DataLock::take(&config, "web-admin serve", Clock::system().now())?;
    verification::refuse_lost_database(&config).await?;
    let inspection = begin_inspection(&config, Duration::from_secs(args.check_s)).await?;
    let state = AppState { inspection, ..AppState::open(config, Clock::system()).await? };
    state.recordings.check().await.with_context(|| format!("--recordings: {}", state.recordings.place()))?;
    let cleared = recordings::clear_uploads(&state.config.uploads_dir()).context("cannot clear unfinished uploads")?;
    tracing::info!(cleared, "unfinished uploads cleared");
    let erased = erasing::catch_up(&state).await.context("who was erased cannot be erased again")?;
    if erased > 0 {
        tracing::warn!(people = erased, "erased again: they had been erased, and were in the database");
    }
    tell_deaths(&state).await?;
    print_greeting(&state).await?;
    serve_until_signal(&state, telemetry.as_ref(), Duration::from_secs(args.leave_s)).await?;
    upkeep::take_back_begun(&state).await.map_err(anyhow::Error::from)?;
    state.db.close().await;
    if let Some(telemetry) = telemetry {
        tokio::task::spawn_blocking(|| telemetry.end()).await.map_err(anyhow::Error::from)?;
    }
    Ok(())
}

/// A core stays for pages, and one judge for whoever comes behind a costly recording.
fn default_judges() -> usize {
    let cores = thread::available_parallelism().map_or(1, Into::into);
    cores.saturating_sub(1).clamp(2, 4)
}

/// Tells of what is tried no more, for it was fatal twice.
async fn tell_deaths(state: &AppState) -> Result<(), CommandFailure> {
    for SetAside { kind, id } in upkeep::count_deaths(state).await.map_err(anyhow::Error::from)? {
        tracing::error!(%id, "the service has died of this {kind} twice: it is set aside; web-admin retry tries it again");
    }
    Ok(())
}

/// How an entry of the log is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LogFormat {
    /// A line for people.
    Text,
    /// A JSON object on a line, its fields by name, for whatever collects logs.
    Json,
}

/// Logs go to standard error; `RUST_LOG` says how much. Spans go where they are collected, if they are.
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

/// An empty service tells how to get in.
async fn print_greeting(state: &AppState) -> Result<(), CommandFailure> {
    if people::count_people(state.db.reader()).await? == 0 {
        say_line(format_args!(
            "Nobody can sign in yet. Add the first person with: web-admin user add --data-dir {} \
             --role administrator --name NAME --email ADDRESS",
            state.config.data_dir.display()
        ));
    }
    Ok(())
}

async fn serve_until_signal(state: &AppState, telemetry: Option<&Telemetry>, leaving: Duration) -> anyhow::Result<()> {
    let listen = state.config.listen;
    let listener = TcpListener::bind(listen).await.with_context(|| format!("cannot listen on {listen}"))?;
    // Before anybody is told that we are up: whoever then stops us must find the handler in place.
    let signals = Signals::listen()?;
    say_line(format_args!("Listening on http://{}", listener.local_addr()?));
    let figures = telemetry.map(|telemetry| tokio::spawn(telemetry.send_figures(state.clone())));
    let background = [
        tokio::spawn(worker::run_worker(state.clone())),
        tokio::spawn(outbox::run_outbox(state.clone())),
        tokio::spawn(deadlines::run(state.service.clone())),
        tokio::spawn(notices::run(state.service.clone())),
        tokio::spawn(retention::run(state.service.clone())),
        tokio::spawn(anchoring::run(state.service.clone())),
        tokio::spawn(tidy_up(state.clone())),
    ];
    let limits = ConnectionLimits::of_process(state.config.behind_tls);
    tracing::info!(connections = limits.whole, by_address = limits.by_address, "serving");
    serving::serve_connections(listener, routes::router(state.clone()), limits, leave(state, signals, leaving)).await;
    background.iter().chain(&figures).for_each(tokio::task::JoinHandle::abort);
    tracing::info!("stopped");
    Ok(())
}

/// What asks the service to stop.
struct Signals {
    interrupt: Signal,
    terminate: Signal,
}

impl Signals {
    fn listen() -> anyhow::Result<Self> {
        let listen = |kind| signal(kind).context("cannot listen for signals");
        Ok(Self { interrupt: listen(SignalKind::interrupt())?, terminate: listen(SignalKind::terminate())? })
    }

    async fn wait(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
        }
    }
}

/// Waits for a signal, says that this service is about to stop, and waits for a while or for another.
async fn leave(state: &AppState, mut signals: Signals, leaving: Duration) {
    signals.wait().await;
    state.leaving.store(true, Ordering::Relaxed);
    // Either is what was waited for.
    let _second = tokio::time::timeout(leaving, signals.wait()).await;
}

/// Throws away what has expired, now and then.
async fn tidy_up(state: AppState) {
    let sessions = WebSessions::new(state.db.clone(), state.clock.clone());
    loop {
        if let Err(error) = sessions.delete_expired().await {
            tracing::warn!(cause = %error, "expired sessions could not be deleted");
        }
        if let Err(error) = uploads::tidy(&state).await {
            tracing::warn!(cause = %error, "unfinished uploads could not be tidied");
        }
        if let Err(error) = erasing::remove_left(&state).await {
            tracing::warn!(cause = %error, "recordings of somebody erased are left");
        }
        if let Err(error) = upkeep::forget_expired(&state).await {
            tracing::warn!(cause = %error, "what has expired could not be deleted");
        }
        state.logins.tidy();
        state.pairings.tidy();
        state.refusals.tidy();
        tokio::time::sleep(TIDY_EVERY).await;
    }
}
