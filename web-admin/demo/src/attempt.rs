//! Attempts of the demonstration: a virtual operator at an exercise, recorded as a station would.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use assessment::attachments;
use attempt::simulate::{Clock, simulate};
use documents::{ExerciseBundle, Patient};
use law::operator::{Occasion, Operator, Skill};
use model::{Moment, new_id};
use recording::write::SceneDrawing;
use recording::{Session, Writer};
use tissue::Specimen;
use tokio::task::JoinSet;

use routes_base::AppState;

/// Servo rate of the demonstration's station, in Hz.
const TICK_HZ: f64 = 1000.0;

/// What is to be tried.
#[derive(Clone, Debug)]
pub struct AttemptTask {
    /// The exercise.
    pub bundle: ExerciseBundle,
    /// How well.
    pub skill: Skill,
    /// Draws the patient.
    pub seed: u64,
    /// Draws the hand: whose it is, on which day, at which attempt.
    pub occasion: Occasion,
    /// Pseudonym of the trainee.
    pub trainee: String,
    /// When it begins.
    pub at: Moment,
}

/// A recording that waits to be taken in.
#[derive(Debug)]
pub struct MadeRecording<T> {
    /// Who made it.
    pub by: T,
    /// Where it is.
    pub path: PathBuf,
    /// When the attempt was over.
    pub ends: Moment,
}

/// Performs tasks on every core. Returns their recordings in order of time.
///
/// # Errors
/// When an exercise is refused by the mechanics, or the disk refuses.
pub async fn perform_demo_attempts<T: Send + 'static>(
    state: &AppState,
    tasks: Vec<(T, AttemptTask)>,
) -> anyhow::Result<Vec<MadeRecording<T>>> {
    let mut stations = JoinSet::new();
    for (by, task) in tasks {
        let path = state.config.uploads_dir().join(format!("demonstration-{}.part", new_id(task.at)));
        stations.spawn_blocking(move || {
            let duration_s = perform_demo_attempt(&task, &path)?;
            anyhow::Ok(MadeRecording { by, path, ends: task.at.plus_s(duration_s.ceil() as i64) })
        });
    }
    let made: anyhow::Result<Vec<_>> = stations.join_all().await.into_iter().collect();
    let mut made = made?;
    made.sort_by_key(|recording| recording.ends);
    Ok(made)
}

/// Performs a task and writes the recording. Returns its length, in s. Blocks.
fn perform_demo_attempt(task: &AttemptTask, path: &Path) -> anyhow::Result<f64> {
    let ExerciseBundle { exercise, scene, .. } = &task.bundle;
    let patient = Patient::draw(scene, task.seed);
    let spec = task.bundle.specimen_spec(&patient);
    let drawing = SceneDrawing::from_spec(&spec.puncture, scene.needle.diameter_mm * 0.5e-3);
    let params = Specimen::new(spec)?;
    let session = make_demo_session(task, patient);
    let mut operator = Operator::on(&task.skill, &task.bundle.plan(), &task.occasion);
    let clock = Clock { tick_hz: TICK_HZ, time_limit_s: exercise.time_limit_s };
    let file = BufWriter::new(File::create_new(path)?);
    let mut writer = Writer::create(file, &session, &attachments(&task.bundle), &drawing)?;
    let simulated = simulate(&params, &mut operator, &mut writer, &clock)?;
    writer.finish()?.into_inner()?.sync_all()?;
    Ok(simulated.duration_s)
}

fn make_demo_session(task: &AttemptTask, patient: Patient) -> Session {
    Session {
        session_id: new_id(task.at),
        exercise_id: task.bundle.exercise.id.clone(),
        exercise_sha256: task.bundle.exercise.sha256.clone(),
        scene_sha256: task.bundle.scene.sha256.clone(),
        simulator_version: env!("CARGO_PKG_VERSION").to_owned(),
        git: String::new(),
        device: "operator:demonstration".to_owned(),
        device_max_force_n: f64::INFINITY,
        law: task.bundle.scene.law,
        judging: law::Judging::default(),
        tick_hz: TICK_HZ,
        seed: task.seed,
        trainee: task.trainee.clone(),
        started_at: task.at.to_utc(),
        patient_thickness_mm: patient.thickness_mm,
    }
}
