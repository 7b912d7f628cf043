//! Finite elements in (r, z): against independent references, closed forms and laws.
//!
//! Would fail on a wrong sign, a load that does not add up to its force, a layer off its interface, locking near
//! ν = ½, an estimate that flatters, or a solve that allocates.

use allocation_counter::measure;
use mechanics::tissue::axisymmetric::{Axisymmetric, Fitted, MeshSpec, Side, Superposed, fit};
use mechanics::tissue::{ElasticLayer, FieldModel, Load, LoadKind, Problem, Slab};
use serde_json::Value;

const CASES: [(&str, f64); 3] = [
    (include_str!("../../../../tests/data/field/homogeneous.json"), 2e-5),
    (include_str!("../../../../tests/data/field/lower_back.json"), 2e-5),
    (include_str!("../../../../tests/data/field/stiff_skin_soft_fat.json"), 2e-4),
];

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
}

fn layer(thickness_m: f64, youngs_modulus_pa: f64, poisson_ratio: f64) -> ElasticLayer {
    ElasticLayer { thickness_m, youngs_modulus_pa, poisson_ratio, density_kg_per_m3: 1050.0 }
}

fn contactor(depth_m: f64, radius_m: f64) -> Load {
    Load { kind: LoadKind::Contactor { depth_m }, radius_m }
}

/// A problem with samples on the skin and at the load.
fn problem(layers: Vec<ElasticLayer>, radius_m: f64, load: Load) -> Problem {
    let LoadKind::Contactor { depth_m } = load.kind else { panic!("a contactor") };
    let sample_r_m = (0..=20).map(|step| f64::from(step) * 0.5 * load.radius_m).filter(|&r| r <= radius_m).collect();
    Problem { slab: Slab { layers, radius_m }, load, sample_r_m, sample_depth_m: vec![0.0, depth_m] }
}

fn lower_back(load: Load) -> Problem {
    problem(vec![layer(8e-4, 132e3, 0.45), layer(8.4e-3, 33.1e3, 0.45), layer(39e-3, 198e3, 0.45)], 0.05, load)
}

fn fitted(problem: &Problem, tolerance: f64) -> Fitted {
    fit(problem, tolerance).expect("a model")
}

/// Errors of every load of a reference case: true and estimated.
fn errors(case: &str, tolerance: f64) -> Vec<(f64, f64)> {
    let case: Value = serde_json::from_str(case).expect("JSON");
    let layers = case["layers"].as_array().expect("layers").iter();
    let elastic =
        |l: &Value| layer(number(&l["thickness_m"]), number(&l["youngs_modulus_pa"]), number(&l["poisson_ratio"]));
    let layers: Vec<ElasticLayer> = layers.map(elastic).collect();
    let force_n = number(&case["force_n"]);
    let solve = |solution: &Value| {
        let problem = Problem {
            slab: Slab { layers: layers.clone(), radius_m: number(&case["radius_m"]) },
            load: contactor(number(&solution["depth_m"]), number(&case["load_radius_m"])),
            sample_r_m: numbers(&case["sample_r_m"]),
            sample_depth_m: numbers(&case["sample_depth_m"]),
        };
        let mut fitted = fitted(&problem, tolerance);
        assert!(fitted.met, "the tolerance {tolerance} is met");
        fitted.model.solve(force_n);
        let (mut wrong, mut whole) = (0.0, 0.0);
        for (row, &depth_m) in solution["u_axial_m"].as_array().expect("rows").iter().zip(&problem.sample_depth_m) {
            for (wanted, &r_m) in numbers(row).into_iter().zip(&problem.sample_r_m) {
                let found = fitted.model.displacement_m(r_m, depth_m)[0];
                wrong += (found - wanted) * (found - wanted);
                whole += wanted * wanted;
            }
        }
        ((wrong / whole).sqrt(), fitted.estimated_relative_error)
    };
    case["solutions"].as_array().expect("solutions").iter().map(solve).collect()
}

#[test]
fn every_reference_is_met_at_both_tolerances_and_the_estimate_is_within_a_factor_of_three() {
    for tolerance in [1e-2, 1e-3] {
        for (case, doubt) in CASES {
            for (error, estimate) in errors(case, tolerance) {
                assert!(error <= tolerance, "{error} for {tolerance}");
                assert!(estimate <= 3.0 * (error + doubt) && error <= 3.0 * estimate + doubt, "{estimate} for {error}");
            }
        }
    }
}

