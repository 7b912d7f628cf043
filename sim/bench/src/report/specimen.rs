//! The measured scenes and exercises, embedded in the program so that every copy measures the same.

use ::recording::Session;
use documents::{ExerciseBundle, Patient, Scene};
use dossier::find_shipped_scene;
use law::axial::AxialSpec;
use time::OffsetDateTime;
use tissue::Specimen;
use uuid::Uuid;

use crate::error::BenchError;

const EXERCISE: &str = include_str!("../../../../curricula/lower-back-basics/3-reach-the-muscle.toml");
const MIDLINE: &str = include_str!("../../../../curricula/lumbar-epidural-on-a-body/1-midline.toml");

/// Every shipped exercise.
const EXERCISES: [&str; 18] = [
    include_str!("../../../../curricula/experiments/paper-insertion.toml"),
    include_str!("../../../../curricula/lower-back-basics/1-feel-the-layers.toml"),
    include_str!("../../../../curricula/lower-back-basics/2-stop-in-the-fat.toml"),
    EXERCISE,
    include_str!("../../../../curricula/lower-back-basics/4-thicker-needle.toml"),
    include_str!("../../../../curricula/lower-back-basics/5-oblique-approach.toml"),
    include_str!("../../../../curricula/lower-back-basics/6-avoid-the-vessel.toml"),
    include_str!("../../../../curricula/lower-back-basics/7-thick-fat.toml"),
    include_str!("../../../../curricula/lumbar-epidural/1-stop-in-the-epidural-space.toml"),
    MIDLINE,
    include_str!("../../../../curricula/lumbar-epidural-on-a-body/2-off-the-bone.toml"),
    include_str!("../../../../curricula/lumbar-epidural-on-a-body/3-paramedian.toml"),
    include_str!("../../../../curricula/lumbar-puncture/1-reach-the-fluid.toml"),
    include_str!("../../../../curricula/lumbar-puncture/2-pencil-point.toml"),
    include_str!("../../../../curricula/percutaneous-kidney-access/1-lower-pole.toml"),
    include_str!("../../../../curricula/percutaneous-kidney-access/2-under-x-rays.toml"),
    include_str!("../../../../curricula/laparoscopic-entry/1-veress-needle.toml"),
    include_str!("../../../../curricula/laparoscopic-entry/2-primary-trocar.toml"),
];

/// Reads the paper's scene and the training scene, each with the measured exercise.
///
/// # Errors
/// If the embedded documents are refused; a test excludes this.
pub fn read_both_exercises() -> Result<[ExerciseBundle; 2], BenchError> {
    Ok([bundle("lower-back-paper")?, read_training_exercise()?])
}

/// Reads the training scene with the measured exercise.
///
/// # Errors
/// If the embedded documents are refused.
pub fn read_training_exercise() -> Result<ExerciseBundle, BenchError> {
    bundle("lower-back-training")
}

/// Reads the scene with the most structures, which is the most expensive to draw, with the measured
/// exercise.
///
/// # Errors
/// If the embedded documents are refused.
pub fn read_anatomy_exercise() -> Result<ExerciseBundle, BenchError> {
    bundle("lower-back-vessel")
}

/// Reads a scene that is expanded from an anatomy, with its exercise.
///
/// # Errors
/// If the embedded documents are refused.
pub fn read_body_exercise() -> Result<ExerciseBundle, BenchError> {
    read_in_own_scene(MIDLINE)
}

/// Reads every shipped exercise with its scene.
///
/// # Errors
/// If an embedded document is refused.
pub fn read_shipped_exercises() -> Result<Vec<ExerciseBundle>, BenchError> {
    EXERCISES.into_iter().map(read_in_own_scene).collect()
}

/// Reads a shipped exercise with the scene that it names.
fn read_in_own_scene(text: &str) -> Result<ExerciseBundle, BenchError> {
    let file = text.lines().find_map(|line| line.strip_prefix("scene = \"../scenes/")?.strip_suffix(".toml\""));
    Ok(ExerciseBundle::from_texts(text, scene(file.unwrap_or_default())?)?)
}

/// Returns the text of a shipped scene.
fn scene(id: &str) -> Result<&'static str, BenchError> {
    find_shipped_scene(id).ok_or_else(|| BenchError::work(format_args!("{id} is not shipped")))
}

/// Returns the axial law of a scene's nominal patient.
pub fn nominal_axial_spec(scene: &Scene) -> AxialSpec {
    scene.axial_spec(&Patient::nominal(scene))
}

/// Builds the specimen of an exercise for the nominal patient of its scene.
///
/// # Errors
/// If the scene is refused.
pub fn make_nominal_specimen(bundle: &ExerciseBundle) -> Result<Specimen, BenchError> {
    Specimen::new(bundle.specimen_spec(&Patient::nominal(&bundle.scene))).map_err(BenchError::work)
}

/// Reads the measured exercise in a shipped scene.
fn bundle(id: &str) -> Result<ExerciseBundle, BenchError> {
    Ok(ExerciseBundle::from_parts(EXERCISE.as_bytes(), scene(id)?.as_bytes(), &[])?)
}

/// Returns the same session every time, at a tick rate in Hz: measurements must not depend on the
/// clock.
pub fn make_session(bundle: &ExerciseBundle, tick_hz: f64) -> Session {
    Session {
        session_id: Uuid::nil(),
        exercise_id: bundle.exercise.id.clone(),
        exercise_sha256: bundle.exercise.sha256.clone(),
        scene_sha256: bundle.scene.sha256.clone(),
        simulator_version: env!("CARGO_PKG_VERSION").to_owned(),
        git: String::new(),
        device: "operator:bench".to_owned(),
        device_max_force_n: f64::INFINITY,
        law: bundle.scene.law,
        judging: law::Judging::default(),
        tick_hz,
        seed: 0,
        trainee: String::new(),
        started_at: OffsetDateTime::UNIX_EPOCH,
        patient_thickness_mm: Patient::nominal(&bundle.scene).thickness_mm,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;
    use std::path::Path;

    use dossier::SHIPPED_SCENES;

    use super::*;

    #[test]
    fn every_shipped_scene_is_measured() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/scenes");
        let files = fs::read_dir(folder).expect("the shipped scenes").map(|entry| entry.expect("a file").path());
        let scenes = files.filter(|path| path.extension().is_some_and(|extension| extension == "toml"));
        let on_disk: BTreeSet<String> = scenes.map(|path| fs::read_to_string(path).expect("a scene")).collect();
        assert_eq!(on_disk, SHIPPED_SCENES.map(str::to_owned).into());
    }

    /// Returns the exercises of a folder by id, with the id of the scene that each names.
    fn on_disk(folder: &Path) -> BTreeSet<(String, String)> {
        let mut found = BTreeSet::new();
        for entry in fs::read_dir(folder).expect("the shipped documents") {
            let path = entry.expect("a file").path();
            if path.is_dir() {
                found.extend(on_disk(&path));
            } else if let Ok(bundle) = ExerciseBundle::read(&path) {
                found.insert((bundle.exercise.id, bundle.scene.id));
            }
        }
        found
    }

    #[test]
    fn every_shipped_exercise_is_measured_in_its_own_scene() {
        let bundles = read_shipped_exercises().expect("sound");
        let measured: BTreeSet<_> = bundles.into_iter().map(|bundle| (bundle.exercise.id, bundle.scene.id)).collect();
        assert_eq!(on_disk(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula")), measured);
    }
}
