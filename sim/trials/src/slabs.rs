//! Layers and loads for the trials of the tissue, and distances between models.

use tissue::axisymmetric::{Axisymmetric, AxisymmetricError, MAX_ORDER, MeshSpec};
use tissue::{ElasticLayer, FieldModel, Load, LoadKind, Problem, Slab, relative_distance};

/// Creates a layer with a thickness in m, a modulus in Pa and a Poisson ratio.
#[must_use]
pub fn make_elastic_layer(thickness_m: f64, youngs_modulus_pa: f64, poisson_ratio: f64) -> ElasticLayer {
    ElasticLayer { thickness_m, youngs_modulus_pa, poisson_ratio, density_kg_per_m3: 1000.0 }
}

/// Creates the problem of a contactor of radius 1 mm at a depth in layers 50 mm wide, sampled like
/// the reference cases: at each boundary, out to 20 mm.
#[must_use]
pub fn ask_contactor(layers: Vec<ElasticLayer>, depth_m: f64) -> Problem {
    let slab = Slab { layers, radius_m: 0.05 };
    let sample_depth_m = slab.boundaries_m()[..slab.layers.len()].to_vec();
    let sample_r_m = (0..=40).map(|at| 0.0005 * f64::from(at)).collect();
    Problem { slab, load: Load { kind: LoadKind::Contactor { depth_m }, radius_m: 0.001 }, sample_r_m, sample_depth_m }
}

/// Solves with the finest mesh of the axisymmetric model's ladder.
///
/// # Errors
/// As for [`Axisymmetric::new`].
pub fn solve_exactly(problem: &Problem) -> Result<Axisymmetric, AxisymmetricError> {
    Axisymmetric::new(problem, &MeshSpec::graded(problem, MAX_ORDER as f64))
}

/// Solves with a far finer mesh than any that is selected: the finest of the ladder, graded twice
/// to the side, with every strip halved.
///
/// # Errors
/// As for [`Axisymmetric::new`].
pub fn solve_beyond_need(problem: &Problem) -> Result<Axisymmetric, AxisymmetricError> {
    let top = MeshSpec::graded(problem, MAX_ORDER as f64);
    Axisymmetric::new(problem, &top.graded_to_side().graded_to_side().halved())
}

/// Returns the relative L2 distance of the axial displacement at the problem's sample points from
/// that of another model.
#[must_use]
pub fn relative_distance_of_models(problem: &Problem, model: &dyn FieldModel, truth: &dyn FieldModel) -> f64 {
    relative_distance(&problem.axial_m(model), &problem.axial_m(truth))
}
