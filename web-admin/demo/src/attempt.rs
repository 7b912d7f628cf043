//! Attempts of the demonstration: a virtual operator performs an exercise, recorded as by a
//! station.

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
use routes_base::AppState;
use tissue::Specimen;
use tokio::task::JoinSet;

/// Servo rate of the demonstration's station, in Hz.
const TICK_HZ: f64 = 1000.0;

/// An attempt to perform.
#[derive(Clone, Debug)]
pub struct AttemptTask {
    /// The exercise.
    pub bundle: ExerciseBundle,
    /// Skill of the operator.
    pub skill: Skill,
    /// Seed of the patient.
    pub seed: u64,
    /// Seeds of the operator's hand: person, day and attempt.
    pub occasion: Occasion,
    /// Pseudonym of the trainee.
    pub trainee: String,
    /// Start time.
    pub at: Moment,
}

/// A recording that has not been uploaded yet.
#[derive(Debug)]
pub struct MadeRecording<T> {
    /// Author of the attempt.
    pub by: T,
    /// Path of the file.
    pub path: PathBuf,
    /// End of the attempt.
    pub ends: Moment,
}

/// Performs attempts on all cores. Returns their recordings, sorted by time.
///
/// # Errors
/// Fails if the mechanics reject an exercise, or a file cannot be written.
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

/// Performs an attempt and writes its recording. Returns the duration, in s. Blocks.
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
