//! Fits of curves with known parameters: checks whether the intervals contain the truth and whether
//! wrong minima are detected.
//!
//! A curve is the law evaluated in steps of 2 µm, subsampled, with noise drawn from a seed. Blind
//! curves have random layers that are unknown to the fit; the others have the changed numbers of a
//! scene, and the fit starts from the original scene. Each boundary of a blind curve makes a clear
//! drop, as a fit of the curve alone requires.

use law::axial::AxialSpec;
use law::closed_form::predict_ruptures;
use law::operator::Draw;
use law::soundness;
use tissue::calibrate::{CalibrateError, Curve, Fit, Fresh, ParameterEstimate, Quantity, Start, fit, residual_rms_n};

use super::scenes::{AxialRun, make_layer, needle_through};

/// Steps of the needle, in m.
const STEP_M: f64 = 2e-6;
/// A clear drop between two samples is at least this many standard deviations of the noise, and
/// this fraction of the peak.
const CLEAR_NOISE: f64 = 10.0;
const CLEAR_PART: f64 = 0.06;
/// A fit is in a wrong minimum if its sum of squares exceeds that of the truth by this many
/// variances.
const WRONG: f64 = 9.0;
/// A fit is also wrong if a parameter deviates from the truth by this many half-widths of its
/// interval.
const FAR: f64 = 3.0;
/// Maximum number of scenes drawn until one is suitable.
const DRAWS: u32 = 10_000;

/// Errors of the data in addition to white noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Disturbance {
    /// No disturbance.
    None,
    /// A slow wave with an amplitude of five standard deviations of the noise.
    Drift,
    /// One sample in a hundred deviates by fifteen standard deviations of the noise.
    Outliers,
}

/// Source of a curve's layers.
#[derive(Clone, Copy, Debug)]
pub enum Origin<'s> {
    /// Random layers that are unknown to the fit.
    Blind {
        /// Number of layers.
        layers: usize,
        /// Distance from a trocar's tip to its rim, in m; 0 for a needle. The drops of a trocar
        /// alternate, as its fit requires.
        tip_to_rim_m: f64,
    },
    /// A scene with numbers changed by up to a quarter, fitted from the original scene.
    Changed(&'s AxialSpec),
}

/// Measurement conditions of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Standard deviation of the noise, in N.
    pub noise_n: f64,
    /// Distance between samples, in m.
    pub spacing_m: f64,
    /// Whether the needle is withdrawn.
    pub withdraws: bool,
    /// Additional disturbance.
    pub disturbance: Disturbance,
}

/// A curve with its true parameters.
#[derive(Clone, Debug)]
pub struct SampledCurve {
    /// The layers.
    pub truth: AxialSpec,
    /// Start of the fit; `None` if it starts from the curve alone.
    pub start: Option<AxialSpec>,
    /// Measurement conditions.
    pub measurement: Measurement,
    /// Depth in m, force in N.
    pub samples: Vec<(f64, f64)>,
}

/// A parameter's true value and its estimate.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// The estimate.
    pub estimate: ParameterEstimate,
    /// True value, in SI.
    pub truth: f64,
}

/// A fit compared with the truth.
#[derive(Clone, Debug)]
pub struct Trialled {
    /// The fit.
    pub fit: Fit,
    /// Every parameter; empty if the number of layers is wrong.
    pub parameters: Vec<Judged>,
    /// Whether the number of layers is wrong, the sum of squares exceeds that of the truth, or a
    /// determined parameter deviates far from it.
    pub is_wrong: bool,
    /// Whether the fit is wrong without reporting it: it neither reports a residual other than
    /// noise nor, if only the sum of squares is too large, alternative solutions.
    pub is_silent: bool,
}

impl Measurement {
    /// Selects one of two dozen conditions: four noise levels, three spacings, with and without
    /// withdrawal.
    #[must_use]
    pub fn of_seed(seed: u64, disturbance: Disturbance) -> Self {
        Self {
            noise_n: [0.005, 0.01, 0.02, 0.04][(seed % 4) as usize],
            spacing_m: [0.05e-3, 0.1e-3, 0.2e-3][(seed / 4 % 3) as usize],
            withdraws: seed / 12 % 2 == 1,
            disturbance,
        }
    }
}

impl Judged {
    /// Returns whether the interval contains the truth; `None` without an interval.
    #[must_use]
    pub fn is_held(&self) -> Option<bool> {
        self.estimate.interval.map(|interval| interval.holds(self.truth))
    }

