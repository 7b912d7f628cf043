//! `web-admin judge`: what the service starts to have a recording judged or read, or a draft looked at. The question comes on standard
//! input, the answer goes to standard output.

use std::io::{Read, Write};

use acts::judging;
use acts::judging::JudgeQuestion;
use clap::Args;
use rustix::process::{Resource, Rlimit, nice, setrlimit};

use routes_base::examine_draft;

/// By how much it is nicer than the service that has started it.
const BEHIND_PAGES: i32 = 10;

/// What it may cost.
#[derive(Debug, Args)]
pub struct JudgeArgs {
    /// Most memory, in MB
    #[arg(long, value_name = "MB")]
    memory_mb: u64,
    /// Longest time of the processor, in s
    #[arg(long, value_name = "S")]
    seconds: u64,
}

/// Works without the runtime, whose threads would count against the limits.
pub(super) fn run_judge(args: &JudgeArgs) -> anyhow::Result<()> {
    // Standard error is the service's log.
    tracing_subscriber::fmt().with_ansi(false).with_writer(std::io::stderr).init();
    let limit = |most: u64| Rlimit { current: Some(most), maximum: Some(most) };
    setrlimit(Resource::Data, limit(args.memory_mb.saturating_mul(1_000_000)))?;
    // Whoever waits ends it by the clock; this ends it where nobody is left to.
    setrlimit(Resource::Cpu, limit(args.seconds.saturating_mul(2)))?;
    // A file of the size of the memory would be as useless as it is large.
    setrlimit(Resource::Core, limit(0))?;
    end_with_service();
    let mut question = Vec::new();
    std::io::stdin().read_to_end(&mut question)?;
    let question: JudgeQuestion = serde_json::from_slice(&question)?;
    if !matches!(question, JudgeQuestion::Arrival(_)) {
        // Whoever asks for a page, or has just sent something, comes first. Refused, it is done all the same.
        let _ = nice(BEHIND_PAGES);
    }
    let answer = judging::answer(question, examine_draft);
    let mut out = std::io::stdout().lock();
    out.write_all(&serde_json::to_vec(&answer)?)?;
    Ok(out.flush()?)
}

/// A service that is killed cannot end its helpers: the system does.
#[cfg(target_os = "linux")]
fn end_with_service() {
    use rustix::process::{Signal, set_parent_process_death_signal};
    // Refused, the limits on its time end it.
    let _ = set_parent_process_death_signal(Some(Signal::KILL));
}

/// Elsewhere the limits on its time end it.
#[cfg(not(target_os = "linux"))]
fn end_with_service() {}
