//! Fits of timed curves with known parameters, for the options of version 3 of the law.
//!
//! A needle is inserted by 10 mm at 4 mm/s, rests for 4 s and is withdrawn. The law computes the
//! curve in ticks of 1 ms, of which every 30th is a sample, with white noise from a seed; the
//! needle stops and reverses between two samples, as in any recording. The fit starts from the
//! truth with every number changed by up to a fifth.

use law::axial::{AxialSpec, Breakaway, ForceLaw, LayerOptions, MaxwellBranch, ParamError};
use law::operator::Draw;
use tissue::calibrate::{CalibrateError, Fit, ParameterStanding, TimedCurve, TimedSample, fit_timed};

use crate::calibration::{Judged, true_value};
use crate::scenes::{AxialRun, make_layer, needle_through};

/// Speed of the needle, in m/s.
pub const SPEED_M_PER_S: f64 = 4e-3;
/// Time between samples, in s.
pub const SAMPLE_S: f64 = 0.03;
/// Ticks between samples.
const TICKS: u32 = 30;
/// Largest depth, in m.
pub const DEEPEST_M: f64 = 10e-3;
/// Duration of the hold, in s.
pub const HOLD_S: f64 = 4.0;
/// Standard deviations of the noise, used in turn, in N.
const NOISES_N: [f64; 4] = [0.005, 0.01, 0.02, 0.04];

/// The tissue of a timed curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimedTissue {
    /// A capsule over tissue, both of which stiffen and relax.
    Relaxing,
    /// The same with damping along the shaft.
    Damped,
    /// A sheet over tissue with static friction on a resting shaft.
    Sticking,
}

impl TimedTissue {
    /// Every tissue.
    pub const ALL: [Self; 3] = [Self::Relaxing, Self::Damped, Self::Sticking];

    /// Describes the tissue in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Relaxing => "relaxes and stiffens",
            Self::Damped => "relaxes, stiffens and damps",
            Self::Sticking => "sticks to the shaft",
        }
    }

    /// Draws random layers.
    pub fn draw(self, draw: &mut Draw) -> AxialSpec {
        match self {
            Self::Relaxing => liver(draw),
            Self::Damped => {
                let mut truth = liver(draw);
                truth.layers[0].damping_n_s_per_m2 = 4000.0 * libm::pow(2.5, draw.uniform());
                truth
            }
            Self::Sticking => {
                let mut truth = sticky_at(1e-3 * libm::pow(3.0, draw.uniform()), 60.0 + 30.0 * draw.uniform());
                truth.layers[0].stiffness_n_per_m *= 0.8 + 0.4 * draw.uniform();
                truth.layers[0].cutting_n *= 0.5 + draw.uniform();
                truth
            }
        }
    }
}

/// A timed curve with its true parameters.
#[derive(Clone, Debug)]
pub struct SampledTimedCurve {
    /// The tissue.
    pub tissue: TimedTissue,
    /// Standard deviation of its noise, in N.
    pub noise_n: f64,
    /// The layers.
    pub truth: AxialSpec,
    /// Start of the fit.
    pub start: AxialSpec,
    /// The samples, in order.
    pub samples: Vec<TimedSample>,
}

/// A fit compared with the truth.
#[derive(Clone, Debug)]
pub struct TimedTrial {
    /// The fit.
    pub fit: Fit,
    /// Every parameter that the curve depends on.
    pub parameters: Vec<Judged>,
}

/// Creates a curve from a seed; consecutive seeds cycle through the tissues, and then through the
/// noise levels.
///
/// # Errors
/// If the law refuses the layers, which does not happen for those drawn here.
pub fn sample_timed(seed: u64) -> Result<SampledTimedCurve, ParamError> {
    let mut draw = Draw::new(seed);
    let tissue = TimedTissue::ALL[(seed % 3) as usize];
    let noise_n = NOISES_N[(seed / 3 % 4) as usize];
    let truth = tissue.draw(&mut draw);
    let noise = TimedNoise { draw: &mut draw, deviation_n: noise_n };
    let samples = insertion(&truth, DEEPEST_M, HOLD_S, noise)?;
    let start = changed(&truth, &mut draw);
    Ok(SampledTimedCurve { tissue, noise_n, truth, start, samples })
}

/// Fits a curve and compares the result with the truth.
///
/// # Errors
/// Those of the fit.
pub fn try_timed_fit(sampled: &SampledTimedCurve) -> Result<TimedTrial, CalibrateError> {
    let fit = fit_timed(&TimedCurve::new(&sampled.samples)?, &sampled.start, &mut |_| ())?;
    let seen = fit.estimates.iter().filter(|estimate| estimate.standing != ParameterStanding::Kept);
    let judged = |estimate: &_| {
        let truth = true_value(&sampled.truth, estimate)?;
        Some(Judged { estimate: estimate.clone(), truth })
    };
    let parameters = seen.filter_map(judged).collect();
    Ok(TimedTrial { fit, parameters })
}

