//! What is measured: the shipped scenes and an exercise, built into the program so that every copy measures the same.

use mechanics::axial::AxialSpec;
use scene::{ExerciseBundle, Patient, Scene};

use crate::exit::Failure;

const EXERCISE: &str = include_str!("../../../../../curricula/lower-back-basics/3-reach-the-muscle.toml");
const PAPER: &str = include_str!("../../../../../curricula/scenes/lower-back-paper.toml");
const TRAINING: &str = include_str!("../../../../../curricula/scenes/lower-back-training.toml");

/// The paper's scene and the training scene, each with the exercise that is measured.
///
/// # Errors
/// When the documents built in are refused, which a test would have shown.
pub fn both() -> Result<[ExerciseBundle; 2], Failure> {
    Ok([bundle(PAPER)?, training()?])
}

/// The training scene with the exercise that is measured.
///
/// # Errors
/// When the documents built in are refused.
pub fn training() -> Result<ExerciseBundle, Failure> {
    bundle(TRAINING)
}

/// The axial law of a scene's nominal patient.
pub fn axial(scene: &Scene) -> AxialSpec {
    scene.puncture_spec(&Patient::nominal(scene)).axial
}

fn bundle(scene: &str) -> Result<ExerciseBundle, Failure> {
    Ok(ExerciseBundle::from_parts(EXERCISE.as_bytes(), scene.as_bytes(), &[])?)
}
