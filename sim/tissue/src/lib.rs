//! The deforming tissue: layered linear elasticity under a needle, by three models of known error; the field that follows the needle;
//! and the fit of layers to a measured curve.
//!
//! Pure, as the law is, but it may take its time before an attempt. The three models answer the same question, a [`Problem`]:
//! flat bonded layers, clamped at the base and the side, pushed by one [`Load`]. Depths count downwards from the skin;
//! displacements are along `+z`, out of the body, so that a push into the body moves the tissue by a negative amount.

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

/// One load on one slab, ready to be answered again and again.
pub trait FieldModel {
    /// Which model this is.
    fn model(&self) -> Model;

    /// Unknowns that a solve or a step finds.
    fn unknowns(&self) -> usize;

    /// Bytes that the model holds.
    fn bytes(&self) -> usize;

    /// Answers a load of this size, in N; positive pushes into the body. One re-solve of a static model, one step of
    /// another. Never allocates.
    fn solve(&mut self, force_n: f64);

    /// Axial and radial displacement of the last answer, in m, at a radius and a depth in m. Never allocates.
    /// Outside the tissue it is zero.
    fn displacement_m(&self, r_m: f64, depth_m: f64) -> [f64; 2];
}
