//! The axisymmetric model against the reference cases: its true error, the error it claims, and what it costs.
//!
//! It would fail on a wrong stiffness or load, on a mesh that misses an interface, and on an estimate that flatters.

use proptest::prelude::*;
use serde::Deserialize;
use tissue::axisymmetric::{Axisymmetric, FittedAxisymmetric, MeshSpec, Superposed, fit, fit_rung};
use tissue::{ElasticLayer, FieldModel, Load, LoadKind, Problem, Slab};
use trials::estimates::truth;
use trials::slabs::{ask_contactor, make_elastic_layer};

#[derive(Deserialize)]
struct CaseLayer {
    thickness_m: f64,
    youngs_modulus_pa: f64,
    poisson_ratio: f64,
}

#[derive(Deserialize)]
struct Solution {
    depth_m: f64,
    u_axial_m: Vec<Vec<f64>>,
    u_radial_m: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
struct Case {
    layers: Vec<CaseLayer>,
    radius_m: f64,
    load_radius_m: f64,
    force_n: f64,
    sample_r_m: Vec<f64>,
    sample_depth_m: Vec<f64>,
    solutions: Vec<Solution>,
}

impl Case {
    fn read(text: &str) -> Self {
        serde_json::from_str(text).expect("a reference case")
    }

    fn problem(&self, depth_m: f64) -> Problem {
        let layer = |l: &CaseLayer| make_elastic_layer(l.thickness_m, l.youngs_modulus_pa, l.poisson_ratio);
        Problem {
            slab: Slab { layers: self.layers.iter().map(layer).collect(), radius_m: self.radius_m },
            load: Load { kind: LoadKind::Contactor { depth_m }, radius_m: self.load_radius_m },
            sample_r_m: self.sample_r_m.clone(),
            sample_depth_m: self.sample_depth_m.clone(),
        }
    }

