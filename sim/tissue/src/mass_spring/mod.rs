//! Mass-spring: the paper's model. A lattice over the layers, its springs calibrated from their
//! moduli.
//!
//! Springs exert true central forces: a rotation costs no energy at any angle, and a stretched
//! spring pulls along its current direction. Central forces make λ = μ, a Poisson ratio of 1/4
//! in every layer, and that is an error floor for every lattice.
//!
//! A [`Lattice`] is stepped explicitly ([`explicit`]) or implicitly ([`implicit`]); [`MassSpring`]
//! solves for the equilibrium of its linearisation, as every [`FieldModel`](super::FieldModel)
//! does. [`fit`] finds the coarsest that is accurate enough.

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

/// Why a lattice cannot be made or stepped, and the nearest feasible value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LatticeError {
    /// A number out of range.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The reference solution cannot be computed.
    #[error(transparent)]
    Judge(#[from] AxisymmetricError),
    /// A layer cannot be filled by a whole number of near-cubic cells.
    #[error(
        "layers[{layer}] of {thickness_m} m cannot be split into cells near a cube: spacing_m must be {nearest_m} m or \
         another that suits all layers"
    )]
    Spacing {
        /// Index of the layer, from 0 at the skin.
        layer: usize,
        /// Its thickness, in m.
        thickness_m: f64,
        /// The widest spacing, up to the requested one, that suits all layers, in m.
        nearest_m: f64,
    },
    /// More nodes than the limit.
    #[error(
        "spacing_m = {spacing_m} m makes about {unknowns:.0} unknowns: must be at least {nearest_m} m on this patch"
    )]
    TooLarge {
        /// The requested spacing, in m.
        spacing_m: f64,
        /// The resulting number of degrees of freedom.
        unknowns: f64,
        /// The narrowest feasible spacing, in m.
        nearest_m: f64,
    },
    /// An explicit step that is not stable.
    #[error("step_s = {step_s} s: must be a number from 0 to the stable step of {stable_s} s")]
    Step {
        /// The requested step, in s.
        step_s: f64,
        /// The longest stable one, in s.
        stable_s: f64,
    },
    /// A time that is too long or invalid.
    #[error("time_s = {time_s} s: must be a number from 0 to {longest_s} s")]
    Time {
        /// The requested time, in s.
        time_s: f64,
        /// The longest allowed time, in s.
        longest_s: f64,
    },
}
