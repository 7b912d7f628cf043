//! Sources of motion in a simulation, by name.

use std::path::PathBuf;
use std::str::FromStr;

use law::operator::{Operator, Plan, Skill};

use crate::playback::Playback;
use crate::simulate::MotionSource;
use crate::trajectory::TrajectoryError;

/// A source of motion.
#[derive(Clone, Debug, PartialEq)]
pub enum HandChoice {
    /// A virtual operator with a preset of skill, by its name.
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
                None => Err("allowed: novice, intermediate, expert, constant:MM_S or a file ending in .csv".to_owned()),
            },
        }
    }
}

fn constant(speed: &str) -> Result<f64, String> {
    match speed.parse::<f64>() {
        Ok(mm_per_s) if (0.01..=1000.0).contains(&mm_per_s) => Ok(mm_per_s),
        _ => Err(format!("speed = {speed} mm/s; allowed: 0.01 mm/s to 1000 mm/s")),
    }
}

impl HandChoice {
    /// Returns the name of the device, as stored in the recording.
    pub fn device(&self) -> String {
        match self {
            Self::Preset(name, _) => format!("operator:{name}"),
            Self::Constant(mm_per_s) => format!("operator:constant:{mm_per_s}"),
            Self::File(_) => "operator:file".to_owned(),
        }
    }

    /// Creates the source of motion for an exercise's plan.
    ///
    /// # Errors
    /// If its file is rejected.
    pub fn source(&self, plan: &Plan, seed: u64) -> Result<Box<dyn MotionSource>, TrajectoryError> {
        Ok(match self {
            Self::Preset(_, skill) => Box::new(Operator::skilled(skill, plan, seed)),
            Self::Constant(mm_per_s) => Box::new(Operator::constant(mm_per_s * 1e-3, plan)),
            Self::File(path) => Box::new(Playback::read(path, plan)?),
        })
    }
}
