//! `stylet doctor`: checks whether this machine is ready for training, with advice on any problem.

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

/// Check this machine: timer, priority, processor, disk, haptic devices, server
///
/// Takes about two seconds; a haptic device is held at zero force for a moment. Exits with status 1
/// if a problem would prevent an attempt from being recorded or delivered; anything that only
/// degrades training is a warning, with status 0.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet doctor --recordings ~/recordings --server https://training.example.org")]
pub struct DoctorArgs {
    /// Folder for recordings
    #[arg(long, value_name = "DIR", default_value = ".")]
    recordings: PathBuf,
    /// Address of a service to check
    #[arg(long, value_name = "URL", value_parser = service::parse_server_address)]
    server: Option<Uri>,
    #[command(flatten)]
    devices: DeviceArgs,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// No problem.
    Ok,
    /// Works, but with limitations.
    Warning,
    /// Would prevent an attempt from being recorded or delivered.
    Problem,
}

/// The result of one check.
#[derive(Debug, Serialize)]
pub struct DoctorFinding {
    /// The checked item.
    pub subject: &'static str,
    /// Severity.
    pub level: Level,
    /// The observed state, with units.
    pub found: String,
    /// Advice; empty if there is nothing to do.
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

/// The complete result.
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