    fn is_far(&self) -> bool {
        let ParameterEstimate { interval, value, .. } = self.estimate;
        interval.is_some_and(|interval| {
            let half = if self.truth > value { interval.high - value } else { value - interval.low };
            (self.truth - value).abs() > FAR * half.max(0.1 * (interval.high - interval.low))
        })
    }
}

/// Creates a curve from a seed; `None` if no scene is suitable, or if the scene's first rupture is
/// not within the curve.
#[must_use]
pub fn sample(origin: Origin<'_>, measurement: Measurement, seed: u64) -> Option<SampledCurve> {
    let mut draw = Draw::new(seed);
    for _ in 0..DRAWS {
        let truth = match origin {
            Origin::Blind { layers, tip_to_rim_m } => random_layers(layers, tip_to_rim_m, &mut draw),
            Origin::Changed(scene) => changed(scene, &mut draw),
        };
        if !soundness::find_unsound_ruptures(&truth).is_empty() {
            continue;
        }
        let beyond_m = between(&mut draw, 0.002, 0.008);
        let clean = track(&truth, &measurement, beyond_m)?;
        if matches!(origin, Origin::Blind { .. }) && !is_clear(&truth, &clean, &measurement) {
            continue;
        }
        let start = match origin {
            Origin::Blind { .. } => None,
            Origin::Changed(scene) => Some(scene.clone()),
        };
        return Some(SampledCurve { truth, start, measurement, samples: disturbed(clean, &measurement, &mut draw) });
    }
    None
}

/// Fits a curve and compares the result with the truth.
///
/// # Errors
/// Those of the fit.
pub fn try_fit(sampled: &SampledCurve) -> Result<Trialled, CalibrateError> {
    let curve = Curve::new(&sampled.samples)?;
    let fresh = Fresh { layers: None, tip_to_rim_m: sampled.truth.tip_to_rim_m };
    let start = sampled.start.as_ref().map_or(Start::Fresh(fresh), Start::Scene);
    let fit = fit(&curve, start, &mut |_| ())?;
    let is_whole = fit.spec.layers.len() == sampled.truth.layers.len();
    let of_truth = |estimate: &ParameterEstimate| {
        let truth = true_value(&sampled.truth, estimate)?;
        Some(Judged { estimate: estimate.clone(), truth })
    };
    let parameters: Vec<Judged> =
        if is_whole { fit.estimates.iter().filter_map(of_truth).collect() } else { Vec::new() };
    let above = fit.rms_n.powi(2) / residual_rms_n(&sampled.truth, &curve).powi(2) - 1.0;
    let is_above = above * curve.len() as f64 > WRONG;
    let is_misled = !is_whole || parameters.iter().any(Judged::is_far);
    let (is_wrong, is_unsaid) =
        (is_misled || is_above, is_misled || is_above && fit.readings == 0 && fit.unseen.is_empty());
    let is_silent = is_unsaid && fit.converged;
    Ok(Trialled { fit, parameters, is_wrong, is_silent })
}

/// Returns the true value of a parameter; `None` for a layer or a length that does not exist.
pub(crate) fn true_value(truth: &AxialSpec, estimate: &ParameterEstimate) -> Option<f64> {
    match estimate.quantity {
        Quantity::Presliding => Some(truth.presliding_stiffness_n_per_m),
        Quantity::Breakaway => truth.breakaway.map(|breakaway| breakaway.slid_m),
        quantity => truth.layers.get(estimate.layer).map(|layer| quantity.get(layer)),
    }
}

fn between(draw: &mut Draw, low: f64, high: f64) -> f64 {
    low + (high - low) * draw.uniform()
}

/// Draws from a log-uniform distribution, so that soft and stiff, weak and strong are equally
/// likely.
fn scaled(draw: &mut Draw, low: f64, high: f64) -> f64 {
    libm::exp(between(draw, libm::log(low), libm::log(high)))
}

fn random_layers(count: usize, tip_to_rim_m: f64, draw: &mut Draw) -> AxialSpec {
    let name = |at: usize| format!("layer {}", at + 1);
    let layers = (0..count).map(|at| {
        let thickness_mm = if at + 1 == count { 200.0 } else { between(draw, 2.0, 14.0) };
        let stiffness = scaled(draw, 80.0, 900.0);
        let threshold_n = scaled(draw, 0.4, 5.0);
        let friction = scaled(draw, 5.0, 80.0);
        let rim_n = threshold_n * between(draw, 1.1, 1.6);
        make_layer(&name(at), [thickness_mm, stiffness, 0.0, threshold_n, rim_n, friction, between(draw, 0.05, 0.5)])
    });
    AxialSpec { tip_to_rim_m, ..needle_through(layers.collect()) }
}

