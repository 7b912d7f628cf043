//! Layers from a measured force–depth curve: bounded least squares on the force law itself, at slow
//! speed.
//!
//! A drop of the force is a ruptured boundary, so the curve shows the places of ruptures directly
//! ([`Curve`] and its drops). With these places held, thickness, stiffness, friction and cutting of
//! every layer, and the position of each rupture within its gap, are fitted by Levenberg–Marquardt
//! within bounds, from several starts; thresholds follow from the positions. Then each place is
//! tried in the neighbouring gaps. The result is sound ([`law::soundness`]): if the data require a
//! rupture that would create force or energy, the fit is repeated under that constraint and reports
//! so.
//!
//! The residual is compared with the noise of the curve itself: a fit that leaves more has not
//! converged and reports so. If only noise is left, every parameter gets a 95 % interval by profile
//! likelihood, or is reported as undetermined.

mod curve;
mod descent;
mod drops;
mod fit;
mod guess;
mod model;
mod orders;
mod peaks;
mod profile;
mod starts;
mod timed;
mod uncertainty;
mod verdict;
mod words;

use law::axial::{AxialSpec, ForceLaw, LayerOptions};

pub use curve::{Curve, MIN_SAMPLES};
pub use fit::{AskedFit, Fit, Start, fit};
pub use guess::Fresh;
pub use model::{QUANTITIES, Quantity, residual_rms_n};
pub use peaks::Peak;
pub use timed::{TimedCurve, TimedSample, fit_timed, timed_residual_rms_n};
pub use uncertainty::{Interval, ParameterEstimate, ParameterStanding};
pub use verdict::Misfit;

/// Whether a start needs a timed curve: those of laws 3 and 4, and later ones with an option of a
/// layer or of the needle other than stiffening, which keeps its value.
#[must_use]
pub fn needs_times(start: &AxialSpec) -> bool {
    match start.law {
        ForceLaw::Version1 | ForceLaw::Version2 => false,
        ForceLaw::Version3 | ForceLaw::Version4 => true,
        ForceLaw::Version5 => {
            let plain = |options: &LayerOptions| LayerOptions { stiffening_n_per_m2: 0.0, ..options.clone() };
            start.breakaway.is_some() || start.layers.iter().any(|layer| !plain(&layer.options).is_empty())
        }
    }
}

/// Why a curve cannot be fitted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrateError {
    /// A depth or force is not finite.
    #[error("sample {row}: a depth or force is not finite; allowed: finite numbers")]
    NotFinite {
        /// Index of the sample, from 0.
        row: usize,
    },
    /// Too few samples.
    #[error("samples that move: {found}; at least {needed} are needed")]
    TooFew {
        /// Samples that advance or withdraw.
        found: usize,
        /// The required number.
        needed: usize,
    },
    /// Too few samples that go deeper.
    #[error(
        "samples deeper than all previous ones: {found}; at least {needed} are needed, from an insertion in the order \
         of measurement"
    )]
    NoInsertion {
        /// Samples deeper than all before them.
        found: usize,
        /// The required number.
        needed: usize,
    },
    /// More layers than the curve has drops for.
    #[error(
        "drops of at least {least_n:.3} N while the tip advances: {found}; {} are needed for layers: {asked}. Ask for \
         fewer layers, or provide a starting scene that matches the curve",
        asked * per_layer
    )]
    TooFewDrops {
        /// Drops of the curve.
        found: usize,
        /// The requested number of layers.
        asked: usize,
        /// Drops per layer: two with a rim.
        per_layer: usize,
        /// Minimum fall of a drop, in N.
        least_n: f64,
    },
    /// The starting scene has no rupture within the curve.
    #[error("no boundary of the starting scene gives way within the curve's {deepest_mm:.2} mm")]
    StartBeyondCurve {
        /// Depth of the curve, in mm.
        deepest_mm: f64,
    },
    /// The starting scene uses a version of the law that cannot be fitted.
    #[error("the starting scene has law = 1, in which cutting depends on the tick; allowed: law = 2 or 5")]
    OldLaw,
    /// The starting scene may have options, which a curve at a single speed cannot distinguish from
    /// the fitted parameters.
    #[error(
        "the starting scene has options of law 3, which a curve without times cannot distinguish from stiffness and \
         thresholds; allowed: law = 2 or 5 without options but stiffening, or a column t_s"
    )]
    LawOfOptions,
    /// A time does not increase.
    #[error("sample {row}: t_s = {t_s} s does not increase; allowed: increasing times")]
    TimeStandsStill {
        /// Index of the sample, from 0.
        row: usize,
        /// Its time, in s.
        t_s: f64,
    },
    /// A timed curve needs a start with options.
    #[error("the starting scene has law = 1 or 2; allowed with times: law = 3 or later, because options are fitted")]
    TimedLaw,
    /// A timed curve requires a single contactor.
    #[error("the starting scene's tip_to_rim_mm is {tip_to_rim_mm} mm; allowed with times: 0 mm, a needle")]
    TimedRim {
        /// The distance, in mm.
        tip_to_rim_mm: f64,
    },
    /// A single insertion shows only one rotation of the edge.
    #[error(
        "the starting scene has fibres, which a single direction of the edge does not determine; allowed with times: \
         layers without fibres"
    )]
    TimedFibres,
    /// A boundary of the start ruptures together with another.
    #[error(
        "{layer}: its boundary in the starting scene gives way together with another; allowed with times: boundaries \
         that give way one at a time"
    )]
    TimedCascade {
        /// Name of the layer.
        layer: String,
    },
    /// The law rejects the starting scene.
    #[error(transparent)]
    Params(#[from] law::axial::ParamError),
}
