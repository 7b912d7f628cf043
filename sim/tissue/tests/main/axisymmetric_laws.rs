//! What the axisymmetric model owes to mechanics: orders of convergence. The closed forms and hard cases are trials.
//!
//! A quadrature that is too coarse, or a load that is not consistent with the elements, costs an order.

use tissue::Problem;
use tissue::axisymmetric::{Axisymmetric, MeshSpec};
use trials::slabs::{ask_contactor, make_elastic_layer, relative_distance_of_models, solve_beyond_need};

fn errors(problem: &Problem, meshes: impl IntoIterator<Item = MeshSpec>) -> Vec<f64> {
    let truth = solve_beyond_need(problem).expect("a model");
    let model = |mesh| Axisymmetric::new(problem, &mesh).expect("a model");
    meshes.into_iter().map(|mesh| relative_distance_of_models(problem, &model(mesh), &truth)).collect()
}

/// Halving every element divides the error by 2^(p + 1) where the field is smooth, and by a little less with the
/// corners of the clamped side in it.
#[test]
fn the_error_falls_at_the_order_of_the_elements() {
    let problem = ask_contactor(vec![make_elastic_layer(0.002, 1e5, 0.4), make_elastic_layer(0.04, 2e4, 0.4)], 0.0);
    for (order, rate) in [(2, 2.5), (3, 3.0), (4, 3.5)] {
        let mut mesh = MeshSpec::graded(&problem, 2.0);
        mesh.radial.iter_mut().chain(&mut mesh.axial).for_each(|strip| strip.order = order);
        let finer = std::iter::successors(Some(mesh), |mesh| Some(mesh.halved()));
        let found = errors(&problem, finer.skip(1).take(3));
        let mean = 0.5 * libm::log2(found[0] / found[2]);
        assert!(mean > rate, "order {order}: rate {mean} of {found:?}");
    }
}

/// A factor of 2.5 for each level at least, from 1 % down to 1e-4.
#[test]
fn the_error_falls_exponentially_with_the_level() {
    let layers = vec![
        make_elastic_layer(0.0008, 132e3, 0.45),
        make_elastic_layer(0.0084, 33.1e3, 0.45),
        make_elastic_layer(0.039, 198e3, 0.45),
    ];
    let problem = ask_contactor(layers, 0.0);
    let found = errors(&problem, MeshSpec::ladder(&problem).split_off(2));
    for pair in found[..6].windows(2) {
        assert!(pair[1] < pair[0] / 2.5, "{found:?}");
    }
}
