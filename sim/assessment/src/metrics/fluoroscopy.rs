//! X-rays: time, dose and views. Measured where the exercise has a C-arm.

use nalgebra::Vector3;
use recording::{CArmControls, EventKind, Fluoroscopy, FluoroscopyPulse};

use super::MetricSheet;
use crate::absent::Absent;
use crate::attempt::{Attempt, Outcome};

/// Angle between two views from which they count as different, in degrees.
const ANOTHER_VIEW_DEG: f64 = 10.0;

pub(super) fn measure_fluoroscopy(attempt: &Attempt, sheet: &mut MetricSheet) {
    let Some(settings) = &attempt.bundle.exercise.fluoroscopy else { return };
    let Fluoroscopy { controls, pulses } = &attempt.recording.fluoroscopy;
    let used = if controls.is_empty() { Err(Absent::NoFluoroscopy) } else { Ok(settings) };
    let last = |of: fn(&FluoroscopyPulse) -> f64| used.map(|_| pulses.last().map_or(0.0, of));
    let by_pedal = || pulses.iter().filter(|pulse| !pulse.shot).count() as f64;
    sheet.put("fluoroscopy_time_s", used.map(|settings| by_pedal() / settings.pulses_per_s));
    sheet.put("fluoroscopy_shots", used.map(|_| pulses.iter().filter(|pulse| pulse.shot).count() as f64));
    sheet.put("kerma_mgy", last(|pulse| pulse.kerma_mgy));
    sheet.put("kerma_area_gycm2", last(|pulse| pulse.kerma_area_gycm2));
    sheet.put("mean_field_cm2", used.and_then(|_| mean_field_cm2(attempt)));
    sheet.put("views_before_skin", used.map(|_| count_views_before_skin(attempt)));
}

/// The pulses with the controls of the C-arm.
fn views<'a>(attempt: &'a Attempt<'_>) -> impl Iterator<Item = (&'a FluoroscopyPulse, &'a CArmControls)> {
    let fluoroscopy = &attempt.recording.fluoroscopy;
    fluoroscopy.pulses.iter().filter_map(|pulse| Some((pulse, fluoroscopy.controls_at(pulse.t_s)?)))
}

fn mean_field_cm2(attempt: &Attempt) -> Outcome {
    let areas: Vec<f64> = views(attempt).map(|(_, controls)| controls.field_m * controls.field_m * 1e4).collect();
    if areas.is_empty() { Err(Absent::NoPulse) } else { Ok(areas.iter().sum::<f64>() / areas.len() as f64) }
}

/// Counts the views of pulses before the first contact that are at least [`ANOTHER_VIEW_DEG`] apart.
fn count_views_before_skin(attempt: &Attempt) -> f64 {
    let contact = attempt.recording.events.iter().find(|event| event.kind == EventKind::Contact);
    let until_s = contact.map_or(f64::INFINITY, |contact| contact.t_s);
    let mut seen: Vec<Vector3<f64>> = Vec::new();
    for (_, controls) in views(attempt).take_while(|(pulse, _)| pulse.t_s < until_s) {
        let direction = direction(controls);
        let is_new = |known: &Vector3<f64>| {
            libm::atan2(known.cross(&direction).norm(), known.dot(&direction)).to_degrees() >= ANOTHER_VIEW_DEG
        };
        if seen.iter().all(is_new) {
            seen.push(direction);
        }
    }
    seen.len() as f64
}

/// The direction of the central ray.
fn direction(controls: &CArmControls) -> Vector3<f64> {
    let ((so, co), (st, ct)) = (libm::sincos(controls.orbital_rad), libm::sincos(controls.tilt_rad));
    Vector3::new(so * ct, st, co * ct)
}
