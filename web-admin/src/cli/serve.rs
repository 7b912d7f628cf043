//! `web-admin serve`: serves pages and the API, and runs the background work.

use std::net::SocketAddr;
use std::sync::atomic::Ordering;
use std::time::Duration;

use anyhow::Context;
use clap::Args;
use platform::config::{UploadQuota, origin};
use platform::outgoing::OutgoingRules;
use store::people;
use tokio::net::TcpListener;

use super::work::{Shift, Signals, WorkArgs};
use super::{CommandFailure, say_line};
use crate::serving::{self, ConnectionLimits};
use crate::{AppState, routes};

/// Options of `web-admin serve`.
#[derive(Debug, Args)]
pub struct ServeArgs {
    /// Address and port to listen on
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1:8080", env = "STYLET_LISTEN")]
    listen: SocketAddr,
    #[command(flatten)]
    work: WorkArgs,
    /// Behind a proxy that terminates TLS and sets X-Forwarded-For: cookies become Secure
    #[arg(long, env = "STYLET_BEHIND_TLS")]
    behind_tls: bool,
    /// Origin whose pages may upload with a token from a browser, such as https://lab.example.org;
    /// may be repeated or separated by commas [default: none]
    #[arg(long, value_name = "ORIGIN", value_delimiter = ',', env = "STYLET_ALLOW_ORIGIN")]
    allow_origin: Vec<String>,
    /// Host and port, such as 127.0.0.1:9000, of a provider of identities that is asked without TLS;
    /// may be repeated, for tests [default: none]
    #[arg(long, value_name = "HOST:PORT", value_delimiter = ',', env = "STYLET_ALLOW_PLAIN_HTTP")]
    allow_plain_http: Vec<String>,
    /// Permit requests to providers at loopback and private addresses, as in an intranet
    #[arg(long, env = "STYLET_ALLOW_PRIVATE_ADDRESSES")]
    allow_private_addresses: bool,
    /// Bearer token that /metrics requires; without one, /metrics is not available behind TLS
    #[arg(long, value_name = "TOKEN", env = "STYLET_METRICS_TOKEN", hide_env_values = true)]
    metrics_token: Option<String>,
    /// Maximum size of an upload, in MB
    #[arg(long, value_name = "MB", default_value_t = 512, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    max_upload_mb: u64,
    /// Minimum free space on the disk of the recordings, in MB, below which uploads are refused
    #[arg(long, value_name = "MB", default_value_t = 1000)]
    reserve_mb: u64,
    /// Free space on the disk of the data folder, in MB, that is reserved for the database
    #[arg(long, value_name = "MB", default_value_t = 200)]
    database_reserve_mb: u64,
    /// Maximum number of unfinished resumable uploads of a person or a station
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u64).range(1..))]
    owner_uploads: u64,
    /// Maximum total size of those uploads once complete, in MB
    #[arg(long, value_name = "MB", default_value_t = 4000, value_parser = clap::value_parser!(u64).range(1..))]
    owner_mb: u64,
    /// As --owner-uploads, for a whole school
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u64).range(1..))]
    school_uploads: u64,
    /// As --owner-mb, for a whole school
    #[arg(long, value_name = "MB", default_value_t = 100_000, value_parser = clap::value_parser!(u64).range(1..))]
    school_mb: u64,
    /// Maximum number of attempts of a trainee accepted within 24 hours
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u64).range(1..))]
    person_attempts: u64,
    /// Maximum total size of a trainee's recordings, in MB
    #[arg(long, value_name = "MB", default_value_t = 20_000, value_parser = clap::value_parser!(u64).range(1..))]
    person_mb: u64,
    /// Maximum time to preview a draft of an exercise, in s
    #[arg(long, value_name = "S", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=20))]
    preview_s: u64,
    /// Time, in s, for which /readyz reports that the service is about to stop before it stops, so
    /// that a load balancer sends no more requests to it
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = clap::value_parser!(u64).range(0..=3600))]
    leave_s: u64,
}

pub(super) async fn run_serve(args: &ServeArgs) -> Result<(), CommandFailure> {
    let mut config = args.work.config()?;
    config.listen = args.listen;
    config.behind_tls = args.behind_tls;
    config.metrics_token.clone_from(&args.metrics_token);
    config.max_upload_bytes = args.max_upload_mb * 1_000_000;
    config.reserve_bytes = args.reserve_mb.saturating_mul(1_000_000);
    config.database_reserve_bytes = args.database_reserve_mb.saturating_mul(1_000_000);
    let quota = |uploads, mb: u64| UploadQuota { uploads, bytes: mb.saturating_mul(1_000_000) };
    config.owner_quota = quota(args.owner_uploads, args.owner_mb);
    config.school_quota = quota(args.school_uploads, args.school_mb);
    config.person_quota = quota(args.person_attempts, args.person_mb);
    config.preview_time = Duration::from_secs(args.preview_s);
    config.allowed_origins = args.allow_origin.iter().map(|given| origin(given)).collect::<Result<_, _>>()?;
    config.outgoing =
        OutgoingRules { plain_http: args.allow_plain_http.clone(), private_addresses: args.allow_private_addresses };
    let shift = Shift::begin(&args.work, config, "web-admin serve").await?;
    print_greeting(&shift.state).await?;
    serve_until_signal(&shift, Duration::from_secs(args.leave_s)).await?;
    shift.end().await
}

/// Explains how to add the first person while there are no accounts.
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

async fn serve_until_signal(shift: &Shift, leaving: Duration) -> anyhow::Result<()> {
    let state = &shift.state;
    let listen = state.config.listen;
    let listener = TcpListener::bind(listen).await.with_context(|| format!("cannot listen on {listen}"))?;
    // Before the line that reports the service as up: a signal sent in reaction to it must find the
    // handler installed.
    let signals = Signals::listen()?;
    say_line(format_args!("Listening on http://{}", listener.local_addr()?));
    let background = shift.work();
    let limits = ConnectionLimits::of_process(state.config.behind_tls);
    tracing::info!(connections = limits.whole, by_address = limits.by_address, "serving");
    serving::serve_connections(listener, routes::router(state.clone()), limits, leave(state, signals, leaving)).await;
    background.stop(state).await;
    tracing::info!("stopped");
    Ok(())
}

/// Waits for a signal, reports the service as not ready, then waits for `leaving` or a second
/// signal.
async fn leave(state: &AppState, mut signals: Signals, leaving: Duration) {
    signals.wait().await;
    state.leaving.store(true, Ordering::Relaxed);
    // Both outcomes end the wait.
    let _second = tokio::time::timeout(leaving, signals.wait()).await;
}
