//! An attempt at an exercise, headless: who moves, on which patient, into which file.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use mechanics::operator::{Operator, Plan, Skill};
use recording::session::{EXERCISE_ATTACHMENT, MESH_PREFIX, SCENE_ATTACHMENT};
use recording::simulate::MotionSource;
use recording::write::SceneDrawing;
use recording::{Attachment, Session, Writer};
use scene::{Exercise, ExerciseBundle, Patient, Scene};

use crate::exit::Failure;
use crate::motion::Playback;

/// Distance above the skin that a virtual operator starts from, in m.
const APPROACH_M: f64 = 0.010;
/// Time that a virtual operator holds at the target before it withdraws, in s.
const HOLD_S: f64 = 2.0;

/// Who moves the needle.
#[derive(Clone, Debug, PartialEq)]
pub enum Hand {
    /// A virtual operator of a preset, by its name.
    Preset(&'static str, Skill),
    /// A perfectly stiff hand at a constant speed, in mm/s.
    Constant(f64),
    /// Motion from a CSV file.
    File(PathBuf),
}

impl FromStr for Hand {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "novice" => Ok(Self::Preset("novice", Skill::novice())),
            "intermediate" => Ok(Self::Preset("intermediate", Skill::intermediate())),
            "expert" => Ok(Self::Preset("expert", Skill::expert())),
            _ => match text.strip_prefix("constant:") {
                Some(speed) => constant(speed).map(Self::Constant),
                None if text.to_ascii_lowercase().ends_with(".csv") => Ok(Self::File(text.into())),
                None => {
                    Err("novice, intermediate, expert, constant:MM_S or a file ending in .csv is allowed".to_owned())
                }
            },
        }
    }
}

fn constant(speed: &str) -> Result<f64, String> {
    match speed.parse::<f64>() {
        Ok(mm_per_s) if (0.01..=1000.0).contains(&mm_per_s) => Ok(mm_per_s),
        _ => Err(format!("speed = {speed} mm/s; 0.01 mm/s to 1000 mm/s is allowed")),
    }
}

impl Hand {
    /// The hand's name as the recording keeps it.
    pub fn device(&self) -> String {
        match self {
            Self::Preset(name, _) => format!("operator:{name}"),
            Self::Constant(mm_per_s) => format!("operator:constant:{mm_per_s}"),
            Self::File(_) => "operator:file".to_owned(),
        }
    }

    /// The hand at work on an exercise.
    ///
    /// # Errors
    /// When its file is refused.
    pub fn source(&self, exercise: &Exercise, seed: u64) -> Result<Box<dyn MotionSource>, Failure> {
        let plan = plan(exercise);
        Ok(match self {
            Self::Preset(_, skill) => Box::new(Operator::skilled(skill, &plan, seed)),
            Self::Constant(mm_per_s) => Box::new(Operator::constant(mm_per_s * 1e-3, &plan)),
            Self::File(path) => Box::new(Playback::read(path, &plan)?),
        })
    }
}

/// What a virtual operator intends in an exercise.
pub fn plan(exercise: &Exercise) -> Plan {
    Plan {
        entry_m: exercise.entry_m(),
        axis: exercise.axis(),
        target_x_m: exercise.target_depth_mm * 1e-3,
        approach_m: APPROACH_M,
        hold_s: HOLD_S,
    }
}

/// Starts the recording of an attempt: metadata, documents and picture first.
///
/// # Errors
/// When the disk refuses.
pub fn writer<'f>(
    file: &'f mut File,
    session: &Session,
    bundle: &ExerciseBundle,
    path: &Path,
) -> Result<Writer<BufWriter<&'f mut File>>, Failure> {
    let patient = Patient { thickness_mm: session.patient_thickness_mm.clone() };
    Writer::create(BufWriter::new(file), session, &attachments(bundle), &drawing(&bundle.scene, &patient))
        .map_err(|error| Failure::work(format_args!("{}: {error}", path.display())))
}

/// Every document that the attempt depends on, byte for byte.
fn attachments(bundle: &ExerciseBundle) -> Vec<Attachment> {
    let attachment = |name: String, media_type: &str, data: &[u8]| Attachment {
        name,
        media_type: media_type.to_owned(),
        data: data.to_vec(),
    };
    let documents = [(EXERCISE_ATTACHMENT, &bundle.exercise_bytes), (SCENE_ATTACHMENT, &bundle.scene_bytes)];
    let meshes = bundle.meshes.iter();
    documents
        .into_iter()
        .map(|(name, bytes)| attachment(name.to_owned(), "application/toml", bytes))
        .chain(meshes.map(|(name, bytes)| attachment(format!("{MESH_PREFIX}{name}"), "model/stl", bytes)))
        .collect()
}

/// What a viewer draws of a scene for a patient.
fn drawing(scene: &Scene, patient: &Patient) -> SceneDrawing {
    let layers = scene.layers.iter().zip(&patient.thickness_mm);
    SceneDrawing {
        layers: layers.map(|(layer, thickness_mm)| (layer.name.clone(), thickness_mm * 1e-3)).collect(),
        structures: scene.structures.iter().map(|structure| structure.spec.clone()).collect(),
        needle_length_m: scene.needle.length_mm * 1e-3,
        needle_radius_m: scene.needle.diameter_mm * 0.5e-3,
    }
}
