//! The checks of `doctor`, one function each.

use std::io::Write;
use std::path::Path;
use std::time::Duration;

use bench::machine::{Machine, proc_field};
use haptics::servo::{self, Priority};
use ureq::Agent;
use ureq::http::Uri;

use super::DoctorFinding;
use crate::{clock, machine};

/// Ticks of the timer probe: one second at 1 kHz.
const TICKS: u32 = 1000;
/// Tick rate of the servo, in Hz.
const TICK_HZ: f64 = 1000.0;
/// Lateness of a servo tick, in µs, that becomes perceptible; 99 of 100 ticks should be below it.
const LATE_US: f64 = 500.0;
/// Number of bytes written to measure the disk speed.
const DISK_TEST_BYTES: usize = 16 << 20;
/// Free space below which a warning is given: about a hundred attempts of a minute.
const LITTLE_SPACE_BYTES: u64 = 1 << 30;
/// Minimum disk speed for recording, in bytes per second: five times the data rate of a recording.
const SLOW_DISK_BYTES_PER_S: f64 = 1e6;

/// Checks the processor.
pub fn probe_processor(machine: &Machine) -> DoctorFinding {
    let found = format!("{}, {} threads, {}", machine.cpu, machine.threads, machine.system);
    match machine.threads {
        1 => DoctorFinding::warning("processor", found, "a servo at 1 kHz needs a core of its own: use two or more"),
        _ => DoctorFinding::ok("processor", found),
    }
}

/// Measures the wake-up lateness of the servo's thread.
pub fn probe_timer() -> DoctorFinding {
    let late = match servo::bare(TICK_HZ, TICKS) {
        Ok(times) => times.quantiles(),
        Err(error) => return DoctorFinding::problem("timer", error.to_string(), "close other programs"),
    };
    let found = format!("1 kHz wake-up late by {late}");
    match late.p99_us > LATE_US {
        true => DoctorFinding::warning("timer", found, "allow real-time priority, and close other programs"),
        false => DoctorFinding::ok("timer", found),
    }
}

/// Opens all graphics adapters, and reports the best that opens, the number of others, and those
/// that do not open.
pub fn probe_graphics() -> DoctorFinding {
    let adapters = render::adapters();
    let usable: Vec<_> = adapters.iter().filter_map(|adapter| adapter.as_ref().ok()).collect();
    let broken: Vec<_> =
        adapters.iter().filter_map(|adapter| adapter.as_ref().err()).map(ToString::to_string).collect();
    let Some(best) = usable.first() else {
        let found = if broken.is_empty() { "no adapter".to_owned() } else { broken.join("; ") };
        return DoctorFinding::problem("graphics", found, render::AdapterError::NoAdapter.to_string());
    };
    let mut found = match usable.len() - 1 {
        0 => best.to_string(),
        others => format!("{best}, {others} more"),
    };
    for error in &broken {
        found = format!("{found}; {error}");
    }
    match best.software {
        true => DoctorFinding::warning(
            "graphics",
            found,
            "the processor renders the picture: install the driver of the graphics card, if there is one",
        ),
        false => DoctorFinding::ok("graphics", found),
    }
}

/// Checks whether the servo may use real-time priority.
pub fn probe_priority() -> DoctorFinding {
    let subject = "real-time priority";
    match real_time_limit() {
        None => match servo::granted() {
            Ok(granted @ Priority::Ordinary) => DoctorFinding::warning(subject, granted.to_string(), granted.advice()),
            Ok(_) => DoctorFinding::ok(subject, "granted"),
            Err(error) => DoctorFinding::problem(subject, error.to_string(), "close other programs"),
        },
        Some(0) => DoctorFinding::warning(
            subject,
            "refused: the limit rtprio is 0",
            "as root: echo '@users - rtprio 80' > /etc/security/limits.d/stylet.conf, then sign in again",
        ),
        Some(limit) => DoctorFinding::ok(subject, format!("allowed, up to {limit}")),
    }
}

