//! Prepares an exercise for recording on the patient of a session: the steps of `stylet simulate`
//! between document and file.

use std::io::{BufWriter, Write};
use std::ops::RangeInclusive;

use attempt::simulate::{Clock, MotionSource, Simulated, simulate};
use documents::{ExerciseBundle, Patient};
use law::Judging;
use law::soundness::{self, Unsound};
use recording::error::WriteError;
use recording::write::SceneDrawing;
use recording::{Session, Writer};
use time::format_description::well_known::Rfc3339;
use time::{OffsetDateTime, UtcOffset};
use tissue::{Specimen, SpecimenError};
use uuid::Uuid;

use crate::attached::attachments;

/// Allowed servo rates of a simulation, in Hz.
pub const TICK_HZ_ALLOWED: RangeInclusive<u64> = 100..=10_000;

/// Device, seed and program of an attempt.
#[derive(Clone, Copy, Debug)]
pub struct AttemptMaker<'a> {
    /// Device name.
    pub device: &'a str,
    /// The device's maximum force, in N; infinite for a simulated operator.
    pub device_max_force_n: f64,
    /// Seed of the patient and the operator's hand.
    pub seed: u64,
    /// Servo rate, in Hz.
    pub tick_hz: f64,
    /// Version of the program.
    pub version: &'a str,
    /// Commit that the program was built from; empty if unknown.
    pub git: &'a str,
}

impl AttemptMaker<'_> {
    /// Creates a session without a trainee that starts at `started_at`.
    #[must_use]
    pub fn session(&self, bundle: &ExerciseBundle, session_id: Uuid, started_at: OffsetDateTime) -> Session {
        Session {
            session_id,
            exercise_id: bundle.exercise.id.clone(),
            exercise_sha256: bundle.exercise.sha256.clone(),
            scene_sha256: bundle.scene.sha256.clone(),
            simulator_version: self.version.to_owned(),
            git: self.git.to_owned(),
            device: self.device.to_owned(),
            device_max_force_n: self.device_max_force_n,
            law: bundle.scene.law,
            judging: Judging::default(),
            tick_hz: self.tick_hz,
            seed: self.seed,
            trainee: String::new(),
            started_at,
            patient_thickness_mm: Patient::draw(&bundle.scene, self.seed).thickness_mm,
        }
    }
}

/// Starts the recording of an attempt: writes metadata, documents and drawing.
///
/// # Errors
/// On an I/O error.
pub fn begin_recording<W: Write>(
    file: W,
    session: &Session,
    bundle: &ExerciseBundle,
) -> Result<Writer<BufWriter<W>>, WriteError> {
    let patient = Patient { thickness_mm: session.patient_thickness_mm.clone() };
    let drawing =
        SceneDrawing::from_spec(&bundle.scene.puncture_spec(&patient), bundle.scene.needle.diameter_mm * 0.5e-3);
    Writer::create(BufWriter::new(file), session, &attachments(bundle), &drawing)
}

/// An exercise and the specimen of a session.
#[derive(Debug)]
pub struct Staging<'a> {
    bundle: &'a ExerciseBundle,
    session: &'a Session,
    specimen: Specimen,
    unsound: Vec<Unsound>,
}

impl<'a> Staging<'a> {
    /// Builds the specimen for the patient of a session.
    ///
    /// # Errors
    /// If the scene cannot be simulated, or if the field would set stiffnesses with which a rupture
    /// creates energy.
    pub fn new(bundle: &'a ExerciseBundle, session: &'a Session) -> Result<Self, SpecimenError> {
        let patient = Patient { thickness_mm: session.patient_thickness_mm.clone() };
        let specimen = Specimen::new(bundle.specimen_spec(&patient))?;
        let path = documents::spec_along_path(specimen.spec().axial.clone(), &bundle.exercise.incidence());
        let unsound = soundness::find_unsound_ruptures(&path);
        match unsound.first() {
            Some(first) if bundle.scene.is_coupled() => Err(SpecimenError::Unsound(first.clone())),
            _ => Ok(Self { bundle, session, specimen, unsound }),
        }
    }

    /// Returns the ruptures that would create energy with the scene's own stiffnesses.
    #[must_use]
    pub fn unsound(&self) -> &[Unsound] {
        &self.unsound
    }

    /// Returns servo rate and time limit.
    #[must_use]
    pub fn clock(&self) -> Clock {
        Clock { tick_hz: self.session.tick_hz, time_limit_s: self.bundle.exercise.time_limit_s }
    }

    /// Simulates a hand, faster than real time, and records the attempt to a file.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn record<W: Write + Send>(&self, hand: &mut dyn MotionSource, file: W) -> Result<Simulated, WriteError> {
        let mut writer = begin_recording(file, self.session, self.bundle)?;
        let simulated = simulate(&self.specimen, hand, &mut writer, &self.clock())?;
        writer.finish()?;
        Ok(simulated)
    }
}

/// Parses a start time that the recording's clock can represent: Unix nanoseconds, unsigned, 64
/// bit.
///
/// # Errors
/// The allowed values.
pub fn read_start(text: &str) -> Result<OffsetDateTime, String> {
    let start =
        OffsetDateTime::parse(text, &Rfc3339).map_err(|error| format!("{error}; allowed: a time as in RFC 3339"))?;
    let start = start.to_offset(UtcOffset::UTC);
    match start.year() {
        1970..=2500 => Ok(start),
        year => Err(format!("year {year}; allowed: 1970 to 2500")),
    }
}

/// Parses a pseudonym; its format excludes names, addresses and sentences.
///
/// # Errors
/// The allowed values.
pub fn read_pseudonym(text: &str) -> Result<String, String> {
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    match text.len() <= 64 && text.chars().all(allowed) {
        true => Ok(text.to_owned()),
        false => Err("allowed: up to 64 letters, digits and -_., a pseudonym and never a name".to_owned()),
    }
}