    /// Relative L2 error of one component of an answer to the case's force, over all sample points.
    fn error(&self, model: &Axisymmetric, reference: &[Vec<f64>], component: usize) -> f64 {
        let (mut wrong, mut whole) = (0.0, 0.0);
        for (row, &depth_m) in reference.iter().zip(&self.sample_depth_m) {
            for (should, &r_m) in row.iter().zip(&self.sample_r_m) {
                wrong += (model.displacement_m(r_m, depth_m)[component] - should).powi(2);
                whole += should * should;
            }
        }
        (wrong / whole).sqrt()
    }
}

fn cases() -> [Case; 3] {
    [
        Case::read(include_str!("../../../../tests/data/field/homogeneous.json")),
        Case::read(include_str!("../../../../tests/data/field/lower_back.json")),
        Case::read(include_str!("../../../../tests/data/field/stiff_skin_soft_fat.json")),
    ]
}

/// Fits every load of every case and hands over the solved model with its true error: the larger of both components'.
fn each_fit(tolerance: f64, mut check: impl FnMut(&FittedAxisymmetric, f64)) {
    for case in cases() {
        for solution in &case.solutions {
            let mut fitted = fit(&case.problem(solution.depth_m), tolerance).expect("a model");
            fitted.model.solve(case.force_n);
            let [axial, radial] = [(&solution.u_axial_m, 0), (&solution.u_radial_m, 1)]
                .map(|(reference, component)| case.error(&fitted.model, reference, component));
            check(&fitted, axial.max(radial));
        }
    }
}

fn meets_with_an_honest_estimate(tolerance: f64, most_nonzeros: usize) {
    each_fit(tolerance, |fitted, error| {
        let estimate = fitted.estimated_relative_error;
        assert!(fitted.met && error <= tolerance, "error {error}, estimate {estimate}");
        assert!(estimate <= 3.0 * error && error <= 3.0 * estimate, "error {error}, estimate {estimate}");
        assert!(error >= tolerance / 4.0, "error {error}: more accurate than asked for, so dearer than needed");
        let nonzeros = fitted.model.nonzeros();
        assert!(nonzeros <= most_nonzeros, "a solve that reads {nonzeros} numbers is too slow");
    });
}

#[test]
fn one_per_cent_is_met_on_every_reference_case() {
    meets_with_an_honest_estimate(1e-2, 50_000);
}

#[test]
fn a_tenth_of_a_per_cent_is_met_on_every_reference_case() {
    meets_with_an_honest_estimate(1e-3, 230_000);
}

/// The references are good to 2e-5, that of the stiff skin to 2e-4.
#[test]
fn finest_meshes_agree_with_references_in_both_components() {
    for (case, bound) in cases().iter().zip([6e-5, 6e-5, 2.5e-4]) {
        for solution in &case.solutions {
            let problem = case.problem(solution.depth_m);
            let mut model = Axisymmetric::new(&problem, &MeshSpec::graded(&problem, 10.0)).expect("a model");
            model.solve(case.force_n);
            let axial = case.error(&model, &solution.u_axial_m, 0);
            let radial = case.error(&model, &solution.u_radial_m, 1);
            assert!(axial < bound && radial < 6.0 * bound, "axial {axial}, radial {radial}");
        }
    }
}

#[test]
fn the_ladder_ends_and_every_rung_is_better_than_the_one_before() {
    let case = &cases()[1];
    let problem = case.problem(0.0);
    let rungs: Vec<Axisymmetric> =
        (0..).map_while(|at| fit_rung(&problem, at)).map(|rung| rung.expect("a model")).collect();
    let errors = rungs.into_iter().map(|mut model| {
        model.solve(case.force_n);
        case.error(&model, &case.solutions[0].u_axial_m, 0)
    });
    let errors: Vec<f64> = errors.collect();
    assert!(errors.len() > 5 && errors.windows(2).all(|pair| pair[1] < pair[0]), "{errors:?}");
    let mut wrong = problem;
    wrong.load.radius_m = f64::NAN;
    assert!(
        fit_rung(&wrong, 0).is_some_and(|refused| refused.is_err_and(|why| why.to_string().contains("load_radius_m")))
    );
}

#[test]
fn a_mesh_is_told_in_words() {
    let fitted = fit(&cases()[1].problem(0.0), 1e-2).expect("a model");
    assert_eq!(fitted.mesh_in_words().to_string(), "3 × 4 elements of order up to 6");
}

#[test]
fn superposed_responses_are_the_sum_of_the_loads() {
    let case = &cases()[1];
    let fitted = |solution: &Solution| fit(&case.problem(solution.depth_m), 1e-2).expect("a model").model;
    let mut models: Vec<Axisymmetric> = case.solutions.iter().map(fitted).collect();
    let points = [[0.0, 0.0], [0.0013, 0.0008], [0.02, 0.0092], [0.007, 0.03]];
    let mut loads: Vec<&mut dyn FieldModel> = models.iter_mut().map(|model| model as _).collect();
    let (responses, forces_n) = (Superposed::new(&mut loads, &points), [0.3, -0.1, 1.7]);
    let mut answer = [[f64::NAN; 2]; 4];
    responses.answer(&forces_n, &mut answer);
    models.iter_mut().zip(forces_n).for_each(|(model, force_n)| model.solve(force_n));
    for ([r_m, depth_m], answer) in points.into_iter().zip(answer) {
        for (component, is) in answer.into_iter().enumerate() {
            let sum: f64 = models.iter().map(|model| model.displacement_m(r_m, depth_m)[component]).sum();
            assert!((is - sum).abs() <= 1e-12 * sum.abs(), "{is} for {sum}");
        }
    }
}

/// A drag over a short stretch is a load on its middle, and many short ones add up to a long one.
#[test]
fn a_drag_is_the_sum_of_its_parts() {
    let layers = vec![
        make_elastic_layer(0.002, 1e5, 0.45),
        make_elastic_layer(0.01, 2e4, 0.45),
        make_elastic_layer(0.03, 1e5, 0.45),
    ];
    let at = |from_m: f64, to_m: f64| {
        let mut problem = ask_contactor(layers.clone(), 0.0);
        problem.load.kind = LoadKind::Drag { from_m, to_m };
        Axisymmetric::new(&problem, &MeshSpec::graded(&problem, 8.0)).expect("a model")
    };
    let (whole, parts) = (at(0.0, 0.006), [at(0.0, 0.001), at(0.001, 0.003), at(0.003, 0.006)]);
    for [r_m, depth_m] in [[0.0, 0.0], [0.0005, 0.002], [0.003, 0.004], [0.01, 0.0], [0.002, 0.012]] {
        let shares = parts.iter().zip([1.0 / 6.0, 2.0 / 6.0, 3.0 / 6.0]);
        let sum: f64 = shares.map(|(part, share)| share * part.displacement_m(r_m, depth_m)[0]).sum();
        let is = whole.displacement_m(r_m, depth_m)[0];
        assert!((is / sum - 1.0).abs() < 5e-3, "{is} for {sum} at {r_m}, {depth_m}");
    }
    let (point, short) = (ask_contactor(layers.clone(), 0.001), at(0.0009, 0.0011));
    let point = Axisymmetric::new(&point, &MeshSpec::graded(&point, 8.0)).expect("a model");
    let [is, should] = [&short, &point].map(|model| model.displacement_m(0.005, 0.0)[0]);
    assert!((is / should - 1.0).abs() < 5e-3, "{is} for {should}");
}

/// Whether nothing moves at a place, not even by rounding.
fn still(model: &Axisymmetric, [r_m, depth_m]: [f64; 2]) -> bool {
    model.displacement_m(r_m, depth_m).iter().all(|u| u.abs() <= 0.0)
}

#[test]
fn a_load_on_the_clamped_base_moves_nothing() {
    let fitted = fit(&ask_contactor(vec![make_elastic_layer(0.03, 2e4, 0.45)], 0.03), 1e-2).expect("a model");
    assert!(fitted.met && fitted.estimated_relative_error.abs() < f64::EPSILON);
    assert!(still(&fitted.model, [0.0, 0.01]));
    assert!(fitted.model.stiffness_n_per_m().is_infinite());
}

#[test]
fn outside_the_tissue_nothing_moves() {
    let model = fit(&ask_contactor(vec![make_elastic_layer(0.03, 2e4, 0.45)], 0.0), 1e-2).expect("a model").model;
    for place in [[-1.0, 0.0], [0.0, -0.001], [0.06, 0.0], [0.0, 0.04], [f64::NAN, 0.0], [0.0, f64::INFINITY]] {
        assert!(still(&model, place), "{place:?}");
    }
    assert!(model.displacement_m(0.0, 0.0)[0] < 0.0);
}

#[test]
fn a_mesh_that_does_not_fit_is_refused_with_the_place() {
    let problem = ask_contactor(vec![make_elastic_layer(0.002, 1e5, 0.45), make_elastic_layer(0.03, 2e4, 0.45)], 0.0);
    let good = MeshSpec::graded(&problem, 4.0);
    let refused = |change: &dyn Fn(&mut MeshSpec)| {
        let mut mesh = good.clone();
        change(&mut mesh);
        Axisymmetric::new(&problem, &mesh).expect_err("refused").to_string()
    };
    assert!(refused(&|mesh| mesh.axial[0].end_m = 0.001).contains("mesh.axial = 0.002 m"));
    assert!(refused(&|mesh| mesh.radial[0].order = 11).contains("mesh.radial[0].order = 11"));
    assert!(refused(&|mesh| mesh.radial[1].end_m = f64::NAN).contains("mesh.radial[1].end_m = NaN m"));
    assert!(refused(&|mesh| mesh.axial.clear()).contains("mesh.axial = 0 m"));
    assert!(fit(&problem, f64::NAN).expect_err("refused").to_string().contains("tolerance = NaN"));
}

/// A drag that begins three column's radii below a stiff plate is felt there by a five-hundredth of what it is below. Graded meshes of the
/// highest order are wrong by 2 % there; the judge, whose elements do not lose their orders with the distance, is not.
#[test]
fn estimate_covers_a_deep_drag_in_a_narrow_column() {
    let mut problem =
        ask_contactor(vec![make_elastic_layer(160e-6, 3.7e6, 0.0), make_elastic_layer(44.6e-3, 5.4e3, 0.46)], 0.0);
    problem.slab.radius_m = 0.739e-3;
    problem.load = Load { kind: LoadKind::Drag { from_m: 2.64e-3, to_m: 42.8e-3 }, radius_m: 79e-6 };
    problem.sample_r_m = (0..=18).map(|at| 0.5 * f64::from(at) * 79e-6).collect();
    let truth = truth(&problem).expect("a model");
    let error =
        |mesh: &MeshSpec| problem.sampled(&Axisymmetric::new(&problem, mesh).expect("a model")).distance(&truth);
    assert!(error(&MeshSpec::graded(&problem, 10.0)) > 0.01, "a graded mesh is no judge of it");
    assert!(error(&MeshSpec::even(&problem, 10, 0.6).halved()) < 1e-3, "the truth is");
    for tolerance in [0.05, 0.01, 0.001] {
        let fitted = fit(&problem, tolerance).expect("a model");
        let (error, estimate) = (problem.sampled(&fitted.model).distance(&truth), fitted.estimated_relative_error);
        assert!(fitted.met && error <= tolerance, "{error} of {tolerance}");
        assert!((estimate / 3.0..=1.5 * estimate).contains(&error), "{error}, estimated {estimate}");
    }
}

/// A layer of any thickness, contrast and compressibility that a scene may have.
fn any_layer() -> impl Strategy<Value = ElasticLayer> {
    let log = |low: f64, high: f64| (libm::log(low)..libm::log(high)).prop_map(libm::exp);
    (log(1e-5, 0.1), log(1e3, 1e8), 0.0..=0.499).prop_map(|(thickness_m, e, nu)| make_elastic_layer(thickness_m, e, nu))
}

fn any_problem() -> impl Strategy<Value = Problem> {
    let layers = prop::collection::vec(any_layer(), 1..=10);
    let log = |low: f64, high: f64| (libm::log(low)..libm::log(high)).prop_map(libm::exp);
    let place = (0.0..=1.0, 0.0..=1.0, any::<bool>());
    (layers, log(5e-5, 5e-3), log(5.0, 500.0), place).prop_map(|(layers, radius_m, wide, (one, other, drag))| {
        let mut problem = ask_contactor(layers, 0.0);
        problem.slab.radius_m = wide * radius_m;
        problem.load.radius_m = radius_m;
        problem.sample_r_m = (0..=20).map(|at| (0.5 * f64::from(at) * radius_m).min(problem.slab.radius_m)).collect();
        let boundaries = problem.slab.boundaries_m();
        let base_m = boundaries[boundaries.len() - 1];
        problem.load.kind = if drag {
            LoadKind::Drag { from_m: f64::min(one, other) * base_m, to_m: f64::max(one, other) * base_m }
        } else {
            LoadKind::Contactor { depth_m: boundaries[(one * (boundaries.len() - 1) as f64) as usize] }
        };
        problem
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever the scene: the tolerance is met, but for the doubt of the estimate, a factor of three, or it is admitted that
    /// it is not. A sheet 75 times thinner than the footprint has been seen to take half of that factor.
    /// Only where the load is felt: deep in a narrow column it fades below what the mesh, made for the load, resolves. A graded mesh is
    /// no truth there, whatever its order.
    #[test]
    fn any_scene_is_met_or_admitted(problem in any_problem()) {
        let fitted = fit(&problem, 1e-2).expect("a model");
        let estimate = fitted.estimated_relative_error;
        prop_assert!(estimate.is_finite() && fitted.met == (estimate <= 1e-2));
        prop_assert!(fitted.model.stiffness_n_per_m() > 0.0);
        let truth = truth(&problem).expect("a model");
        let most_m = truth.axial_m.iter().map(|axial_m| axial_m.abs()).fold(0.0, f64::max);
        prop_assume!(most_m * fitted.model.stiffness_n_per_m() > 1e-3);
        let error = problem.sampled(&fitted.model).distance(&truth);
        prop_assert!(!fitted.met || error <= f64::max(3.0 * estimate, 1.2e-2), "error {error}, estimate {estimate}");
    }
}
