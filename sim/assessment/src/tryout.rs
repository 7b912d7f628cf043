//! Virtual attempts in memory: simulated and judged without a file.

use attempt::simulate::{MotionSource, rehearse};
use documents::{ExerciseBundle, Patient};
use recording::{Recording, Session};
use tissue::Specimen;

use crate::error::AssessError;
use crate::score::{Assessment, assess};

/// An exercise on a patient, for simulated hands.
#[derive(Debug)]
pub struct Tryout<'a> {
    /// The exercise.
    pub bundle: &'a ExerciseBundle,
    specimen: Specimen,
    patient: Patient,
}

impl<'a> Tryout<'a> {
    /// Builds the specimen. A field that only serves the picture is left out: neither force nor
    /// score depends on it.
    ///
    /// # Errors
    /// If the scene cannot be simulated.
    pub fn new(bundle: &'a ExerciseBundle, patient: Patient) -> Result<Self, AssessError> {
        let mut spec = bundle.specimen_spec(&patient);
        if !bundle.scene.is_coupled() {
            spec.tissue = None;
        }
        let specimen = Specimen::new(spec).map_err(|error| AssessError::Document(error.to_string()))?;
        Ok(Self { bundle, specimen, patient })
    }

    /// Returns the specimen.
    #[must_use]
    pub fn specimen(&self) -> &Specimen {
        &self.specimen
    }

    /// Simulates a hand at 1 kHz until it is done or the exercise's time limit is reached.
    #[must_use]
    pub fn perform(&self, hand: &mut dyn MotionSource) -> Recording {
        let session = Session::in_memory(self.bundle.scene.law, self.patient.thickness_mm.clone());
        rehearse(&self.specimen, hand, session, self.bundle.exercise.time_limit_s)
    }

    /// Judges an attempt by the exercise.
    ///
    /// # Errors
    /// If it cannot be judged.
    pub fn judge(&self, recording: &Recording) -> Result<Assessment, AssessError> {
        assess(recording, self.bundle)
    }
}
