//! Attempts in memory at an exercise: simulated, judged, and kept nowhere.

use attempt::simulate::{MotionSource, rehearse};
use documents::{ExerciseBundle, Patient};
use recording::{Recording, Session};
use tissue::Specimen;

use crate::error::AssessError;
use crate::score::{Assessment, assess};

/// An exercise on a patient, for hands to try.
#[derive(Debug)]
pub struct Tryout<'a> {
    /// The exercise.
    pub bundle: &'a ExerciseBundle,
    specimen: Specimen,
    patient: Patient,
}

impl<'a> Tryout<'a> {
    /// The field that only a picture shows is left out: no force and no score depends on it.
    ///
    /// # Errors
    /// When the scene cannot be simulated.
    pub fn new(bundle: &'a ExerciseBundle, patient: Patient) -> Result<Self, AssessError> {
        let mut spec = bundle.specimen_spec(&patient);
        if !bundle.scene.is_coupled() {
            spec.tissue = None;
        }
        let specimen = Specimen::new(spec).map_err(|error| AssessError::Document(error.to_string()))?;
        Ok(Self { bundle, specimen, patient })
    }

    /// What is punctured.
    #[must_use]
    pub fn specimen(&self) -> &Specimen {
        &self.specimen
    }

    /// Lets a hand make an attempt at 1 kHz, until it is done or the exercise's time is up.
    #[must_use]
    pub fn perform(&self, hand: &mut dyn MotionSource) -> Recording {
        let session = Session::in_memory(self.bundle.scene.law, self.patient.thickness_mm.clone());
        rehearse(&self.specimen, hand, session, self.bundle.exercise.time_limit_s)
    }

    /// Judges an attempt by the exercise.
    ///
    /// # Errors
    /// When it cannot be judged.
    pub fn judge(&self, recording: &Recording) -> Result<Assessment, AssessError> {
        assess(recording, self.bundle)
    }
}
