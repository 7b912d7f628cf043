//! Layers that are difficult for lattices, at rest.

use tissue::mass_spring::{Damping, FittedLattice, Lattice, LatticeError, MassSpring, fit};
use tissue::{ElasticLayer, Problem, axisymmetric};

use super::{RADIUS_M, lower_back, patch, problem};
use crate::slabs::{make_elastic_layer, relative_distance_of_models};
use crate::{Measured, largest};

/// Returns the distance of a lattice that covers the whole problem from finite elements with a
/// Poisson ratio of 1/4.
fn own_error(problem: &Problem, spacing_m: f64) -> Measured {
    let mut quarter = problem.clone();
    quarter.slab.layers.iter_mut().for_each(|layer| layer.poisson_ratio = 0.25);
    let depth_m = quarter.slab.layers.iter().map(|layer| layer.thickness_m).sum();
    let lattice = MassSpring::new(&quarter, &patch(spacing_m, depth_m))?;
    let elements = axisymmetric::fit(&quarter, 1e-3)?.model;
    Ok(relative_distance_of_models(problem, &lattice, &elements))
}

pub(super) fn contrast_error() -> Measured {
    let mut errors = Vec::new();
    for ratio in [1e2, 1e3, 1e4, 1e5] {
        let (stiff, soft) = (make_elastic_layer(2e-3, 1e6, 0.25), make_elastic_layer(4e-3, 1e6 / ratio, 0.25));
        errors.push(own_error(&problem(vec![stiff, soft]), 0.5e-3)?);
        errors.push(own_error(&problem(vec![soft, stiff]), 0.5e-3)?);
    }
    Ok(largest(errors))
}

/// A skin of 0.8 mm refuses cells of 2 mm, and accepts the size that the error suggests.
pub(super) fn thin_skin_refused() -> Measured {
    let slab = problem(lower_back()).slab;
    let refusal = Lattice::new(&slab, &patch(2e-3, RADIUS_M), Damping::default());
    let Err(LatticeError::Spacing { layer: 0, nearest_m, .. }) = refusal else { return Ok(1.0) };
    let nearest = Lattice::new(&slab, &patch(nearest_m, RADIUS_M), Damping::default());
    Ok(f64::from(u8::from(nearest.is_err())))
}

pub(super) fn thin_skin_error() -> Measured {
    let mut layers = lower_back();
    layers.truncate(2);
    own_error(&problem(layers), 0.4e-3)
}

/// A soft and nearly incompressible body, and its fit at a tolerance of 1 %.
fn incompressible() -> Result<(Problem, FittedLattice), LatticeError> {
    let problem = problem(vec![make_elastic_layer(8e-3, 5e4, 0.499)]);
    let fitted = fit(&problem, 0.01)?;
    Ok((problem, fitted))
}

pub(super) fn incompressible_estimate() -> Measured {
    let (problem, fitted) = incompressible()?;
    let truth = axisymmetric::fit(&problem, 1e-3)?.model;
    let error = relative_distance_of_models(&problem, &fitted.model, &truth);
    Ok(error / fitted.estimated_relative_error)
}

pub(super) fn incompressible_met() -> Measured {
    let (_, fitted) = incompressible()?;
    Ok(f64::from(u8::from(fitted.met || fitted.floor < 0.01)))
}

/// Cells with a height of a tenth of their width would need springs of negative stiffness.
pub(super) fn sliver_refused() -> Measured {
    let slab = problem(vec![make_elastic_layer(1e-4, 1e5, 0.25), make_elastic_layer(7.9e-3, 1e5, 0.25)]).slab;
    let refused = matches!(
        Lattice::new(&slab, &patch(1e-3, RADIUS_M), Damping::default()),
        Err(LatticeError::Spacing { layer: 0, nearest_m, .. }) if nearest_m < 1.5e-4
    );
    Ok(f64::from(u8::from(!refused)))
}

pub(super) fn coincident_answer() -> Measured {
    let (skin, fat) = (make_elastic_layer(1e-3, 132e3, 0.45), make_elastic_layer(6e-3, 33.1e3, 0.45));
    let sheet = ElasticLayer { thickness_m: 0.0, youngs_modulus_pa: 1e9, ..skin };
    let half = ElasticLayer { thickness_m: 3e-3, ..fat };
    let whole = problem(vec![skin, fat]);
    let wanted = MassSpring::new(&whole, &patch(1e-3, 7e-3))?;
    let mut changes = Vec::new();
    for layers in [vec![sheet, skin, sheet, sheet, fat], vec![skin, half, half]] {
        let answer = MassSpring::new(&problem(layers), &patch(1e-3, 7e-3))?;
        changes.push(relative_distance_of_models(&whole, &answer, &wanted));
    }
    Ok(largest(changes))
}
