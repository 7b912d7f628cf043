//! Attempts in memory: simulated and judged, and written nowhere.

use std::path::Path;

use mechanics::puncture::PunctureParams;
use nalgebra::Vector3;
use recording::simulate::MotionSource;
use recording::tick::{Attempt, Input};
use recording::{Recording, Session};
use scene::{ExerciseBundle, Patient};

use crate::exit::Failure;

/// Rate of the simulation, in Hz.
pub const TICK_HZ: f64 = 1000.0;

/// The force law of an exercise in the file of a name, for a patient, without the field that only a picture shows.
///
/// # Errors
/// When the scene cannot be simulated.
pub fn params_of_law(file: &Path, bundle: &ExerciseBundle, patient: &Patient) -> Result<PunctureParams, Failure> {
    let mut spec = bundle.puncture_spec(patient);
    if !bundle.scene.is_coupled() {
        spec.tissue = None;
    }
    PunctureParams::new(spec).map_err(|error| Failure::refused(file, error))
}

/// Lets a hand make an attempt until it is done, or its time in s is up.
pub fn perform(params: &PunctureParams, session: Session, hand: &mut dyn MotionSource, time_limit_s: f64) -> Recording {
    let (attachments, samples, events) = (Vec::new(), Vec::new(), Vec::new());
    let (energies, tents) = (Vec::new(), Vec::new());
    let mut recording =
        Recording { session, attachments, samples, events, energies, tents, signature: None, complete: true };
    let mut tissue = Attempt::new(params);
    let mut force_n = Vector3::zeros();
    let mut t_s = 0.0;
    for i in 0..=(time_limit_s * TICK_HZ) as u64 {
        t_s = i as f64 / TICK_HZ;
        let motion = hand.step(if i == 0 { 0.0 } else { 1.0 / TICK_HZ }, &force_n);
        let tick = tissue.step(&Input::new(t_s, &motion));
        recording.samples.push(tick.sample);
        recording.events.extend(tick.events);
        force_n = tick.force_n;
        if motion.done {
            break;
        }
    }
    recording.energies.push(tissue.energy(t_s));
    recording
}
