//! `stylet doctor`: what this machine has for training, what is missing and what to do about it.

mod devices;
mod probes;

use std::io::{self, Write};
use std::path::PathBuf;

use bench::machine::{self, Machine};
use serde::Serialize;
use ureq::http::Uri;

use crate::devices::DeviceArgs;
use crate::exit::{Failure, Outcome};
use crate::{output, service};

/// Examine this machine: timer, priority, processor, disk, haptic devices, server
///
/// Takes about two seconds; a haptic device is held at zero force for a moment. Exit 1 when something would keep an attempt from being recorded or delivered; what only
/// makes it worse is a warning, with exit 0.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet doctor --recordings ~/recordings --server https://training.example.org")]
pub struct DoctorArgs {
    /// Folder that recordings will be written to
    #[arg(long, value_name = "DIR", default_value = ".")]
    recordings: PathBuf,
    /// A service to reach
    #[arg(long, value_name = "URL", value_parser = service::parse_server_address)]
    server: Option<Uri>,
    #[command(flatten)]
    devices: DeviceArgs,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// How serious a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// As it should be.
    Ok,
    /// Works, but worse than it could.
    Warning,
    /// Would keep an attempt from being recorded or delivered.
    Problem,
}

/// One thing looked at.
#[derive(Debug, Serialize)]
pub struct DoctorFinding {
    /// What was looked at.
    pub subject: &'static str,
    /// How serious it is.
    pub level: Level,
    /// What was found, in words with units.
    pub found: String,
    /// What to do about it; empty when nothing.
    pub advice: String,
}

impl DoctorFinding {
    fn ok(subject: &'static str, found: impl Into<String>) -> Self {
        Self { subject, level: Level::Ok, found: found.into(), advice: String::new() }
    }

    fn warning(subject: &'static str, found: impl Into<String>, advice: impl Into<String>) -> Self {
        Self { subject, level: Level::Warning, found: found.into(), advice: advice.into() }
    }

    fn problem(subject: &'static str, found: impl Into<String>, advice: impl Into<String>) -> Self {
        Self { subject, level: Level::Problem, found: found.into(), advice: advice.into() }
    }
}

/// All of it.
#[derive(Serialize)]
struct Examination {
    program: String,
    machine: Machine,
    findings: Vec<DoctorFinding>,
}

/// Runs the command.
pub fn run(args: &DoctorArgs) -> Outcome {
    let machine = Machine::this();
    let mut findings = vec![
        probes::probe_processor(&machine),
        probes::probe_timer(),
        probes::probe_priority(),
        probes::probe_disk_space(&args.recordings),
        probes::probe_disk_speed(&args.recordings),
    ];
    findings.push(devices::probe_openhaptics(&args.devices.openhaptics()));
    findings.push(devices::probe_inverse3(&args.devices.inverse3()));
    #[cfg(feature = "window")]
    findings.push(devices::probe_gamepads());
    findings.extend(args.server.as_ref().map(probes::probe_server));
    findings.push(probes::probe_graphics());
    let well = findings.iter().all(|finding| finding.level != Level::Problem);
    let examination = Examination { program: machine::program(), machine, findings };
    match args.json {
        true => output::print_json(&examination)?,
        false => output::print_buffered(|out| report(&examination, out))?,
    }
    if well { Ok(()) } else { Err(Failure::Found) }
}

fn report(examination: &Examination, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{}", examination.program)?;
    for DoctorFinding { subject, level, found, advice } in &examination.findings {
        let level = match level {
            Level::Ok => "ok",
            Level::Warning => "warning",
            Level::Problem => "PROBLEM",
        };
        writeln!(out, "{level:8} {subject:18} {found}")?;
        if !advice.is_empty() {
            writeln!(out, "{:27} → {advice}", "")?;
        }
    }
    Ok(())
}