/// The highest real-time priority allowed for this process; `None` if the system does not report
/// it.
fn real_time_limit() -> Option<u32> {
    const CAP_SYS_NICE: u64 = 1 << 23;
    // Under Wine the files of Linux can be read on Windows, too.
    if cfg!(windows) {
        return None;
    }
    let capabilities = proc_field("/proc/self/status", "CapEff")?;
    if u64::from_str_radix(&capabilities, 16).is_ok_and(|held| held & CAP_SYS_NICE != 0) {
        return Some(99);
    }
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let soft = limits.lines().find_map(|line| line.strip_prefix("Max realtime priority"))?.split_whitespace().next()?;
    if soft == "unlimited" { Some(99) } else { soft.parse().ok() }
}

/// Checks the free space for recordings.
pub fn probe_disk_space(folder: &Path) -> DoctorFinding {
    let subject = "disk space";
    match machine::free_bytes(folder) {
        None => DoctorFinding::warning(subject, format!("unknown in {}", folder.display()), "check it yourself"),
        Some(bytes) => {
            let found = format!("{:.1} GB free in {}", bytes as f64 * 1e-9, folder.display());
            match bytes < LITTLE_SPACE_BYTES {
                true => DoctorFinding::warning(subject, found, "a minute's attempt takes up to 12 MB: make room"),
                false => DoctorFinding::ok(subject, found),
            }
        }
    }
}

/// Checks the write speed for recordings.
pub fn probe_disk_speed(folder: &Path) -> DoctorFinding {
    let subject = "disk speed";
    match write_speed(folder) {
        Err(error) => DoctorFinding::problem(
            subject,
            format!("{} cannot be written to: {error}", folder.display()),
            "choose another folder with --recordings, or change its permissions",
        ),
        Ok(bytes_per_s) => {
            let found = format!("{:.0} MB/s written and synced in {}", bytes_per_s * 1e-6, folder.display());
            match bytes_per_s < SLOW_DISK_BYTES_PER_S {
                true => DoctorFinding::warning(subject, found, "a recording needs 0.2 MB/s: use a local disk"),
                false => DoctorFinding::ok(subject, found),
            }
        }
    }
}

/// Writes and syncs a temporary file; returns the speed in bytes per second.
fn write_speed(folder: &Path) -> std::io::Result<f64> {
    let mut file = tempfile::tempfile_in(folder)?;
    // Incompressible bytes for compressing file systems, from a multiplicative generator.
    let mut word = 1_u32;
    let noise: Vec<u8> = std::iter::repeat_with(|| {
        word = word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (word >> 24) as u8
    })
    .take(DISK_TEST_BYTES)
    .collect();
    let start = clock::instant();
    file.write_all(&noise)?;
    file.sync_all()?;
    Ok(DISK_TEST_BYTES as f64 / start.elapsed().as_secs_f64())
}

/// Checks whether the service responds.
pub fn probe_server(server: &Uri) -> DoctorFinding {
    let address = format!("{}/healthz", server.to_string().trim_end_matches('/'));
    let config = Agent::config_builder()
        .http_status_as_error(false)
        .max_redirects(0)
        .max_redirects_will_error(false)
        .timeout_global(Some(Duration::from_secs(10)))
        .build();
    let start = clock::instant();
    match Agent::from(config).get(&address).call() {
        Ok(response) if response.status() == 200 => {
            let ms = start.elapsed().as_secs_f64() * 1e3;
            DoctorFinding::ok("server", format!("{address} answers in {ms:.0} ms"))
        }
        Ok(response) => {
            let found = format!("{address} answers HTTP {}", response.status().as_u16());
            DoctorFinding::problem("server", found, "check that this is the address of web-admin, and that it is ready")
        }
        Err(error) => {
            let advice = "check the address, the network, and that web-admin serve is running";
            DoctorFinding::problem("server", format!("{address}: {error}"), advice)
        }
    }
}
