//! What a lattice tends to, and what its fit says of itself.
//!
//! Refined, it tends to the solid of Poisson ratio 1/4, of which the axisymmetric elements give the answer: to the truth
//! where the ratio is 1/4, and on the lower back to a distance of 11.3 % from it. Cells and the nearness of what is held
//! are told apart: the first by elements on the same patch, the second by lattices of the same cells.
//!
//! It would fail on a lattice that locks, on a load that is spread wrongly, on a patch that is not what it is said to
//! be, and on an estimate that flatters.

use serde_json::Value;
use tissue::mass_spring::{FittedLattice, LatticePatch, LatticeSymmetry, MassSpring, fit, fit_by, fit_rung};
use tissue::{ElasticLayer, FieldModel, Judging, Problem, Slab, axisymmetric};

use crate::mass_spring::contactor;

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
}

/// The lower back under a load of the skin, and the axial displacement that 1 N makes by an independent reference.
fn lower_back() -> (Problem, Vec<f64>) {
    let text = include_str!("../../../../tests/data/field/lower_back.json");
    let case: Value = serde_json::from_str(text).expect("JSON");
    let layer = |layer: &Value| ElasticLayer {
        thickness_m: number(&layer["thickness_m"]),
        youngs_modulus_pa: number(&layer["youngs_modulus_pa"]),
        poisson_ratio: number(&layer["poisson_ratio"]),
        density_kg_per_m3: 1050.0,
    };
    let layers = case["layers"].as_array().expect("layers").iter().map(layer).collect();
    let problem = Problem {
        slab: Slab { layers, radius_m: number(&case["radius_m"]) },
        load: contactor(number(&case["solutions"][0]["depth_m"])),
        sample_r_m: numbers(&case["sample_r_m"]),
        sample_depth_m: numbers(&case["sample_depth_m"]),
    };
    let rows = case["solutions"][0]["u_axial_m"].as_array().expect("rows");
    (problem, rows.iter().flat_map(numbers).map(|u_m| u_m / number(&case["force_n"])).collect())
}

fn with_ratio(problem: &Problem, poisson_ratio: f64) -> Problem {
    let mut problem = problem.clone();
    problem.slab.layers.iter_mut().for_each(|layer| layer.poisson_ratio = poisson_ratio);
    problem
}

fn quarter_of(spacing_m: f64, radius_m: f64, depth_m: f64) -> LatticePatch {
    LatticePatch { spacing_m, radius_m, depth_m, symmetry: LatticeSymmetry::Quarter }
}

fn answer_m(problem: &Problem, model: &impl FieldModel) -> Vec<f64> {
    let row = |&depth_m: &f64| problem.sample_r_m.iter().map(move |&r_m| model.displacement_m(r_m, depth_m)[0]);
    problem.sample_depth_m.iter().flat_map(row).collect()
}

fn lattice_m(problem: &Problem, patch: &LatticePatch) -> Vec<f64> {
    answer_m(problem, &MassSpring::new(problem, patch).expect("a lattice"))
}

fn elements_m(problem: &Problem) -> Vec<f64> {
    answer_m(problem, &axisymmetric::fit(problem, 1e-4).expect("elements").model)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    (squares / b.iter().map(|b| b * b).sum::<f64>()).sqrt()
}

/// What answers of two spacings tend to when their errors go with the square of it.
fn extrapolated(coarse: &[f64], fine: &[f64], ratio: f64) -> Vec<f64> {
    coarse.iter().zip(fine).map(|(coarse, fine)| fine + (fine - coarse) / (ratio * ratio - 1.0)).collect()
}

/// The skin and the fat on a rigid base, 9.6 mm around the needle.
fn upper_back() -> Problem {
    let mut problem = with_ratio(&lower_back().0, 0.25);
    problem.slab.layers.truncate(2);
    problem.slab.radius_m = 0.0096;
    problem.sample_r_m.retain(|&r_m| r_m < 0.0096);
    problem
}

#[test]
fn refined_lattice_converges_to_elements_of_poisson_quarter() {
    let problem = upper_back();
    let exact = elements_m(&problem);
    let answers = [1.0, 2.0, 3.0].map(|storeys| lattice_m(&problem, &quarter_of(0.8e-3 / storeys, 0.0096, 0.0092)));
    let [one, two, three] = [0, 1, 2].map(|at| distance(&answers[at], &exact));
    // Second order, less what a rim of steps does.
    let order = libm::log(one / three) / libm::log(3.0);
    assert!(one < 0.13 && two < 0.05 && three < 0.02 && order > 1.5, "{one}, {two}, {three}: order {order}");
    let limit = extrapolated(&answers[1], &answers[2], 1.5);
    assert!(distance(&limit, &exact) < 0.01, "{}", distance(&limit, &exact));
    let truth = elements_m(&with_ratio(&problem, 0.45));
    let (floor, found) = (distance(&exact, &truth), distance(&limit, &truth));
    assert!((found / floor - 1.0).abs() < 0.03, "{found} from the truth, elements of 1/4 {floor}");
}

