//! `web-admin judge`: the helper process in which the service works on untrusted input: it scores,
//! reads and annotates recordings, previews drafts, and reads workbooks and pictures. The request
//! is read from standard input, the response is written to standard output. Before it works, the
//! helper gives up its rights to other files, to sockets and to programs.

use std::io::{Read, Write};

use acts::sandbox_jobs;
use acts::sandbox_jobs::SandboxRequest;
use clap::Args;
use platform::helper::confine;
use routes_base::examine_draft;
use rustix::process::{Resource, Rlimit, nice, setrlimit};

/// Niceness of the helper, relative to the service that started it.
const BEHIND_PAGES: i32 = 10;

/// Limits of the helper.
#[derive(Debug, Args)]
pub struct JudgeArgs {
    /// Maximum memory, in MB
    #[arg(long, value_name = "MB")]
    memory_mb: u64,
    /// Maximum wall-clock time, in s, enforced by the service; processor time is limited to twice
    /// this
    #[arg(long, value_name = "S")]
    seconds: u64,
}

/// Runs without an async runtime, whose threads would count against the limits.
pub(super) fn run_judge(args: &JudgeArgs) -> anyhow::Result<()> {
    // Standard error is inherited from the service, as its log.
    tracing_subscriber::fmt().with_ansi(false).with_writer(std::io::stderr).init();
    let limit = |most: u64| Rlimit { current: Some(most), maximum: Some(most) };
    setrlimit(Resource::Data, limit(args.memory_mb.saturating_mul(1_000_000)))?;
    // The service enforces the limit on wall-clock time; this one ends the helper if the service is
    // gone.
    setrlimit(Resource::Cpu, limit(args.seconds.saturating_mul(2)))?;
    // A core dump as large as the memory limit would be useless.
    setrlimit(Resource::Core, limit(0))?;
    end_with_service();
    let mut question = Vec::new();
    std::io::stdin().read_to_end(&mut question)?;
    let question: SandboxRequest = serde_json::from_slice(&question)?;
    if !matches!(question, SandboxRequest::Arrival(_)) {
        // Requests for pages and fresh uploads have priority. If `nice` fails, the work is done
        // anyway.
        let _ = nice(BEHIND_PAGES);
    }
    confine(&question.permitted_paths())?;
    let answer = sandbox_jobs::answer(question, examine_draft);
    let mut out = std::io::stdout().lock();
    out.write_all(&serde_json::to_vec(&answer)?)?;
    Ok(out.flush()?)
}

/// Asks the system to kill the helper when the service dies, since a killed service cannot do so.
#[cfg(target_os = "linux")]
fn end_with_service() {
    use rustix::process::{Signal, set_parent_process_death_signal};
    // If this fails, the limit on processor time ends the helper.
    let _ = set_parent_process_death_signal(Some(Signal::KILL));
}

/// Does nothing: on other systems the limit on processor time ends the helper.
#[cfg(not(target_os = "linux"))]
fn end_with_service() {}
