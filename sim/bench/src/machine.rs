//! What this machine is, read from the operating system where it says.

use std::fs;

use serde::Serialize;

/// Processor and system, as the bench and `doctor` name them.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// Processor model, or `unknown`.
    pub cpu: String,
    /// Hardware threads this program may use; 0 when unknown.
    pub threads: usize,
    /// Operating system and architecture.
    pub system: String,
}

impl Machine {
    /// This machine.
    #[must_use]
    pub fn this() -> Self {
        Self {
            cpu: proc_field("/proc/cpuinfo", "model name").unwrap_or_else(|| "unknown".to_owned()),
            threads: std::thread::available_parallelism().map_or(0, usize::from),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        }
    }

    /// Processor, threads and system, as reports have them.
    #[must_use]
    pub fn in_words(&self) -> String {
        let Self { cpu, threads, system } = self;
        format!("{cpu}, {threads} threads, {system}")
    }
}

/// Version and build profile of this program.
#[must_use]
pub fn program() -> String {
    let profile = if cfg!(debug_assertions) { "debug" } else { "release" };
    format!("stylet {} ({profile} build)", env!("CARGO_PKG_VERSION"))
}

/// Peak resident memory of this process since it began or [`reset_peak_memory`], in bytes; absent where unknown.
#[must_use]
pub fn peak_memory_bytes() -> Option<u64> {
    let kibibytes = proc_field("/proc/self/status", "VmHWM")?;
    kibibytes.split_whitespace().next()?.parse::<u64>().ok().map(|kibibytes| kibibytes * 1024)
}

/// Lets [`peak_memory_bytes`] begin anew. Where the system cannot, the peak stays the one since the start: never less.
pub fn reset_peak_memory() {
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// The value after `name:` in a file of `/proc`.
#[must_use]
pub fn proc_field(file: &str, name: &str) -> Option<String> {
    let text = fs::read_to_string(file).ok()?;
    let value = text.lines().find_map(|line| line.strip_prefix(name)?.trim_start().strip_prefix(':'))?;
    Some(value.trim().to_owned())
}
