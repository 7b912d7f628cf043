//! Equilibria with difficult materials, meshes and forces.

use nalgebra::Matrix3;
use tissue::volumetric::{Corotational, Effort, MeshSpec3, Patch, Problem3, Volumetric, fit};
use tissue::{ElasticLayer, FieldModel, axisymmetric};

use super::{block, coarse, layer, lower_back, problem};
use crate::slabs::relative_distance_of_models;
use crate::{Measured, largest};

/// Returns the error of a fit on layers, compared with the axisymmetric model fitted to 0.5 %.
fn error(layers: Vec<ElasticLayer>, tolerance: f64) -> Measured {
    let problem = problem(layers);
    let found = fit(&Problem3::flat(&problem), tolerance)?;
    let better = axisymmetric::fit(&problem, 0.005)?;
    Ok(relative_distance_of_models(&problem, &found.model, &better.model))
}

/// A skin of 2 mm that is 100 to 100 000 times as stiff as the tissue below.
pub(super) fn ratio_error() -> Measured {
    let on_soft = |ratio: f64| error(vec![layer(0.002, 1e4 * ratio, 0.45), layer(0.04, 1e4, 0.45)], 0.1);
    let errors: Result<Vec<f64>, _> = [1e2, 1e3, 1e4, 1e5].into_iter().map(on_soft).collect();
    Ok(largest(errors?))
}

pub(super) fn thin_skin_error() -> Measured {
    error(vec![layer(0.0008, 132e3, 0.45), layer(0.039, 198e3, 0.45)], 0.05)
}

pub(super) fn incompressible_error() -> Measured {
    error(lower_back().into_iter().map(|layer| ElasticLayer { poisson_ratio: 0.499, ..layer }).collect(), 0.05)
}

/// A uniform strain ε has the energy V (μ ‖ε‖² + λ/2 tr² ε), independent of the shape of the
/// elements.
pub(super) fn sliver_energy() -> Measured {
    let body = block([0.1, 0.1, 0.001], false)?;
    let gradient = Matrix3::new(1e-3, 2e-3, -1e-3, 5e-4, -2e-3, 1e-3, 3e-3, -1e-3, 2e-3);
    let u_m = body.interpolate_m(|point| gradient * point.coords);
    let found_j = body.linear_energy_j(&u_m, &mut vec![0.0; body.unknowns()]);
    let strain = (gradient + gradient.transpose()) * 0.5;
    let (young, poisson) = (1e5, 0.45);
    let (lambda, mu) = (young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson)));
    let wanted_j = 1e-5 * (mu * strain.norm_squared() + 0.5 * lambda * strain.trace() * strain.trace());
    Ok((found_j / wanted_j - 1.0).abs())
}

/// NaN, infinite, and so large that a product overflows: the last result is kept in each case.
pub(super) fn bad_forces() -> Measured {
    let problem = Problem3::flat(&problem(lower_back()));
    let mut linear = Volumetric::new(&problem, &coarse(&problem))?;
    let patch = Patch::new(&problem, &coarse(&problem))?;
    let mut turning = Corotational::new(patch, None, Effort { iterations: 60, tolerance: 1e-4 })?;
    linear.solve(0.1);
    turning.solve(0.1);
    let (wanted, wanted_turning) = (linear.unknowns_m().to_vec(), turning.motion().u_m().to_vec());
    let mut changed = 0_u32;
    for force_n in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300] {
        linear.solve(force_n);
        turning.solve(force_n);
        changed += u32::from(linear.unknowns_m() != wanted) + u32::from(turning.motion().u_m() != wanted_turning);
    }
    Ok(f64::from(changed))
}

/// Ten minutes of steps at 5 Hz under the same load.
pub(super) fn hold_still() -> Measured {
    let problem = Problem3::flat(&problem(lower_back()));
    let mut linear = Volumetric::new(&problem, &coarse(&problem))?;
    let patch = Patch::new(&problem, &coarse(&problem))?;
    let mut turning = Corotational::new(patch, None, Effort { iterations: 60, tolerance: 1e-4 })?;
    let both = |linear: &Volumetric, turning: &Corotational| {
        [linear.displacement_m(0.0, 0.0)[0], turning.displacement_m(0.0, 0.0)[0]]
    };
    linear.solve(0.3);
    turning.solve(0.3);
    let first = both(&linear, &turning);
    let mut change_m = 0.0;
    for _ in 0..600 * 5 {
        linear.solve(0.3);
        turning.solve(0.3);
        let now = both(&linear, &turning);
        change_m = largest([change_m, (now[0] - first[0]).abs(), (now[1] - first[1]).abs()]);
    }
    Ok(change_m)
}

pub(super) fn oblique_error() -> Measured {
    let oblique = Problem3 { tilt_rad: 60_f64.to_radians(), ..Problem3::flat(&problem(lower_back())) };
    Ok(fit(&oblique, 0.05)?.estimated_relative_error)
}

/// Returns the axial displacement along the needle under 1 N, in m, of layers, on a mesh accurate
/// to 1 %.
fn answer(layers: Vec<ElasticLayer>) -> Result<Vec<f64>, Box<dyn core::error::Error>> {
    let problem = problem(layers);
    let flat = Problem3::flat(&problem);
    let mut model = Volumetric::new(&flat, &MeshSpec3::ladder(&flat)[3])?;
    model.solve(1.0);
    Ok((0..40).map(|at| model.displacement_m(0.0, 1e-3 * f64::from(at))[0]).collect())
}

/// Returns the largest difference of two results, in m.
fn change(a: &[f64], b: &[f64]) -> f64 {
    largest(a.iter().zip(b).map(|(a, b)| (a - b).abs()))
}

pub(super) fn zero_thickness_change() -> Measured {
    let sheet = layer(0.0, 1e9, 0.3);
    let with_sheets = lower_back().into_iter().flat_map(|layer| [sheet, layer]).collect();
    Ok(change(&answer(with_sheets)?, &answer(lower_back())?))
}

/// Two equal layers are equivalent to one; only the mesh has more planes.
pub(super) fn duplicate_change() -> Measured {
    let halves = |whole: ElasticLayer| [ElasticLayer { thickness_m: 0.5 * whole.thickness_m, ..whole }; 2];
    let one = answer(lower_back())?;
    let two = answer(lower_back().into_iter().flat_map(halves).collect())?;
    Ok(change(&one, &two) / largest(two.iter().map(|u| u.abs())))
}