#[test]
fn a_growing_block_tends_to_the_half_space() {
    // u(0) = (1 − ν²) F/(E a √π); a block of 50 footprints is 1.7 % stiffer, and the rest goes with 1/R.
    let (youngs, poisson, a) = (50e3, 0.3, 1e-3);
    let exact_m = (1.0 - poisson * poisson) / (youngs * a * core::f64::consts::PI.sqrt());
    let short = |radius_m: f64| {
        let fitted = fitted(&problem(vec![layer(radius_m, youngs, poisson)], radius_m, contactor(0.0, a)), 1e-4);
        exact_m / -fitted.model.displacement_m(0.0, 0.0)[0] - 1.0
    };
    let [narrow, wide, wider] = [0.05, 0.1, 0.2].map(short);
    assert!((narrow - 0.017).abs() < 1e-3, "{narrow}");
    assert!((1.9..2.1).contains(&(narrow / wide)) && (1.9..2.1).contains(&(wide / wider)), "{narrow} {wide} {wider}");
}

#[test]
fn a_confined_column_is_its_springs_in_series() {
    // A footprint far wider than the column is a uniform pressure F/(πa²): u = p Σ d/M, M = E(1 − ν)/((1 + ν)(1 − 2ν)).
    let layers = vec![layer(0.004, 20e3, 0.3), layer(0.01, 5e3, 0.45), layer(0.006, 200e3, 0.1)];
    let modulus = |l: &ElasticLayer| {
        let (e, v) = (l.youngs_modulus_pa, l.poisson_ratio);
        e * (1.0 - v) / ((1.0 + v) * (1.0 - 2.0 * v))
    };
    let a = 10.0;
    let exact_m = layers.iter().map(|l| l.thickness_m / modulus(l)).sum::<f64>() / (core::f64::consts::PI * a * a);
    let column = problem(layers, 0.02, contactor(0.0, a));
    let mesh = MeshSpec::ladder(&column).swap_remove(1);
    let model = Axisymmetric::with_side(&column, &mesh, Side::Sliding).expect("a column");
    for r_m in [0.0, 0.007, 0.02] {
        let [axial_m, radial_m] = model.displacement_m(r_m, 0.0);
        assert!((axial_m / -exact_m - 1.0).abs() < 1e-5, "{axial_m} for {exact_m}");
        assert!(radial_m.abs() < 1e-5 * exact_m, "{radial_m}");
    }
}

#[test]
fn what_one_load_does_at_another_the_other_does_at_it() {
    // Betti: ∫ p_b u_a = ∫ p_a u_b, each over its own footprint.
    let a = 1e-3;
    let work = |from_m: f64, at_m: f64| {
        let model = fitted(&lower_back(contactor(from_m, a)), 1e-4).model;
        let dr = a / 100.0;
        let ring = |step: u32| {
            let r_m = (f64::from(step) + 0.5) * dr;
            2.0 * r_m * dr / (a * a) * libm::exp(-(r_m / a) * (r_m / a)) * model.displacement_m(r_m, at_m)[0]
        };
        (0..600).map(ring).sum::<f64>()
    };
    let (down, up) = (work(0.0, 0.0092), work(0.0092, 0.0));
    assert!((down / up - 1.0).abs() < 2e-3, "{down} {up}");
}

/// What a tolerance of 1 % changes against a finer one, at the axis under the load.
fn doubt(problem: &Problem, finer: f64) -> f64 {
    let LoadKind::Contactor { depth_m } = problem.load.kind else { panic!("a contactor") };
    let [rough, fine] = [1e-2, finer].map(|tolerance| {
        let fitted = fitted(problem, tolerance);
        assert!(fitted.met, "{tolerance}: {}", fitted.estimated_relative_error);
        fitted.model.displacement_m(0.0, depth_m)[0]
    });
    assert!(fine < 0.0, "a push goes in");
    (rough / fine - 1.0).abs()
}

#[test]
fn nearly_incompressible_layers_do_not_lock() {
    let layers = vec![layer(8e-4, 132e3, 0.499), layer(8.4e-3, 33.1e3, 0.499), layer(39e-3, 198e3, 0.499)];
    let changed = doubt(&problem(layers, 0.05, contactor(0.0, 1e-3)), 1e-3);
    assert!(changed < 2e-2, "{changed}");
}