/// Changes every nonzero number of a scene by up to a quarter.
fn changed(scene: &AxialSpec, draw: &mut Draw) -> AxialSpec {
    let mut changed = scene.clone();
    for layer in &mut changed.layers {
        for number in [
            &mut layer.thickness_m,
            &mut layer.stiffness_n_per_m,
            &mut layer.tip_rupture_n,
            &mut layer.rim_rupture_n,
            &mut layer.friction_n_per_m,
            &mut layer.cutting_n,
        ] {
            *number *= scaled(draw, 0.8, 1.25);
        }
    }
    changed
}

/// Returns the law's samples on the way in, to beyond the last rupture, and out; `None` if the law
/// refuses the scene or nothing ruptures.
fn track(truth: &AxialSpec, measurement: &Measurement, beyond_m: f64) -> Option<Vec<(f64, f64)>> {
    let mut slow = truth.clone();
    slow.rate = None;
    slow.layers.iter_mut().for_each(|layer| layer.damping_n_s_per_m2 = 0.0);
    let deepest_m = predict_ruptures(&slow).last()?.x_m + beyond_m;
    let steps = (measurement.spacing_m / STEP_M).round().max(1.0) as u32;
    let samples = (deepest_m / measurement.spacing_m).round() as u32;
    let mut run = AxialRun::new(slow).ok()?;
    let (mut time_s, mut taken) = (0.0, Vec::new());
    let inwards = 0..=samples * steps;
    let outwards = (0..if measurement.withdraws { samples * steps } else { 0 }).rev();
    for step in inwards.chain(outwards) {
        let x_m = f64::from(step) * measurement.spacing_m / f64::from(steps);
        let force_n = run.step(time_s, x_m).total_n();
        time_s += 1.0;
        if step % steps == 0 {
            taken.push((x_m, force_n));
        }
    }
    Some(taken)
}

/// Returns whether every boundary makes a separate, clear drop.
fn is_clear(truth: &AxialSpec, clean: &[(f64, f64)], measurement: &Measurement) -> bool {
    let peak_n = clean.iter().map(|sample| sample.1).fold(0.0, f64::max);
    let least_n = (CLEAR_NOISE * measurement.noise_n).max(CLEAR_PART * peak_n);
    let gap = |x_m: f64| libm::ceil(x_m / measurement.spacing_m) as usize;
    let predicted = predict_ruptures(truth);
    let alternates = predicted.chunks(2).all(|pair| match pair {
        [tip, rim] if truth.tip_to_rim_m > 0.0 => tip.contactor != rim.contactor && tip.boundary == rim.boundary,
        _ => truth.tip_to_rim_m <= 0.0,
    });
    let gaps: Vec<usize> = predicted.iter().map(|rupture| gap(rupture.x_m)).collect();
    let is_apart = gaps.windows(2).all(|pair| pair[1] > pair[0] + 5);
    let falls = |&gap: &usize| clean.get(gap).is_some_and(|after| clean[gap - 1].1 - after.1 >= least_n);
    alternates && is_apart && gaps.first().is_some_and(|&first| first > 5) && gaps.iter().all(falls)
}

fn disturbed(clean: Vec<(f64, f64)>, measurement: &Measurement, draw: &mut Draw) -> Vec<(f64, f64)> {
    let noise_n = measurement.noise_n;
    let (phase, length_m) = (between(draw, 0.0, core::f64::consts::TAU), between(draw, 0.005, 0.02));
    let disturb = |(x_m, force_n): (f64, f64)| {
        let white_n = draw.normal(noise_n);
        let more_n = match measurement.disturbance {
            Disturbance::None => 0.0,
            Disturbance::Drift => 5.0 * noise_n * libm::sin(phase + core::f64::consts::TAU * x_m / length_m),
            Disturbance::Outliers if draw.uniform() < 0.01 => {
                15.0 * noise_n * if draw.uniform() < 0.5 { -1.0 } else { 1.0 }
            }
            Disturbance::Outliers => 0.0,
        };
        (x_m, force_n + white_n + more_n)
    };
    clean.into_iter().map(disturb).collect()
}
