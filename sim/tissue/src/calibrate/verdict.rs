//! Tests whether a fit's residual is the curve's own noise: a wrong minimum, drift or outliers
//! leave structure.
//!
//! The second differences of the curve estimate its noise without a fit. A correct fit leaves a
//! residual of that deviation and without memory; excess is detected by its size, by the
//! correlation of neighbours, and by its sums over stretches of every length.

use super::model::{CurveModel, Guess};

/// A residual below this fraction of the peak is below the resolution of any force sensor, and not
/// a misfit (choice).
const SEEN_PART: f64 = 5e-4;
/// Allowed excess of the residual over the noise, over √n: three deviations of the noise estimate.
const LARGER: f64 = 4.0;
/// Maximum correlation of neighbours, over 1/√n.
const LIKE: f64 = 3.4;
/// Maximum sum over a stretch, in its deviations.
const STRETCH: f64 = 6.0;
/// Maximum sum of squares over all stretches of a length, as a normal deviate.
const STRETCHES: f64 = 4.0;
/// Minimum number of stretches for such a sum.
const FEWEST: usize = 4;

/// Why a residual is not the curve's noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Misfit {
    /// Root mean square residual, in N.
    pub rms_n: f64,
    /// Noise of the curve, in N.
    pub noise_n: f64,
    /// The middle of the worst stretch, in m.
    pub worst_m: f64,
    /// Correlation of neighbouring residuals; 0 for noise.
    pub correlation: f64,
    /// Drops interpreted as layers that may be single outliers, in m.
    pub lone_m: Vec<f64>,
}

/// The residual of a fit, in the order measured.
pub(super) struct FitResidual<'r> {
    /// Law minus data, in N.
    pub residuals: &'r [f64],
    /// Depth of each sample, in m.
    pub depth_m: &'r [f64],
    /// The curve's maximum force, in N.
    pub peak_n: f64,
    /// Its noise, in N.
    pub noise_n: f64,
}

/// The structure of a residual; `None` if it is noise. A drop that may be a single outlier counts
/// as a misfit: its layer leaves no residual.
pub(super) fn find_misfit(model: &CurveModel<'_>, guess: &Guess, lone_m: Vec<f64>) -> Option<Misfit> {
    let residuals = model.misfit(guess, &model.variables(guess));
    let (peak_n, noise_n) = (model.curve.peak_n(), model.curve.noise_n());
    judge_residual(&FitResidual { residuals: &residuals, depth_m: &model.curve.depth_m, peak_n, noise_n }, lone_m)
}

/// The same test for the residual of any fit.
pub(super) fn judge_residual(left: &FitResidual<'_>, lone_m: Vec<f64>) -> Option<Misfit> {
    let FitResidual { residuals, depth_m, peak_n, noise_n } = *left;
    let samples = residuals.len() as f64;
    let finest_n = SEEN_PART * peak_n;
    let rms_n = (residuals.iter().map(|r| r * r).sum::<f64>() / samples).sqrt();
    let (worst, most) = worst_stretch(residuals, rms_n.max(finest_n));
    let correlation = correlation(residuals);
    let is_large = rms_n > noise_n.max(finest_n) * (1.0 + LARGER / samples.sqrt());
    let is_seen = rms_n > finest_n;
    let is_misfit = !lone_m.is_empty()
        || is_large
        || most > STRETCH
        || is_seen && (correlation > LIKE / samples.sqrt() || stretches(residuals, rms_n) > STRETCHES);
    is_misfit.then(|| Misfit { rms_n, noise_n, worst_m: depth_m[worst], correlation, lone_m })
}

impl Misfit {
    /// A description for the user.
    #[must_use]
    pub fn words(&self) -> String {
        let Self { rms_n, noise_n, worst_m, correlation, lone_m } = self;
        if !lone_m.is_empty() {
            let places: Vec<String> = lone_m.iter().map(|x_m| format!("{:.2} mm", x_m * 1e3)).collect();
            return format!(
                "the drops at {} may be single outliers instead of layers; no value has an interval",
                places.join(", ")
            );
        }
        format!(
            "the residual of {rms_n:.4} N exceeds the curve's noise of {noise_n:.4} N: it is most pronounced at {:.2} \
             mm, and neighbours correlate by {correlation:.2}. Possible reasons: a wrong minimum, another number of \
             layers, drift or outliers; no value has an interval",
            worst_m * 1e3
        )
    }
}

/// Correlation of neighbours.
fn correlation(residuals: &[f64]) -> f64 {
    let squares: f64 = residuals.iter().map(|r| r * r).sum();
    let products: f64 = residuals.windows(2).map(|pair| pair[0] * pair[1]).sum();
    if squares > 0.0 { products / squares } else { 0.0 }
}

/// The middle of the stretch with the most significant sum, over lengths that are powers of two,
/// and its number of deviations.
fn worst_stretch(residuals: &[f64], deviation_n: f64) -> (usize, f64) {
    let mut sums = vec![0.0];
    for residual in residuals {
        sums.push(sums[sums.len() - 1] + residual);
    }
    let mut worst = (0, 0.0);
    for length in lengths(residuals.len()) {
        for from in 0..=residuals.len() - length {
            let deviates = (sums[from + length] - sums[from]).abs() / (deviation_n * (length as f64).sqrt());
            if deviates > worst.1 {
                worst = (from + length / 2, deviates);
            }
        }
    }
    worst
}

/// The sum of squares of neighbouring stretches, for the most significant length, as a normal
/// deviate (Wilson & Hilferty, "The distribution of chi-square", Proc. Natl. Acad. Sci. 17, 1931).
fn stretches(residuals: &[f64], deviation_n: f64) -> f64 {
    let deviate = |length: usize| {
        let sums = residuals.chunks_exact(length).map(|stretch| stretch.iter().sum::<f64>());
        let count = (residuals.len() / length) as f64;
        let squares = sums.map(|sum| sum * sum).sum::<f64>() / (deviation_n * deviation_n * length as f64);
        let part = 2.0 / (9.0 * count);
        (libm::cbrt(squares / count) - (1.0 - part)) / part.sqrt()
    };
    lengths(residuals.len()).map(deviate).fold(0.0, f64::max)
}

/// Powers of two that fit into a curve at least [`FEWEST`] times.
fn lengths(samples: usize) -> impl Iterator<Item = usize> {
    (0..).map(|power| 1_usize << power).take_while(move |length| length * FEWEST <= samples)
}
