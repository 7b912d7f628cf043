//! Description of the machine, from the operating system where available.

use std::fs;

use serde::Serialize;

/// Processor and system, as shown by the bench and by `doctor`.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// Processor model, or `unknown`.
    pub cpu: String,
    /// Hardware threads available to this program; 0 if unknown.
    pub threads: usize,
    /// Operating system and architecture.
    pub system: String,
}

impl Machine {
    /// Describes the current machine.
    #[must_use]
    pub fn this() -> Self {
        Self {
            cpu: proc_field("/proc/cpuinfo", "model name")
                .or_else(|| std::env::var("PROCESSOR_IDENTIFIER").ok())
                .unwrap_or_else(|| "unknown".to_owned()),
            threads: std::thread::available_parallelism().map_or(0, usize::from),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        }
    }

    /// Formats processor, threads and system for a report.
    #[must_use]
    pub fn in_words(&self) -> String {
        let Self { cpu, threads, system } = self;
        format!("{cpu}, {threads} threads, {system}")
    }
}

/// Returns the version and build profile of this program.
#[must_use]
pub fn program() -> String {
    let profile = if cfg!(debug_assertions) { "debug" } else { "release" };
    format!("stylet {} ({profile} build)", env!("CARGO_PKG_VERSION"))
}

/// Returns the peak resident memory of this process since its start or the last
/// [`reset_peak_memory`], in bytes; `None` if unknown.
#[must_use]
pub fn peak_memory_bytes() -> Option<u64> {
    let kibibytes = proc_field("/proc/self/status", "VmHWM")?;
    kibibytes.split_whitespace().next()?.parse::<u64>().ok().map(|kibibytes| kibibytes * 1024)
}

/// Resets the peak of [`peak_memory_bytes`]. If the system does not support this, the peak since
/// the start remains, which is never smaller.
pub fn reset_peak_memory() {
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// Returns the value after `name:` in a file of `/proc`.
#[must_use]
pub fn proc_field(file: &str, name: &str) -> Option<String> {
    let text = fs::read_to_string(file).ok()?;
    let value = text.lines().find_map(|line| line.strip_prefix(name)?.trim_start().strip_prefix(':'))?;
    Some(value.trim().to_owned())
}
