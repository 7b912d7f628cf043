//! The deforming tissue: layered linear elasticity under a needle, in three models of known error;
//! the field that follows the needle; and the fit of layers to a measured curve.
//!
//! Pure, like the law, but preparation before an attempt may take time. The three models solve the
//! same [`Problem`]: flat bonded layers, clamped at the base and the side, under one [`Load`].
//! Depths count downwards from the skin; displacements are along `+z`, out of the body, so that a
//! push into the body moves the tissue by a negative amount.

pub mod answer;
pub mod axisymmetric;
pub mod calibrate;
pub mod follow;
pub mod mass_spring;
pub mod multifrontal;
pub mod planner;
mod problem;
pub mod quadrature;
mod specimen;
pub mod volumetric;

pub use law::Judging;
pub use problem::{ElasticLayer, Load, LoadKind, Model, Problem, Sampled, Slab, relative_distance};
pub use specimen::{Specimen, SpecimenError, SpecimenSpec};

/// One load on one slab, prepared for repeated solves.
pub trait FieldModel {
    /// Which model this is.
    fn model(&self) -> Model;

    /// Number of unknowns of a solve or a step.
    fn unknowns(&self) -> usize;

    /// Memory of the model, in bytes.
    fn bytes(&self) -> usize;

    /// Solves for a load of this magnitude, in N; positive pushes into the body. A static model
    /// solves again, a dynamic one makes one step. Never allocates.
    fn solve(&mut self, force_n: f64);

    /// Axial and radial displacement of the last solution, in m, at a radius and a depth in m; zero
    /// outside the tissue. Never allocates.
    fn displacement_m(&self, r_m: f64, depth_m: f64) -> [f64; 2];
}