#[test]
fn stiffness_may_differ_by_a_factor_of_a_hundred_thousand() {
    for ratio in [1e2, 1e3, 1e4, 1e5] {
        let changed = doubt(
            &problem(vec![layer(1e-3, ratio * 1e3, 0.45), layer(0.03, 1e3, 0.45)], 0.05, contactor(0.0, 1e-3)),
            5e-3,
        );
        assert!(changed < 2e-2, "{ratio}: {changed}");
    }
}

#[test]
fn a_thin_skin_on_a_thick_muscle_is_met_at_every_boundary() {
    for depth_m in [0.0, 8e-4] {
        let changed = doubt(
            &problem(vec![layer(8e-4, 132e3, 0.45), layer(39e-3, 198e3, 0.45)], 0.05, contactor(depth_m, 1e-3)),
            1e-3,
        );
        assert!(changed < 2e-2, "{changed}");
    }
}

#[test]
fn a_sheet_without_thickness_is_left_out_and_a_layer_may_come_twice() {
    let once = vec![layer(0.01, 30e3, 0.45), layer(0.02, 60e3, 0.45)];
    let twice = vec![layer(0.0, 1e6, 0.3), layer(0.004, 30e3, 0.45), layer(0.006, 30e3, 0.45), layer(0.02, 60e3, 0.45)];
    let [one, two] = [once, twice].map(|layers| {
        let mut problem = problem(layers, 0.05, contactor(0.0, 1e-3));
        problem.slab = problem.slab.solid();
        fitted(&problem, 1e-4).model.displacement_m(0.0, 0.0)[0]
    });
    assert!((one / two - 1.0).abs() < 5e-4, "{one} {two}");
}

#[test]
fn a_drag_over_a_stretch_is_the_mean_of_the_loads_along_it() {
    let drag = Load { kind: LoadKind::Drag { from_m: 0.002, to_m: 0.006 }, radius_m: 1e-3 };
    let mut asked = lower_back(contactor(0.0, 1e-3));
    let part = |asked: &Problem| fitted(asked, 1e-4).model.displacement_m(0.0, 0.0)[0];
    let steps = 16;
    let mean = (0..steps)
        .map(|step| {
            let depth_m = 0.002 + 0.004 * (f64::from(step) + 0.5) / f64::from(steps);
            asked.load = contactor(depth_m, 1e-3);
            part(&asked) / f64::from(steps)
        })
        .sum::<f64>();
    asked.load = drag;
    let whole = part(&asked);
    assert!((whole / mean - 1.0).abs() < 2e-3, "{whole} {mean}");
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let refused = |layers: Vec<ElasticLayer>, load: Load| {
        fit(&problem(layers, 0.05, load), 0.01).expect_err("a refusal").to_string()
    };
    let good = layer(0.01, 1e4, 0.45);
    assert!(refused(vec![layer(f64::NAN, 1e4, 0.45)], contactor(0.0, 1e-3)).contains("layers[0].thickness_m"));
    assert!(refused(vec![good, layer(0.01, 1e4, 0.5)], contactor(0.0, 1e-3)).contains("layers[1].poisson_ratio"));
    assert!(refused(vec![good], contactor(0.011, 1e-3)).contains("load_depth_m"));
    assert!(refused(vec![good], contactor(0.0, f64::INFINITY)).contains("load_radius_m"));
    assert!(fit(&lower_back(contactor(0.0, 1e-3)), f64::NAN).expect_err("a refusal").to_string().contains("tolerance"));
}

#[test]
fn a_solve_and_an_answer_never_allocate() {
    let mut model = fitted(&lower_back(contactor(0.0, 1e-3)), 0.01).model;
    let points: Vec<[f64; 2]> = (0..100).map(|at| [f64::from(at) * 1e-4, 0.0]).collect();
    let superposed = Superposed::new(&mut [&mut model], &points);
    let mut displacements = vec![[0.0; 2]; points.len()];
    let counted = measure(|| {
        model.solve(0.3);
        superposed.answer(&[0.3], &mut displacements);
    });
    assert_eq!(counted.count_total, 0);
    for (&[r_m, depth_m], found) in points.iter().zip(&displacements) {
        let wanted = model.displacement_m(r_m, depth_m);
        assert!((found[0] - wanted[0]).abs() < 1e-15 && (found[1] - wanted[1]).abs() < 1e-15, "{found:?} {wanted:?}");
    }
}
