//! `stylet.simulate`: an attempt without a window.

use std::path::PathBuf;

use assessment::staging::{AttemptMaker, Staging, TICK_HZ_ALLOWED, read_pseudonym, read_start};
use attempt::HandChoice;
use attempt::playback::Playback;
use attempt::simulate::MotionSource;
use attempt::trajectory::NumberColumn;
use documents::ExerciseBundle;
use pyo3::prelude::*;
use recording::{Recording, Session};
use uuid::Uuid;

use crate::clock;
use crate::errors::{refuse_file, refuse_input, refuse_trajectory};
use crate::force::read_column;
use crate::reading::{NativeRecording, read_exercise, refuse_recording};

/// Names and units of a motion's columns.
const MOTION_COLUMNS: [(&str, &str); 8] = [
    ("motion[:, 0]", " s"),
    ("motion[:, 1]", " m"),
    ("motion[:, 2]", " m"),
    ("motion[:, 3]", " m"),
    ("motion[:, 4]", ""),
    ("motion[:, 5]", ""),
    ("motion[:, 6]", ""),
    ("motion[:, 7]", ""),
];

/// Device name in the recording of a motion from memory.
const MOTION_DEVICE: &str = "operator:array";

/// Parameters of a simulated attempt.
#[derive(FromPyObject)]
pub struct SimulationWish {
    operator: Option<String>,
    seed: u64,
    tick_hz: u64,
    session_id: Option<String>,
    started_at: Option<String>,
    trainee: String,
}

/// The hand that moves the needle.
enum SimulatedHand {
    Named(HandChoice),
    /// A motion from memory, one vector for each column.
    Moved(Vec<Vec<f64>>),
}

/// Simulates an exercise performed by a virtual hand. `motion` contains the columns of a motion if
/// `wish.operator` is `None`.
#[pyfunction]
pub fn simulate_exercise(
    py: Python<'_>,
    path: PathBuf,
    wish: SimulationWish,
    motion: Vec<Bound<'_, PyAny>>,
) -> PyResult<NativeRecording> {
    let hand = match &wish.operator {
        Some(name) => SimulatedHand::Named(
            name.parse().map_err(|allowed| refuse_input(format_args!("operator = '{name}'; {allowed}")))?,
        ),
        None => SimulatedHand::Moved(motion.iter().map(read_column).collect::<PyResult<_>>()?),
    };
    py.detach(|| {
        let name = path.display().to_string();
        let bundle = read_exercise(&path)?;
        let session = begin_session(&wish, &hand, &bundle)?;
        let staging = Staging::new(&bundle, &session).map_err(|error| refuse_file(&name, error))?;
        let mut source = take_hand(&hand, &bundle, wish.seed)?;
        let mut file = Vec::new();
        staging.record(source.as_mut(), &mut file).map_err(|error| refuse_file(&name, error))?;
        let recording = Recording::read(file.as_slice()).map_err(|error| refuse_recording(&name, &error))?;
        let unsound = staging.unsound().iter().map(ToString::to_string).collect();
        Ok(NativeRecording { name: "simulated".to_owned(), recording, file: Some(file), unsound })
    })
}

fn begin_session(wish: &SimulationWish, hand: &SimulatedHand, bundle: &ExerciseBundle) -> PyResult<Session> {
    let refuse =
        |field: &str, value: &str, allowed: String| refuse_input(format_args!("{field} = '{value}'; {allowed}"));
    if !TICK_HZ_ALLOWED.contains(&wish.tick_hz) {
        let (least, most) = (TICK_HZ_ALLOWED.start(), TICK_HZ_ALLOWED.end());
        let why = format!("tick_hz = {} Hz; allowed: {least} Hz to {most} Hz", wish.tick_hz);
        return Err(refuse_input(why));
    }
    let session_id = match &wish.session_id {
        Some(id) => {
            Uuid::parse_str(id).map_err(|error| refuse("session_id", id, format!("{error}; allowed: a UUID")))?
        }
        None => clock::new_session_id(),
    };
    let started_at = match &wish.started_at {
        Some(start) => read_start(start).map_err(|allowed| refuse("started_at", start, allowed))?,
        None => clock::now(),
    };
    let trainee = read_pseudonym(&wish.trainee).map_err(|allowed| refuse("trainee", &wish.trainee, allowed))?;
    let device = match hand {
        SimulatedHand::Named(hand) => hand.device(),
        SimulatedHand::Moved(_) => MOTION_DEVICE.to_owned(),
    };
    let maker = AttemptMaker {
        device: &device,
        device_max_force_n: f64::INFINITY,
        seed: wish.seed,
        tick_hz: wish.tick_hz as f64,
        version: env!("CARGO_PKG_VERSION"),
        git: env!("STYLET_GIT_REVISION"),
    };
    Ok(Session { trainee, ..maker.session(bundle, session_id, started_at) })
}

fn take_hand(hand: &SimulatedHand, bundle: &ExerciseBundle, seed: u64) -> PyResult<Box<dyn MotionSource>> {
    let plan = bundle.plan();
    let source = match hand {
        SimulatedHand::Named(hand) => hand.source(&plan, seed),
        SimulatedHand::Moved(columns) => {
            let columns = MOTION_COLUMNS.iter().zip(columns);
            let columns: Vec<_> = columns.map(|((name, unit), values)| NumberColumn { name, unit, values }).collect();
            Playback::of_columns(&columns, &plan).map(|playback| Box::new(playback) as Box<dyn MotionSource>)
        }
    };
    source.map_err(|error| refuse_trajectory(&error))
}
