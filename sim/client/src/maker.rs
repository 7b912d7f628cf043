//! An attempt at an exercise, headless: who moves, on which patient, into which file.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use assessment::attachments;
use attempt::simulate::MotionSource;
use documents::{ExerciseBundle, Patient};
use law::Judging;
use law::operator::{Operator, Skill};
use recording::write::SceneDrawing;
use recording::{Session, Writer};

use crate::clock;
use crate::exit::Failure;
use crate::motion::Playback;

/// Who moves the needle.
#[derive(Clone, Debug, PartialEq)]
pub enum HandChoice {
    /// A virtual operator of a preset, by its name.
    Preset(&'static str, Skill),
    /// A perfectly stiff hand at a constant speed, in mm/s.
    Constant(f64),
    /// Motion from a CSV file.
    File(PathBuf),
}

impl FromStr for HandChoice {
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

impl HandChoice {
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
    pub fn source(&self, bundle: &ExerciseBundle, seed: u64) -> Result<Box<dyn MotionSource>, Failure> {
        let plan = bundle.plan();
        Ok(match self {
            Self::Preset(_, skill) => Box::new(Operator::skilled(skill, &plan, seed)),
            Self::Constant(mm_per_s) => Box::new(Operator::constant(mm_per_s * 1e-3, &plan)),
            Self::File(path) => Box::new(Playback::read(path, &plan)?),
        })
    }
}

/// On what an attempt is made.
pub struct Maker<'a> {
    /// The device's name.
    pub device: &'a str,
    /// The device's largest force, in N; infinite for an operator of a simulation.
    pub device_max_force_n: f64,
    /// Draws the patient and the operator's hand.
    pub seed: u64,
    /// Servo rate, in Hz.
    pub tick_hz: f64,
}

impl Maker<'_> {
    /// A session that starts now, of nobody.
    pub fn session(&self, bundle: &ExerciseBundle) -> Session {
        Session {
            session_id: clock::new_session_id(),
            exercise_id: bundle.exercise.id.clone(),
            exercise_sha256: bundle.exercise.sha256.clone(),
            scene_sha256: bundle.scene.sha256.clone(),
            simulator_version: env!("CARGO_PKG_VERSION").to_owned(),
            git: env!("STYLET_GIT_REVISION").to_owned(),
            device: self.device.to_owned(),
            device_max_force_n: self.device_max_force_n,
            law: bundle.scene.law,
            judging: Judging::default(),
            tick_hz: self.tick_hz,
            seed: self.seed,
            trainee: String::new(),
            started_at: clock::now(),
            patient_thickness_mm: Patient::draw(&bundle.scene, self.seed).thickness_mm,
        }
    }
}

/// Starts the recording of an attempt: metadata, documents and picture first.
///
/// # Errors
/// When the disk refuses.
pub fn begin_recording<W: Write>(
    file: W,
    session: &Session,
    bundle: &ExerciseBundle,
    path: &Path,
) -> Result<Writer<BufWriter<W>>, Failure> {
    let patient = Patient { thickness_mm: session.patient_thickness_mm.clone() };
    let drawing =
        SceneDrawing::from_spec(&bundle.scene.puncture_spec(&patient), bundle.scene.needle.diameter_mm * 0.5e-3);
    Writer::create(BufWriter::new(file), session, &attachments(bundle), &drawing)
        .map_err(|error| Failure::work(format_args!("{}: {error}", path.display())))
}