#[test]
fn a_growing_patch_loses_as_little_as_elements_lose() {
    let problem = with_ratio(&lower_back().0, 0.25);
    let whole = lattice_m(&problem, &quarter_of(1.1e-3, 0.05, 0.0482));
    let all = elements_m(&problem);
    for (radius_m, depth_m) in [(11e-3, 9.2e-3), (22e-3, 22.2e-3)] {
        let lost = distance(&lattice_m(&problem, &quarter_of(1.1e-3, radius_m, depth_m)), &whole);
        let mut cut = problem.clone();
        cut.slab.radius_m = radius_m;
        cut.slab.layers[2].thickness_m = depth_m - 0.0092;
        cut.slab.layers.retain(|layer| layer.thickness_m > 1e-6);
        cut.sample_r_m.retain(|&r_m| r_m < radius_m);
        let cut_model = axisymmetric::fit(&cut, 1e-4).expect("elements").model;
        let wanted = distance(&answer_m(&problem, &cut_model), &all);
        assert!((lost / wanted - 1.0).abs() < 0.25, "{radius_m} m: {lost} for {wanted}");
    }
}

#[test]
fn refined_lattice_reaches_its_floor_of_11_3_percent() {
    let (problem, reference) = lower_back();
    let [near, far] = [[9.6e-3, 9.2e-3], [0.05, 0.0482]];
    let on =
        |spacing_m: f64, [radius_m, depth_m]: [f64; 2]| lattice_m(&problem, &quarter_of(spacing_m, radius_m, depth_m));
    let mut limit = extrapolated(&on(0.4e-3, near), &on(0.8e-3 / 3.0, near), 1.5);
    // What lies beyond the patch adds little and is smooth: cells as high as the skin show it well enough.
    let (whole, part) = (on(0.8e-3 * 1.4, far), on(0.8e-3 * 1.4, near));
    limit.iter_mut().zip(whole.iter().zip(&part)).for_each(|(limit, (whole, part))| *limit += whole - part);
    let exact = elements_m(&with_ratio(&problem, 0.25));
    assert!((distance(&exact, &reference) - 0.113).abs() < 5e-4, "{}", distance(&exact, &reference));
    assert!((distance(&limit, &reference) - 0.113).abs() < 0.015, "{}", distance(&limit, &reference));
    assert!(distance(&limit, &exact) < 0.02, "{}", distance(&limit, &exact));
}

/// As the axial displacement alone judges it.
fn fitted(problem: &Problem, tolerance: f64) -> FittedLattice {
    fit_by(Judging::First, problem, tolerance).expect("a lattice")
}

/// Beside the needle a Poisson ratio of 1/4 shows far more than along it.
#[test]
fn radial_floor_is_separate_and_the_larger_floor_is_reported() {
    let (problem, _) = lower_back();
    let found = fit(&problem, 0.01).expect("a lattice");
    let truth = problem.sampled(&axisymmetric::fit(&problem, 1e-3).expect("a model").model);
    let error = problem.sampled(&found.model).distance(&truth);
    let estimate = found.estimated_relative_error;
    assert!(found.floor > 3.0 * fitted(&problem, 0.01).floor && !found.met, "{}", found.floor);
    assert!(error < 1.01 * estimate && estimate < 3.0 * error, "{estimate} for {error}");
}

#[test]
fn a_fit_below_the_floor_says_so_and_does_not_flatter() {
    let (problem, reference) = lower_back();
    let fitted = fitted(&problem, 0.01);
    assert!((fitted.floor - 0.113).abs() < 1e-3 && !fitted.met, "{}", fitted.floor);
    let error = distance(&answer_m(&problem, &fitted.model), &reference);
    let estimate = fitted.estimated_relative_error;
    assert!(error < 1.01 * estimate && estimate < 3.0 * error, "{estimate} for {error}");
    assert!(fitted.mesh_in_words().to_string().ends_with("11.3 % on this problem"), "{}", fitted.mesh_in_words());
}

#[test]
fn a_fit_takes_the_coarsest_lattice_that_meets_the_tolerance() {
    let (problem, reference) = lower_back();
    let [loose, tight] = [0.4, 0.2].map(|tolerance| fitted(&problem, tolerance));
    for (fitted, tolerance) in [(&loose, 0.4), (&tight, 0.2)] {
        let error = distance(&answer_m(&problem, &fitted.model), &reference);
        assert!(fitted.met && error <= tolerance, "{error} for {tolerance}");
    }
    assert!(loose.model.unknowns() < tight.model.unknowns());
    let sizes = (0..2).map(|at| fit_rung(&problem, at).expect("a rung").expect("a lattice").unknowns());
    assert!(sizes.is_sorted() && fit_rung(&problem, 100).is_none());
}

#[test]
fn a_layer_without_thickness_changes_nothing() {
    let (problem, _) = lower_back();
    let mut sheets = problem.clone();
    let sheet = ElasticLayer { thickness_m: 0.0, youngs_modulus_pa: 1e9, ..problem.slab.layers[0] };
    sheets.slab.layers.insert(1, sheet);
    sheets.slab.layers.push(sheet);
    let [with, without] = [&sheets, &problem].map(|problem| fitted(problem, 0.4));
    assert_eq!(answer_m(&problem, &with.model), answer_m(&problem, &without.model));
    assert_eq!(with.mesh_in_words(), without.mesh_in_words());
}
