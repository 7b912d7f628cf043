//! Layers that are difficult for finite elements: high contrast, near incompressibility, slivers
//! and zero thickness.

use tissue::axisymmetric::{Axisymmetric, AxisymmetricError, FittedAxisymmetric, MeshSpec, fit};
use tissue::{ElasticLayer, Problem};

use crate::slabs::{ask_contactor, make_elastic_layer, relative_distance_of_models, solve_beyond_need};
use crate::{Measured, largest};

const TOLERANCE: f64 = 1e-3;

/// The stiffness ratios of the case.
const RATIOS: [f64; 4] = [1e2, 1e3, 1e4, 1e5];

/// A load on the upper boundary of a layer that is `ratio` times as stiff as its neighbours.
fn contrast(ratio: f64) -> Problem {
    let (outer, inner) = if ratio > 1.0 { (1e4, 1e4 * ratio) } else { (1e4 / ratio, 1e4) };
    ask_contactor(
        vec![
            make_elastic_layer(0.002, outer, 0.45),
            make_elastic_layer(0.01, inner, 0.48),
            make_elastic_layer(0.03, outer, 0.45),
        ],
        0.002,
    )
}

/// Returns the true error of a fit to the tolerance; infinite if the tolerance is not met.
fn fitted_error(problem: &Problem) -> Result<f64, AxisymmetricError> {
    let FittedAxisymmetric { model, met, .. } = fit(problem, TOLERANCE)?;
    Ok(if met { relative_distance_of_models(problem, &model, &solve_beyond_need(problem)?) } else { f64::INFINITY })
}

/// Returns the largest error.
fn worst(problems: impl IntoIterator<Item = Problem>) -> Measured {
    let errors: Result<Vec<f64>, _> = problems.into_iter().map(|problem| fitted_error(&problem)).collect();
    Ok(largest(errors?))
}

pub(super) fn soft_within_error() -> Measured {
    worst(RATIOS.map(|ratio| contrast(1.0 / ratio)))
}

pub(super) fn stiff_within_error() -> Measured {
    worst(RATIOS.map(contrast))
}

/// For both signs of the contrast, at the ends of the range.
pub(super) fn contrast_estimate() -> Measured {
    let factor = |ratio: f64| -> Measured {
        let problem = contrast(ratio);
        let fitted = fit(&problem, TOLERANCE)?;
        let error = problem.sampled(&fitted.model).distance(&problem.sampled(&solve_beyond_need(&problem)?));
        Ok(largest([error / fitted.estimated_relative_error, fitted.estimated_relative_error / error]))
    };
    let factors: Result<Vec<f64>, _> = [1e-5, 1e-2, 1e2, 1e5].into_iter().map(factor).collect();
    Ok(largest(factors?))
}

/// A stiff skin on muscle; the skin's thickness is a fiftieth of the depth.
pub(super) fn skin_error() -> Measured {
    worst([0.0, 0.0008].map(|depth_m| {
        ask_contactor(vec![make_elastic_layer(0.0008, 132e3, 0.45), make_elastic_layer(0.039, 198e3, 0.45)], depth_m)
    }))
}

fn skin_on_fat(poisson_ratio: f64) -> Problem {
    ask_contactor(
        vec![make_elastic_layer(0.002, 1e6, poisson_ratio), make_elastic_layer(0.04, 2e4, poisson_ratio)],
        0.0,
    )
}

pub(super) fn incompressible_error() -> Measured {
    worst([skin_on_fat(0.499)])
}

/// Linear elements would be wrong by tens of per cent (locking).
pub(super) fn incompressible_locking() -> Measured {
    let error = |poisson_ratio: f64| -> Measured {
        let problem = skin_on_fat(poisson_ratio);
        let model = Axisymmetric::new(&problem, &MeshSpec::graded(&problem, 7.0).graded_to_side())?;
        Ok(relative_distance_of_models(&problem, &model, &solve_beyond_need(&problem)?))
    };
    Ok(error(0.499)? / error(0.45)?)
}

