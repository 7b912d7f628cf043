//! `stylet simulate`: an attempt without a window, faster than real time.

use std::fs;
use std::path::PathBuf;

use assessment::staging::{self, Staging};
use attempt::HandChoice;
use attempt::simulate::Simulated;
use clap::builder::RangedU64ValueParser;
use documents::ExerciseBundle;
use recording::Session;
use serde::Serialize;
use time::OffsetDateTime;
use uuid::Uuid;

use crate::exit::{Failure, Outcome};
use crate::maker::Maker;
use crate::motion::WatchedSource;
use crate::new_file::NewFile;
use crate::{clock, output};

/// Let a virtual operator perform an exercise and record it
///
/// The seed determines the patient and the operator's hand. The same seed gives the same file
/// except for the session's identifier and start time, which --session-id and --started-at set. The
/// recording is written to a temporary file and renamed when it is complete.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    stylet simulate exercise.toml --operator expert --seed 7 --out attempt.mcap\n  \
    stylet simulate exercise.toml --operator constant:2 --out slow.mcap")]
pub struct SimulateArgs {
    /// The exercise
    #[arg(value_name = "EXERCISE.toml")]
    exercise: PathBuf,
    /// Source of the motion: novice, intermediate, expert, constant:MM_S (a stiff hand at that
    /// speed), or a CSV file with t_s and either x_m along the planned axis or px_m, py_m, pz_m and
    /// optionally qx, qy, qz, qw
    #[arg(long, value_name = "NAME|constant:MM_S|FILE.csv", default_value = "expert")]
    operator: HandChoice,
    /// Seed of the patient and the operator's hand
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
    /// Start time of the attempt, for example 2026-01-31T09:00:00Z [default: now]
    #[arg(long, value_name = "RFC3339", value_parser = staging::read_start)]
    started_at: Option<OffsetDateTime>,
    /// Servo rate, in Hz, 100 to 10000
    #[arg(long, value_name = "HZ", default_value_t = 1000, value_parser = RangedU64ValueParser::<u32>::new().range(staging::TICK_HZ_ALLOWED))]
    tick_hz: u32,
    /// Pseudonym of the trainee, never a real name: up to 64 letters, digits and -_.
    #[arg(long, value_name = "PSEUDONYM", default_value = "", hide_default_value = true, value_parser = staging::read_pseudonym)]
    trainee: String,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Summary of an attempt.
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
    /// Time from the start of the command to the first tick.
    prepared_s: f64,
    wall_s: f64,
    times_real_time: f64,
}

/// Runs the command.
pub fn run(args: &SimulateArgs) -> Outcome {
    let started = clock::instant();
    let bundle = ExerciseBundle::read(&args.exercise)?;
    let session = session(args, &bundle);
    let staging = Staging::new(&bundle, &session).map_err(|error| Failure::refused(&args.exercise, error))?;
    let prepared_s = started.elapsed().as_secs_f64();
    let simulated = record(args, &bundle, &staging)?;
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
        prepared_s,
        wall_s,
        times_real_time: simulated.duration_s / wall_s,
    };
    match args.json {
        true => output::print_json(&summary),
        false => report(&summary),
    }
}

/// Simulates the attempt and writes it to a temporary file until it is complete on disk.
fn record(args: &SimulateArgs, bundle: &ExerciseBundle, staging: &Staging<'_>) -> Result<Simulated, Failure> {
    for unsound in staging.unsound() {
        output::print_warning(format_args!("{}: unsound scene: {unsound}", args.exercise.display()));
    }
    let source = args.operator.source(&bundle.plan(), args.seed)?;
    let mut watched = WatchedSource::new(source, &staging.clock());
    let mut file = NewFile::create(&args.out, args.force)?;
    let simulated = staging
        .record(&mut watched, file.file())
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
    let SimulationSummary { recording, session_id, duration_s, ruptures, prepared_s, wall_s, times_real_time, .. } =
        summary;
    let megabytes = summary.bytes as f64 * 1e-6;
    output::print_line(format_args!(
        "{recording}: {duration_s:.2} s simulated in {wall_s:.2} s ({times_real_time:.0} × real time; preparing took {prepared_s:.2} s), \
         {ruptures} ruptures, {megabytes:.2} MB, session {session_id}"
    ))
}
