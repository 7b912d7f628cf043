//! The error of a field at a lower rate than the force law's 1 kHz.

use std::f64::consts::TAU;

use law::Incidence;
use law::axial::{AxialInput, AxialParams, AxialScratch, AxialState, forecast_standing, step};

/// A straight insertion, from the skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightInsertion {
    /// Mean speed, in m/s.
    pub speed_m_per_s: f64,
    /// Maximum displacement, in m.
    pub depth_m: f64,
    /// Amplitude of a tremor of 10 Hz, in m; 0 for a constant speed.
    pub tremor_m: f64,
}

/// Difference between the force that the field bears and that of the force law: rms over the
/// insertion, as a fraction of the peak force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandOver {
    /// The field holds the last force that it received. The pops dominate: each is missed for half
    /// a period.
    pub held: f64,
    /// The field extrapolates with the last rate of change of the force, which does not predict
    /// pops either.
    pub extrapolated: f64,
    /// The field extrapolates with the last velocity of the needle and evaluates the law's closed
    /// form, [`forecast_standing`], which predicts the next rupture.
    pub forecast: f64,
}

/// One field rate, and its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateError {
    /// Rate of the field, in Hz.
    pub field_hz: f64,
    /// The error.
    pub error: HandOver,
}

/// Measures an insertion at each of these field rates, in Hz: the force error as a function of the
/// field's rate.
#[must_use]
pub fn rate_errors(params: &AxialParams, insertion: &StraightInsertion, rates_hz: &[f64]) -> Vec<RateError> {
    rates_hz.iter().map(|&field_hz| RateError { field_hz, error: hand_over(params, insertion, field_hz) }).collect()
}

/// Rate of the force law, in Hz.
const LAW_HZ: u32 = 1000;
/// Frequency of the tremor, in Hz.
const TREMOR_HZ: f64 = 10.0;

/// Measures one field rate, in Hz, on one insertion.
#[must_use]
pub fn hand_over(params: &AxialParams, insertion: &StraightInsertion, field_hz: f64) -> HandOver {
    let StraightInsertion { speed_m_per_s, depth_m, tremor_m } = *insertion;
    let (mut state, mut scratch) = (AxialState::new(params), AxialScratch::new(params));
    let ticks = (depth_m / speed_m_per_s * f64::from(LAW_HZ)) as u32;
    let mut taken = Taken { state: state.clone(), scratch: scratch.clone(), t_s: 0.0, rate_n_per_s: 0.0 };
    let (mut before_n, mut peak_n, mut period) = (0.0, 0.0_f64, -1.0);
    let mut squares = [0.0; 3];
    for tick in 0..=ticks {
        let t_s = f64::from(tick) / f64::from(LAW_HZ);
        let x_m = speed_m_per_s * t_s + tremor_m * libm::sin(TAU * TREMOR_HZ * t_s);
        let force_n =
            step(params, &mut state, &mut scratch, &AxialInput { t_s, x_m, incidence: Incidence::UPRIGHT }).total_n();
        // Times are multiples of 1/1000: a billionth of a period tolerates their rounding.
        let due = (t_s * field_hz + 1e-9).floor();
        if due > period {
            period = due;
            let steady = scratch.ruptures.is_empty();
            let rate_n_per_s = if steady { (force_n - before_n) * f64::from(LAW_HZ) } else { 0.0 };
            taken = Taken { state: state.clone(), scratch: scratch.clone(), t_s, rate_n_per_s };
        }
        for (square, carried_n) in squares.iter_mut().zip(taken.carried_n(params, t_s)) {
            *square += (carried_n - force_n) * (carried_n - force_n);
        }
        before_n = force_n;
        peak_n = peak_n.max(force_n);
    }
    let [held, extrapolated, forecast] = squares.map(|square: f64| (square / f64::from(ticks + 1)).sqrt() / peak_n);
    HandOver { held, extrapolated, forecast }
}

/// The last state that the field received from the law.
struct Taken {
    state: AxialState,
    scratch: AxialScratch,
    t_s: f64,
    rate_n_per_s: f64,
}

impl Taken {
    /// The force that the field bears at a time: held, extrapolated, and forecast.
    fn carried_n(&mut self, params: &AxialParams, t_s: f64) -> [f64; 3] {
        let since_s = t_s - self.t_s;
        let held_n = self.state.last_output().total_n();
        let forecast_n = forecast_standing(params, &self.state, &mut self.scratch, since_s).output.total_n();
        [held_n, held_n + self.rate_n_per_s * since_s, forecast_n]
    }
}