/// Samples the layers only at the skin, so that all versions of a problem have the same sample
/// points.
fn at_skin(layers: Vec<ElasticLayer>) -> Problem {
    let mut problem = ask_contactor(layers, 0.0);
    problem.sample_depth_m.truncate(1);
    problem
}

/// Returns the distance between the fits of two problems.
fn change(one: &Problem, other: &Problem) -> Measured {
    Ok(relative_distance_of_models(one, &fit(one, TOLERANCE)?.model, &fit(other, TOLERANCE)?.model))
}

/// Both fits have a tolerance of 0.1 %; a mesh around a sliver must be as accurate as one without
/// it.
pub(super) fn film_error() -> Measured {
    let whole = at_skin(vec![make_elastic_layer(0.03, 2e4, 0.45)]);
    let film = at_skin(vec![
        make_elastic_layer(0.002, 2e4, 0.45),
        make_elastic_layer(1e-6, 2e4, 0.45),
        make_elastic_layer(0.027_999, 2e4, 0.45),
    ]);
    change(&whole, &film)
}

/// A linear field in a column with a film, which the elements must reproduce exactly except for
/// rounding.
pub(super) fn film_patch() -> Measured {
    let layers = vec![
        make_elastic_layer(0.002, 1e5, 0.3),
        make_elastic_layer(1e-6, 2e4, 0.45),
        make_elastic_layer(0.02, 6e4, 0.48),
    ];
    super::closed_forms::confined_error(layers, &[0.0, 0.001, 0.002, 0.002_001, 0.01])
}

/// An element that ends before its start, at its start, at the axis, at infinity or at NaN.
pub(super) fn inverted_accepted() -> Measured {
    let problem = ask_contactor(vec![make_elastic_layer(0.03, 2e4, 0.45)], 0.0);
    let good = MeshSpec::graded(&problem, 4.0);
    let accepted = |end_m: f64| {
        let [mut radial, mut axial] = [good.clone(), good.clone()];
        radial.radial[1].end_m = end_m;
        axial.axial[1].end_m = end_m;
        [radial, axial].iter().filter(|mesh| Axisymmetric::new(&problem, mesh).is_ok()).count()
    };
    let ends_m = [0.5 * good.radial[0].end_m.min(good.axial[0].end_m), 0.0, -0.01, f64::NAN, f64::INFINITY];
    Ok(ends_m.map(accepted).iter().sum::<usize>() as f64)
}

/// Bit-exact.
pub(super) fn sheets_change() -> Measured {
    let solid = at_skin(vec![make_elastic_layer(0.001, 1e5, 0.45), make_elastic_layer(0.03, 2e4, 0.45)]);
    let mut sheeted = solid.clone();
    sheeted.slab.layers.insert(1, make_elastic_layer(0.0, 1e6, 0.3));
    sheeted.slab.layers.insert(0, make_elastic_layer(0.0, 1e6, 0.3));
    change(&solid, &sheeted)
}

pub(super) fn duplicate_change() -> Measured {
    let (fat, half) = (make_elastic_layer(0.01, 2e4, 0.45), make_elastic_layer(0.005, 2e4, 0.45));
    change(
        &at_skin(vec![make_elastic_layer(0.002, 1e5, 0.45), fat]),
        &at_skin(vec![make_elastic_layer(0.002, 1e5, 0.45), half, half]),
    )
}

/// A thin fascia, loaded from above and from below.
pub(super) fn thin_error() -> Measured {
    let layers = [
        make_elastic_layer(0.002, 1e5, 0.45),
        make_elastic_layer(0.0002, 1e6, 0.45),
        make_elastic_layer(0.03, 2e4, 0.45),
    ];
    worst([0.002, 0.0022].map(|depth_m| ask_contactor(layers.to_vec(), depth_m)))
}
