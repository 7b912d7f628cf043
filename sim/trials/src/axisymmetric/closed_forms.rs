//! Comparison of the axisymmetric model with closed forms of elasticity.

use std::f64::consts::PI;

use tissue::axisymmetric::{Axisymmetric, AxisymmetricError, MeshSpec, Side};
use tissue::quadrature::gauss_rule;
use tissue::{ElasticLayer, FieldModel, Load, LoadKind, Problem, Slab};

use crate::slabs::{ask_contactor, make_elastic_layer, solve_beyond_need, solve_exactly};
use crate::{Measured, largest};

/// Number of quadrature points for integrals over a load; the error is 1e-9.
const POINTS: usize = 32;

/// A block with equal depth and width, loaded on its skin; approaches a half-space with increasing
/// size.
fn block(radius_m: f64, modulus_pa: f64, poisson: f64, load_radius_m: f64) -> Problem {
    let slab = Slab { layers: vec![make_elastic_layer(radius_m, modulus_pa, poisson)], radius_m };
    let load = Load { kind: LoadKind::Contactor { depth_m: 0.0 }, radius_m: load_radius_m };
    Problem { slab, load, sample_r_m: vec![], sample_depth_m: vec![] }
}

/// Returns the relative shortfall of the displacement under a Gaussian load from the half-space's
/// (1 − ν²) F/(E a √π), on a block with a size of `radii` load radii.
fn half_space_shortfall(radii: f64) -> Result<f64, AxisymmetricError> {
    let (e, nu, a) = (50e3, 0.3, 0.001);
    let model = solve_exactly(&block(radii * a, e, nu, a))?;
    Ok(1.0 - (1.0 / model.stiffness_n_per_m()) / ((1.0 - nu * nu) / (e * a * PI.sqrt())))
}

pub(super) fn half_space_error() -> Measured {
    Ok((half_space_shortfall(50.0)? - 0.017).abs())
}

/// The shortfall is proportional to 1/R.
pub(super) fn half_space_rate() -> Measured {
    let shortfalls: Result<Vec<f64>, _> = [50.0, 100.0, 200.0, 400.0].into_iter().map(half_space_shortfall).collect();
    Ok(largest(shortfalls?.windows(2).map(|pair| (pair[0] / pair[1] - 2.0).abs())))
}

/// 1 N on 50 kPa, ν 0.45: F(1 − ν²)/(πEr) = 0.5077 mm at 10 mm.
pub(super) fn boussinesq_error() -> Measured {
    let model = solve_exactly(&block(5.0, 50e3, 0.45, 0.001))?;
    Ok((-model.displacement_m(0.01, 0.0)[0] / 0.5077e-3 - 1.0).abs())
}

/// A rigid punch of 1.27 mm diameter on 50 kPa, ν 0.45: 2aE/(1 − ν²) = 79.62 N/m.
///
/// The punch is not meshed. Its pressure p = F/(2πa √(a² − r²)) is known, and it is rigid compared
/// with a narrow Gaussian load well inside it, so by Betti's theorem the punch is displaced by ∫ p
/// u dA, where u is the response to that load of 1 N. With r = a sin θ the integral is ∫ u(a sin θ)
/// sin θ dθ from 0 to π/2, without a singularity.
pub(super) fn punch_error() -> Measured {
    let a = 0.5 * 0.00127;
    let model = solve_exactly(&block(5.0, 50e3, 0.45, a / 6.0))?;
    let sinks_by = |(x, weight): (f64, f64)| {
        let sine = libm::sin(0.25 * PI * (1.0 + x));
        -0.25 * PI * weight * sine * model.displacement_m(a * sine, 0.0)[0]
    };
    let stiffness_n_per_m = 1.0 / gauss_rule(POINTS).into_iter().map(sinks_by).sum::<f64>();
    Ok((stiffness_n_per_m / 79.62 - 1.0).abs())
}

/// Three layers in a frictionless tube under uniform pressure: Σ d/(M A), M = E(1 − ν)/((1 + ν)(1 −
/// 2ν)), summed over the layers below.
pub(super) fn column_error() -> Measured {
    confined_error(
        vec![
            make_elastic_layer(0.002, 1e6, 0.3),
            make_elastic_layer(0.01, 5e3, 0.45),
            make_elastic_layer(0.03, 60e3, 0.499),
        ],
        &[0.0, 0.002, 0.012],
    )
}

/// A linear displacement, at any point of a column whose elements differ in size and order.
pub(super) fn patch_error() -> Measured {
    confined_error(vec![make_elastic_layer(0.03, 50e3, 0.3)], &[0.0, 0.0003, 0.004, 0.0111, 0.02, 0.0299])
}

/// Returns the largest relative error at these depths of a column of layers in a frictionless tube
/// under uniform pressure.
pub(super) fn confined_error(layers: Vec<ElasticLayer>, depths_m: &[f64]) -> Measured {
    let mut problem = ask_contactor(layers, 0.0);
    problem.slab.radius_m = 0.01;
    problem.sample_r_m.clear();
    let mesh = MeshSpec::graded(&problem, 6.0);
    // A Gaussian a million times wider than the column is uniform across it.
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
        libm::hypot(axial_m + sinks_by(depth_m), radial_m) / sinks_by(depth_m)
    };
    Ok(largest(places.map(error)))
}

/// Compares the displacement by load one at load two with that by load two at load one, both
/// averaged with the Gaussian of a contactor: equal by Betti's theorem, although the two are solved
/// on different meshes.
pub(super) fn mutual_error() -> Measured {
    let layers = [
        make_elastic_layer(0.0008, 132e3, 0.45),
        make_elastic_layer(0.0084, 33.1e3, 0.45),
        make_elastic_layer(0.039, 198e3, 0.45),
    ];
    let loaded = |depth_m: f64| {
        let problem = ask_contactor(layers.to_vec(), depth_m);
        Ok::<_, AxisymmetricError>((solve_beyond_need(&problem)?, problem.load.radius_m, depth_m))
    };
    let loads = [loaded(0.0)?, loaded(0.0008)?, loaded(0.0092)?];
    let felt = |by: usize, of: usize| -> f64 {
        let ((_, a, felt_m), (model, ..)) = (&loads[by], &loads[of]);
        // Integrate over six radii; the rest of the load is 2e-16.
        let at = |(x, weight): (f64, f64)| {
            let radii = 3.0 * (1.0 + x);
            6.0 * weight * radii * libm::exp(-radii * radii) * model.displacement_m(a * radii, *felt_m)[0]
        };
        gauss_rule(POINTS).into_iter().map(at).sum()
    };
    Ok(largest([(0, 1), (0, 2), (1, 2)].map(|(one, two)| (felt(one, two) / felt(two, one) - 1.0).abs())))
}
