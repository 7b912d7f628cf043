//! `stylet simulate`: an attempt without a window, faster than real time.

use std::fs;
use std::path::PathBuf;

use attempt::simulate::{self, Clock, Simulated};
use clap::builder::RangedU64ValueParser;
use documents::{ExerciseBundle, Patient};
use law::soundness;
use recording::Session;
use serde::Serialize;
use time::format_description::well_known::Rfc3339;
use time::{OffsetDateTime, UtcOffset};
use tissue::SpecimenError;
use uuid::Uuid;

use crate::exit::{Failure, Outcome};
use crate::maker::{self, HandChoice, Maker};
use crate::motion::WatchedSource;
use crate::new_file::NewFile;
use crate::{clock, output, sources};

/// Let a virtual operator perform an exercise and record it
///
/// The seed draws the patient and the operator's hand. The same seed gives the same file but for the session's
/// identifier and start, which --session-id and --started-at fix. The recording gets its name only when it is whole.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    stylet simulate exercise.toml --operator expert --seed 7 --out attempt.mcap\n  \
    stylet simulate exercise.toml --operator constant:2 --out slow.mcap")]
pub struct SimulateArgs {
    /// The exercise
    #[arg(value_name = "EXERCISE.toml")]
    exercise: PathBuf,
    /// Who moves the needle: novice, intermediate, expert, constant:MM_S (a stiff hand at that speed), or a CSV file
    /// with t_s and either x_m along the planned axis or px_m, py_m, pz_m and optionally qx, qy, qz, qw
    #[arg(long, value_name = "NAME|constant:MM_S|FILE.csv", default_value = "expert")]
    operator: HandChoice,
    /// Draws the patient and the operator's hand
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// The recording to write
    #[arg(long, value_name = "REC.mcap")]
    out: PathBuf,
    /// Replace the recording if it exists
    #[arg(long)]
    force: bool,
    /// Identifier of the session [default: a new UUIDv7]
    #[arg(long, value_name = "UUID")]
    session_id: Option<Uuid>,
    /// Start of the attempt, for example 2026-01-31T09:00:00Z [default: now]
    #[arg(long, value_name = "RFC3339", value_parser = start)]
    started_at: Option<OffsetDateTime>,
    /// Servo rate, in Hz, 100 to 10000
    #[arg(long, value_name = "HZ", default_value_t = 1000, value_parser = RangedU64ValueParser::<u32>::new().range(100..=10_000))]
    tick_hz: u32,
    /// Pseudonym of the trainee, never a name: up to 64 letters, digits and -_.
    #[arg(long, value_name = "PSEUDONYM", default_value = "", hide_default_value = true, value_parser = pseudonym)]
    trainee: String,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// What is said of an attempt.
#[derive(Serialize)]
struct SimulationSummary {
    recording: String,
    session_id: Uuid,
    exercise_id: String,
    operator: String,
    seed: u64,
    patient_thickness_mm: Vec<f64>,
    duration_s: f64,
    ticks: u64,
    ruptures: u64,
    bytes: u64,
    wall_s: f64,
    times_real_time: f64,
}

/// Runs the command.
pub fn run(args: &SimulateArgs) -> Outcome {
    let bundle = ExerciseBundle::read(&args.exercise)?;
    let session = session(args, &bundle);
    let started = clock::instant();
    let simulated = record(args, &session, &bundle)?;
    let wall_s = started.elapsed().as_secs_f64();
    let summary = SimulationSummary {
        recording: args.out.display().to_string(),
        session_id: session.session_id,
        exercise_id: session.exercise_id,
        operator: session.device,
        seed: session.seed,
        patient_thickness_mm: session.patient_thickness_mm,
        duration_s: simulated.duration_s,
        ticks: simulated.ticks,
        ruptures: simulated.ruptures,
        bytes: fs::metadata(&args.out).map_or(0, |metadata| metadata.len()),
        wall_s,
        times_real_time: simulated.duration_s / wall_s,
    };
    match args.json {
        true => output::print_json(&summary),
        false => report(&summary),
    }
}

/// Simulates and writes, under a temporary name until all is on disk.
fn record(args: &SimulateArgs, session: &Session, bundle: &ExerciseBundle) -> Result<Simulated, Failure> {
    let patient = Patient { thickness_mm: session.patient_thickness_mm.clone() };
    let specimen = sources::prepare_specimen(&args.exercise, bundle, &patient)?;
    for unsound in soundness::find_unsound_ruptures(&documents::spec_along_path(
        specimen.spec().axial.clone(),
        bundle.exercise.angle_deg,
    )) {
        if bundle.scene.is_coupled() {
            return Err(Failure::refused(&args.exercise, SpecimenError::Unsound(unsound)));
        }
        output::print_warning(format_args!("{}: unsound scene: {unsound}", args.exercise.display()));
    }
    let source = args.operator.source(bundle, args.seed)?;
    let clock = Clock { tick_hz: session.tick_hz, time_limit_s: bundle.exercise.time_limit_s };
    let mut watched = WatchedSource::new(source, &clock);
    let mut file = NewFile::create(&args.out, args.force)?;
    let mut writer = maker::begin_recording(file.file(), session, bundle, &args.out)?;
    let simulated = simulate::simulate(&specimen, &mut watched, &mut writer, &clock)
        .and_then(|simulated| writer.finish().map(|_| simulated))
        .map_err(|error| Failure::work(format_args!("{}: {error}", args.out.display())))?;
    file.keep()?;
    Ok(simulated)
}

fn session(args: &SimulateArgs, bundle: &ExerciseBundle) -> Session {
    let maker = Maker {
        device: &args.operator.device(),
        device_max_force_n: f64::INFINITY,
        seed: args.seed,
        tick_hz: f64::from(args.tick_hz),
    };
    let session = maker.session(bundle);
    Session {
        session_id: args.session_id.unwrap_or(session.session_id),
        trainee: args.trainee.clone(),
        started_at: args.started_at.unwrap_or(session.started_at),
        ..session
    }
}

fn report(summary: &SimulationSummary) -> Outcome {
    let SimulationSummary { recording, session_id, duration_s, ruptures, wall_s, times_real_time, .. } = summary;
    let megabytes = summary.bytes as f64 * 1e-6;
    output::print_line(format_args!(
        "{recording}: {duration_s:.2} s simulated in {wall_s:.2} s ({times_real_time:.0} × real time), \
         {ruptures} ruptures, {megabytes:.2} MB, session {session_id}"
    ))
}

/// A start that fits the recording's clock: Unix nanoseconds, unsigned, 64 bit.
fn start(text: &str) -> Result<OffsetDateTime, String> {
    let start = OffsetDateTime::parse(text, &Rfc3339).map_err(|error| format!("{error}; RFC 3339 is allowed"))?;
    let start = start.to_offset(UtcOffset::UTC);
    match start.year() {
        1970..=2500 => Ok(start),
        year => Err(format!("year {year}; 1970 to 2500 is allowed")),
    }
}

/// A pseudonym of a form that no name, address or sentence has.
pub fn pseudonym(text: &str) -> Result<String, String> {
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    match text.len() <= 64 && text.chars().all(allowed) {
        true => Ok(text.to_owned()),
        false => Err("up to 64 letters, digits and -_. are allowed: a pseudonym, never a name".to_owned()),
    }
}