/// Draws a layer with stiffening, relaxation and friction above one that never opens.
#[must_use]
pub fn liver(draw: &mut Draw) -> AxialSpec {
    let mut number = |low: f64, high: f64| low * libm::pow(high / low, draw.uniform());
    let mut layers = vec![
        make_layer("capsule", [4.0, number(150.0, 300.0), 0.0, 1.0, 0.0, number(20.0, 60.0), number(0.05, 0.2)]),
        make_layer("liver", [60.0, number(150.0, 300.0), 0.0, 40.0, 0.0, 30.0, 0.1]),
    ];
    layers[0].tip_rupture_n = number(0.8, 1.2);
    for layer in &mut layers {
        let branches = vec![MaxwellBranch { share: number(0.6, 1.2), time_s: number(0.5, 1.5) }];
        layer.options = LayerOptions { stiffening_n_per_m2: number(1e4, 3e4), branches, ..LayerOptions::default() };
    }
    AxialSpec { law: ForceLaw::Version3, ..needle_through(layers) }
}

/// Returns tissue with static friction in N/m on a resting shaft, which breaks away after sliding a
/// distance in m.
#[must_use]
pub fn sticky_at(slid_m: f64, sticking_n_per_m: f64) -> AxialSpec {
    let mut layer = make_layer("liver", [60.0, 300.0, 0.0, 0.8, 0.0, 40.0, 0.2]);
    layer.options.static_friction_n_per_m = Some(sticking_n_per_m);
    let breakaway = Some(Breakaway { slid_m, rest_s: 1.0 });
    AxialSpec { law: ForceLaw::Version3, breakaway, ..needle_through(vec![layer]) }
}

/// White noise with a standard deviation in N.
pub struct TimedNoise<'d> {
    /// Its random generator.
    pub draw: &'d mut Draw,
    /// Its standard deviation, in N.
    pub deviation_n: f64,
}

/// Returns the law's forces for an insertion to a depth in m, a hold for a time in s, and
/// withdrawal.
///
/// # Errors
/// If the law refuses the layers.
pub fn insertion(
    layers: &AxialSpec,
    deepest_m: f64,
    hold_s: f64,
    noise: TimedNoise<'_>,
) -> Result<Vec<TimedSample>, ParamError> {
    let way_s = deepest_m / SPEED_M_PER_S;
    let depth_m = |t_s: f64| {
        if t_s < way_s { SPEED_M_PER_S * t_s } else { deepest_m - SPEED_M_PER_S * (t_s - way_s - hold_s).max(0.0) }
    };
    along(layers, 2.0 * way_s + hold_s, &depth_m, noise)
}

/// Returns the same for any track: duration in s, and depth in m as a function of time.
///
/// # Errors
/// If the law refuses the layers.
pub fn along(
    layers: &AxialSpec,
    length_s: f64,
    depth_m: &dyn Fn(f64) -> f64,
    noise: TimedNoise<'_>,
) -> Result<Vec<TimedSample>, ParamError> {
    let samples = (length_s / SAMPLE_S) as u32;
    let mut run = AxialRun::new(layers.clone())?;
    let mut taken = Vec::new();
    for tick in 0..=samples * TICKS {
        let t_s = f64::from(tick) * SAMPLE_S / f64::from(TICKS);
        let depth_m = depth_m(t_s);
        let force_n = run.step(t_s, depth_m).total_n();
        if tick % TICKS == 0 {
            taken.push(TimedSample { t_s, depth_m, force_n: force_n + noise.draw.normal(noise.deviation_n) });
        }
    }
    Ok(taken)
}

/// Returns the truth with every number changed by up to a fifth, as the start of a fit.
#[must_use]
pub fn changed(truth: &AxialSpec, draw: &mut Draw) -> AxialSpec {
    let mut start = truth.clone();
    let mut by = || 0.8 * libm::pow(1.5, draw.uniform());
    for layer in &mut start.layers {
        layer.stiffness_n_per_m *= by();
        layer.friction_n_per_m *= by();
        layer.cutting_n *= by();
        layer.options.stiffening_n_per_m2 *= by();
        layer.options.branches.iter_mut().for_each(|branch| branch.share *= by());
        layer.options.branches.iter_mut().for_each(|branch| branch.time_s *= by());
        layer.damping_n_s_per_m2 *= by();
        layer.options.static_friction_n_per_m.iter_mut().for_each(|sticking| *sticking *= by());
    }
    start.breakaway.iter_mut().for_each(|breakaway| breakaway.slid_m *= by());
    start
}
