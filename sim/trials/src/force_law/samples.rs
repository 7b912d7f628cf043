//! What a broken device sends: none of it may leave a trace.

use law::Incidence;
use law::axial::{AxialInput, AxialOutput, step};

use super::{DT, inserted};
use crate::scenes::{AxialRun, training_axial_spec};
use crate::{Measured, largest};

/// Time at which the needle has come to rest, in s: its insertion to 20 mm at 10 mm/s ends there.
const ARRIVED_S: f64 = 2.0;

/// How many of the samples changed anything: their own answer is the last good one and held, the state is untouched, and
/// the next good sample is taken.
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

/// Not numbers, infinite, repeated with another position, backwards in time; and path factors that no angle has.
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

/// The same instant again, where the needle was, deeper and higher; and an instant too close to tell apart.
pub(super) fn no_time() -> Measured {
    let at = |t_s, x_m| AxialInput { t_s, x_m, incidence: Incidence::UPRIGHT };
    believed(&[at(ARRIVED_S, 0.02), at(ARRIVED_S, 0.021), at(ARRIVED_S, 0.019), at(ARRIVED_S + 1e-10, 0.021)])
}

/// The first good sample is the first, whatever came before it.
pub(super) fn bad_first_sample() -> Measured {
    let (mut bad, mut clean) = (AxialRun::new(training_axial_spec())?, AxialRun::new(training_axial_spec())?);
    bad.step(f64::NAN, 0.0);
    Ok((bad.step(0.0, 0.01).total_n() - clean.step(0.0, 0.01).total_n()).abs())
}

/// A gap is one long tick: what comes after it is as if it had not been.
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
