//! The closed forms and hard cases of this model, each a function that returns what it measures.
//!
//! Every one is a model of its own, built from scratch; the tests state the bounds.

use std::f64::consts::PI;

use super::basis::fine_rule;
use super::{Axisymmetric, AxisymmetricError, MeshSpec, Side, fit};
use crate::tissue::{ElasticLayer, FieldModel, Load, LoadKind, Problem, Slab};

/// Order at the load of the meshes that are to be exact but for what is measured.
const EXACT_LEVEL: f64 = 10.0;

/// A layer of a thickness in m, a modulus in Pa and a Poisson ratio.
#[must_use]
pub fn layer(thickness_m: f64, youngs_modulus_pa: f64, poisson_ratio: f64) -> ElasticLayer {
    ElasticLayer { thickness_m, youngs_modulus_pa, poisson_ratio, density_kg_per_m3: 1000.0 }
}

/// A contactor of radius 1 mm at a depth of layers 50 mm wide, asked where the reference cases are: at each boundary,
/// out to 20 mm.
#[must_use]
pub fn contactor(layers: Vec<ElasticLayer>, depth_m: f64) -> Problem {
    let slab = Slab { layers, radius_m: 0.05 };
    let sample_depth_m = slab.boundaries_m()[..slab.layers.len()].to_vec();
    let sample_r_m = (0..=40).map(|at| 0.0005 * f64::from(at)).collect();
    Problem { slab, load: Load { kind: LoadKind::Contactor { depth_m }, radius_m: 0.001 }, sample_r_m, sample_depth_m }
}

/// A block as deep as it is wide, pushed on its skin: what a half-space becomes as it grows.
fn block(radius_m: f64, modulus_pa: f64, poisson: f64, load_radius_m: f64) -> Problem {
    let slab = Slab { layers: vec![layer(radius_m, modulus_pa, poisson)], radius_m };
    let load = Load { kind: LoadKind::Contactor { depth_m: 0.0 }, radius_m: load_radius_m };
    Problem { slab, load, sample_r_m: vec![], sample_depth_m: vec![] }
}

fn exact(problem: &Problem) -> Result<Axisymmetric, AxisymmetricError> {
    Axisymmetric::new(problem, &MeshSpec::graded(problem, EXACT_LEVEL))
}

/// How far the displacement under a Gaussian load falls short of the half-space's (1 − ν²) F/(E a √π), as a share of
/// it, on a block of so many load radii.
///
/// # Errors
/// As for [`Axisymmetric::new`].
pub fn half_space_shortfall(radii: f64) -> Result<f64, AxisymmetricError> {
    let (e, nu, a) = (50e3, 0.3, 0.001);
    let model = exact(&block(radii * a, e, nu, a))?;
    Ok(1.0 - (1.0 / model.stiffness_n_per_m()) / ((1.0 - nu * nu) / (e * a * PI.sqrt())))
}

/// The displacement in m at 10 mm from 1 N on 50 kPa, ν 0.45, in a block of a radius in m. Boussinesq's half-space has
/// F(1 − ν²)/(πEr) = 0.5077 mm.
///
/// # Errors
/// As for [`Axisymmetric::new`].
pub fn boussinesq_m(radius_m: f64) -> Result<f64, AxisymmetricError> {
    let model = exact(&block(radius_m, 50e3, 0.45, 0.001))?;
    Ok(-model.displacement_m(0.01, 0.0)[0])
}

/// Stiffness in N/m of a rigid flat punch of 1.27 mm diameter on a block of 50 kPa, ν 0.45, of a radius in m. The
/// half-space has 2aE/(1 − ν²) = 79.62 N/m.
///
/// The punch is not meshed. Its pressure p = F/(2πa √(a² − r²)) is known, and a narrow Gaussian load well inside it sees
/// it as rigid, so by Betti's theorem the punch sinks by ∫ p u dA, u the answer to that load of 1 N. With r = a sin θ
/// the integral is ∫ u(a sin θ) sin θ dθ from 0 to π/2, without a singularity.
///
/// # Errors
/// As for [`Axisymmetric::new`].
pub fn flat_punch_n_per_m(radius_m: f64) -> Result<f64, AxisymmetricError> {
    let a = 0.5 * 0.00127;
    let model = exact(&block(radius_m, 50e3, 0.45, a / 6.0))?;
    let sinks_by = |&(x, weight): &(f64, f64)| {
        let sine = libm::sin(0.25 * PI * (1.0 + x));
        -0.25 * PI * weight * sine * model.displacement_m(a * sine, 0.0)[0]
    };
    Ok(1.0 / fine_rule().iter().map(sinks_by).sum::<f64>())
}

/// Largest relative error of the displacement at the boundaries of a column of three layers in a smooth tube, pressed
/// evenly: Σ d/(M A), M = E(1 − ν)/((1 + ν)(1 − 2ν)) of what is below.
///
/// # Errors
/// As for [`Axisymmetric::new`].
pub fn layered_column() -> Result<f64, AxisymmetricError> {
    let layers = vec![layer(0.002, 1e6, 0.3), layer(0.01, 5e3, 0.45), layer(0.03, 60e3, 0.499)];
    column_error(layers, &[0.0, 0.002, 0.012])
}

