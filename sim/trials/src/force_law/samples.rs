//! Input of a faulty device, none of which may affect the state.

use law::Incidence;
use law::axial::{AxialInput, AxialOutput, step};

use super::{DT, inserted};
use crate::scenes::{AxialRun, training_axial_spec};
use crate::{Measured, largest};

/// Time at which the needle is at rest, in s: the end of its insertion to 20 mm at 10 mm/s.
const ARRIVED_S: f64 = 2.0;

/// Counts the samples that changed anything. Required: the output is the last good one, marked as
/// held, the state is unchanged, and the next good sample is accepted.
fn believed(samples: &[AxialInput]) -> Measured {
    let mut run = inserted(training_axial_spec(), 0.02)?;
    let (good, state) = (run.state.last_output(), run.state.clone());
    let mut traces = 0_u32;
    for input in samples {
        let held = step(&run.params, &mut run.state, &mut run.scratch, input);
        let clean = held == AxialOutput { held: true, ..good } && run.state == state && run.ruptures().is_empty();
        traces += u32::from(!clean);
    }
    traces += u32::from(run.step(ARRIVED_S + DT, 0.02).held);
    Ok(f64::from(traces))
}

/// NaN, infinite, repeated with another position, backwards in time; and impossible path factors.
pub(super) fn bad_samples() -> Measured {
    let next_s = ARRIVED_S + DT;
    let at = |t_s, x_m| AxialInput { t_s, x_m, incidence: Incidence::UPRIGHT };
    let along = |path_factor| AxialInput { t_s: next_s, x_m: 0.02, incidence: Incidence::of_factor(path_factor) };
    believed(&[
        at(next_s, f64::NAN),
        at(next_s, f64::INFINITY),
        at(next_s, f64::NEG_INFINITY),
        at(f64::NAN, 0.02),
        at(f64::INFINITY, 0.02),
        at(f64::NEG_INFINITY, 0.02),
        at(ARRIVED_S, 0.03),
        at(ARRIVED_S - 0.5, 0.03),
        along(f64::NAN),
        along(f64::INFINITY),
        along(0.0),
        along(-1.0),
    ])
}

/// The same instant again, at the same position, deeper and higher; and an instant too close to
/// distinguish.
pub(super) fn no_time() -> Measured {
    let at = |t_s, x_m| AxialInput { t_s, x_m, incidence: Incidence::UPRIGHT };
    believed(&[at(ARRIVED_S, 0.02), at(ARRIVED_S, 0.021), at(ARRIVED_S, 0.019), at(ARRIVED_S + 1e-10, 0.021)])
}

/// The first good sample initialises the law, regardless of earlier ones.
pub(super) fn bad_first_sample() -> Measured {
    let (mut bad, mut clean) = (AxialRun::new(training_axial_spec())?, AxialRun::new(training_axial_spec())?);
    bad.step(f64::NAN, 0.0);
    Ok((bad.step(0.0, 0.01).total_n() - clean.step(0.0, 0.01).total_n()).abs())
}

/// A gap is one long tick and does not affect later results.
pub(super) fn missing_samples() -> Measured {
    let (mut whole, mut gapped) = (AxialRun::new(training_axial_spec())?, AxialRun::new(training_axial_spec())?);
    let mut change = |tick: u32| {
        let (t_s, x_m) = (f64::from(tick) * DT, f64::from(tick) * 5e-6);
        let wanted_n = whole.step(t_s, x_m).total_n();
        let missing = (2000..2100).contains(&tick);
        if missing { 0.0 } else { (gapped.step(t_s, x_m).total_n() - wanted_n).abs() }
    };
    Ok(largest((0..4000).map(&mut change)))
}
