//! Mass-spring: the paper's model. A lattice over the layers, its springs calibrated from their moduli.
//!
//! Springs are true central forces: a rotation costs nothing, whatever its angle, and a stretch pulls along the spring
//! where it is now. Central forces make λ = μ, a Poisson ratio of 1/4 whatever a layer's own is, and that is a floor
//! below which no lattice gets.
//!
//! A [`Lattice`] is stepped explicitly ([`explicit`]) or implicitly ([`implicit`]); [`MassSpring`] answers with the rest
//! of its linearisation, as every [`FieldModel`](super::FieldModel) does. [`fit`] finds the coarsest that is accurate enough.

mod calibration;
pub mod explicit;
mod fit;
mod grid;
pub mod implicit;
mod kernel;
mod lanes;
mod lattice;
mod laws;
mod links;
mod load;
mod model;
mod motion;
mod puncture;
mod relax;
mod response;

pub use fit::{FittedLattice, fit, fit_by, fit_rung};
pub use grid::{LatticePatch, LatticeSymmetry, MAX_UNKNOWNS};
pub use lattice::{Damping, Lattice};
use law::axial::ParamError;
pub use load::NodalLoad;
pub use model::MassSpring;
pub use motion::{LatticeMotion, MAX_FORCE_N};
pub use puncture::{LatticePuncture, OpenedSprings};
pub use response::{NodeForce, Response};

use super::axisymmetric::AxisymmetricError;

/// Why a lattice cannot be made or stepped, and the nearest that can be done.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LatticeError {
    /// A number out of range.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// There is nothing to judge a lattice by.
    #[error(transparent)]
    Judge(#[from] AxisymmetricError),
    /// A layer that no whole number of near-cubic cells fills.
    #[error(
        "layers[{layer}] of {thickness_m} m cannot be split into cells near a cube: spacing_m must be {nearest_m} m or \
         another that suits all layers"
    )]
    Spacing {
        /// Which layer, from 0 at the skin.
        layer: usize,
        /// Its thickness, in m.
        thickness_m: f64,
        /// The widest spacing, not above the one asked for, that suits all layers, in m.
        nearest_m: f64,
    },
    /// More nodes than can be held.
    #[error(
        "spacing_m = {spacing_m} m makes about {unknowns:.0} unknowns: must be at least {nearest_m} m on this patch"
    )]
    TooLarge {
        /// The spacing asked for, in m.
        spacing_m: f64,
        /// Degrees of freedom it would make.
        unknowns: f64,
        /// The narrowest spacing that can be held, in m.
        nearest_m: f64,
    },
    /// An explicit step that is not stable.
    #[error("step_s = {step_s} s: must be a number from 0 to the stable step of {stable_s} s")]
    Step {
        /// The step asked for, in s.
        step_s: f64,
        /// The longest stable one, in s.
        stable_s: f64,
    },
    /// A time that cannot be advanced by.
    #[error("time_s = {time_s} s: must be a number from 0 to {longest_s} s")]
    Time {
        /// The time asked for, in s.
        time_s: f64,
        /// The longest, in s.
        longest_s: f64,
    },
}