/// Largest relative error of a linear displacement, anywhere in a column whose elements differ in size and order: the
/// patch test.
///
/// # Errors
/// As for [`Axisymmetric::new`].
pub fn patch() -> Result<f64, AxisymmetricError> {
    column_error(vec![layer(0.03, 50e3, 0.3)], &[0.0, 0.0003, 0.004, 0.0111, 0.02, 0.0299])
}

fn column_error(layers: Vec<ElasticLayer>, depths_m: &[f64]) -> Result<f64, AxisymmetricError> {
    let mut problem = contactor(layers, 0.0);
    problem.slab.radius_m = 0.01;
    problem.sample_r_m.clear();
    let mesh = MeshSpec::graded(&problem, 6.0);
    // A Gaussian a million times wider than the column is even across it.
    problem.load.radius_m = 1e6 * problem.slab.radius_m;
    let pressure_pa = 1.0 / (PI * problem.load.radius_m * problem.load.radius_m);
    let model = Axisymmetric::with_side(&problem, &mesh, Side::Sliding)?;
    let boundaries_m = problem.slab.boundaries_m();
    let sinks_by = |depth_m: f64| -> f64 {
        let below = problem.slab.layers.iter().zip(&boundaries_m[1..]).map(|(layer, &base_m)| {
            let nu = layer.poisson_ratio;
            let confined_pa = layer.youngs_modulus_pa * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
            pressure_pa * (base_m - depth_m).clamp(0.0, layer.thickness_m) / confined_pa
        });
        below.sum()
    };
    let radii_m = [0.0, 0.0017, 0.006, 0.01];
    let places = depths_m.iter().flat_map(|&depth_m| radii_m.map(|r_m| (r_m, depth_m)));
    let error = |(r_m, depth_m): (f64, f64)| {
        let [axial_m, radial_m] = model.displacement_m(r_m, depth_m);
        (axial_m + sinks_by(depth_m)).hypot(radial_m) / sinks_by(depth_m)
    };
    Ok(places.map(error).fold(0.0, f64::max))
}

/// Relative L2 distance of the axial displacement at the problem's sample points from that of another model.
#[must_use]
pub fn distance(problem: &Problem, model: &impl FieldModel, truth: &impl FieldModel) -> f64 {
    let (mut wrong, mut whole) = (0.0, 0.0);
    for &depth_m in &problem.sample_depth_m {
        for &r_m in &problem.sample_r_m {
            let [[is, _], [should, _]] = [model.displacement_m(r_m, depth_m), truth.displacement_m(r_m, depth_m)];
            wrong += (is - should) * (is - should);
            whole += should * should;
        }
    }
    (wrong / whole).sqrt()
}

/// A far finer mesh than any that is chosen: the top of the ladder, twice graded to the side, with every strip halved.
///
/// # Errors
/// As for [`Axisymmetric::new`].
pub fn overkill(problem: &Problem) -> Result<Axisymmetric, AxisymmetricError> {
    Axisymmetric::new(problem, &MeshSpec::graded(problem, EXACT_LEVEL).graded_to_side().graded_to_side().halved())
}

/// True error, against [`overkill`], and estimate of what is fitted to a tolerance.
///
/// # Errors
/// As for [`fit`].
pub fn fitted_error(problem: &Problem, tolerance: f64) -> Result<[f64; 2], AxisymmetricError> {
    let fitted = fit(problem, tolerance)?;
    Ok([distance(problem, &fitted.model, &overkill(problem)?), fitted.estimated_relative_error])
}

/// Relative difference between what load one does where load two acts, and what load two does where load one acts,
/// both averaged with the Gaussian of a contactor: nothing, says Betti, though the two are solved on different meshes.
///
/// # Errors
/// As for [`Axisymmetric::new`].
pub fn betti(layers: &[ElasticLayer], depths_m: [f64; 2]) -> Result<f64, AxisymmetricError> {
    let felt = |acts_m: f64, felt_m: f64| -> Result<f64, AxisymmetricError> {
        let problem = contactor(layers.to_vec(), acts_m);
        let (model, a) = (exact(&problem)?, problem.load.radius_m);
        // The substitution s = 1 − exp(−(r/a)²) turns the weighted integral into a plain one over (0, 1).
        let at = |&(x, weight): &(f64, f64)| {
            let r_m = a * (-libm::log(0.5 * (1.0 - x))).sqrt();
            0.5 * weight * model.displacement_m(r_m, felt_m)[0]
        };
        Ok(fine_rule().iter().map(at).sum())
    };
    let [one_m, two_m] = depths_m;
    Ok((felt(one_m, two_m)? / felt(two_m, one_m)? - 1.0).abs())
}
