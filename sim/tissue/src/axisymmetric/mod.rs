//! Finite elements in (r, z): a perpendicular needle in flat layers, where two dimensions are
//! equivalent to three.
//!
//! Tensor-product elements of high order on a few strips that grow away from the load. The field is
//! smooth inside a layer, so the error falls exponentially with the order; orders from 2 up do not
//! lock near incompressibility; and the unknowns inside an element are eliminated before they meet
//! any other. [`fit`] finds the cheapest mesh for a tolerance and estimates its error.
//!
//! An oblique needle takes two harmonics on the same mesh, [`Oblique`]; [`fit_oblique`] finds their
//! mesh.

mod assembly;
mod basis;
mod element;
mod fit;
mod fit_first;
mod grading;
mod judge;
mod load;
mod mesh;
mod model;
mod oblique;
mod oblique_fit;
mod pushes;
mod sideways;
mod superposed;
mod trim;

pub use basis::MAX_ORDER;
pub use fit::{FittedAxisymmetric, fit, fit_by, fit_rung};
use law::axial::ParamError;
pub use mesh::{MeshSpec, Strip};
pub use model::Axisymmetric;
pub use oblique::Oblique;
pub(crate) use oblique_fit::each_along_needle_m;
pub use oblique_fit::{Along, AlongAngles, FittedOblique, along_needle, along_needle_at, fit_oblique, fit_oblique_by};
pub use superposed::Superposed;

use super::multifrontal::NotPositiveDefinite;

/// Why no model can be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AxisymmetricError {
    /// A number of the problem or of the mesh is out of its range.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The contrasts between the layers are beyond what double precision resolves.
    #[error(transparent)]
    Singular(#[from] NotPositiveDefinite),
}

/// Boundary condition at the side r = R.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// All displacements are zero.
    Clamped,
    /// The tissue slides along a smooth wall: a column in a tube, which has a closed form.
    Sliding,
}
