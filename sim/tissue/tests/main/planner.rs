//! The planner: the cheapest model that can answer, with the reason; a patch no larger than the needle's influence.
//!
//! It would fail if a question without an axis went to a model in (r, z), if a named model were replaced or its error hidden,
//! or if a patch were narrower than its tolerance allows or wider than it needs.

use nalgebra::Point3;
use tissue::axisymmetric::{Axisymmetric, MeshSpec};
use tissue::planner::{PlanError, PlanRequest, Reach, choose, cut_patch, find_reach, plan};
use tissue::volumetric::{Inclusion, InclusionShape, Material, Problem3, Skin};
use tissue::{ElasticLayer, FieldModel, Judging, Load, LoadKind, Model, Problem, Slab};

fn layer(thickness_m: f64, youngs_modulus_pa: f64) -> ElasticLayer {
    ElasticLayer { thickness_m, youngs_modulus_pa, poisson_ratio: 0.45, density_kg_per_m3: 1000.0 }
}

fn lower_back() -> Vec<ElasticLayer> {
    vec![layer(0.0008, 132e3), layer(0.0084, 33e3), layer(0.039, 198e3)]
}

const SKIN: Load = Load { kind: LoadKind::Contactor { depth_m: 0.0 }, radius_m: 0.001 };

fn flat() -> Problem {
    Problem {
        slab: Slab { layers: lower_back(), radius_m: 0.05 },
        load: SKIN,
        sample_r_m: (0..=20).map(|at| 0.001 * f64::from(at)).collect(),
        sample_depth_m: vec![0.0, 0.0008, 0.0092],
    }
}

fn with_inclusion() -> Problem3 {
    let material = Material { youngs_modulus_pa: 1e6, poisson_ratio: 0.3, density_kg_per_m3: 1000.0 };
    let shape = InclusionShape::Sphere { centre_m: Point3::new(0.0, 0.0, -0.02), radius_m: 0.005 };
    Problem3 { inclusions: vec![Inclusion { shape, material }], ..Problem3::flat(&flat()) }
}

#[test]
fn a_question_goes_to_the_cheapest_model_that_can_answer_it() {
    let flat = Problem3::flat(&flat());
    let oblique = Problem3 { tilt_rad: 0.4, ..flat.clone() };
    let curved = Problem3 { skin: Skin::cylinder_along_y(0.2), ..flat.clone() };
    for (question, model, because) in [
        (&flat, Model::Axisymmetric, "are axisymmetric"),
        (&oblique, Model::Axisymmetric, "two harmonics"),
        (&curved, Model::Volumetric, "curved"),
        (&with_inclusion(), Model::Volumetric, "inclusions"),
    ] {
        let (chosen, why) = choose(question, None).expect("a model");
        assert_eq!(chosen, model, "{why}");
        assert!(why.to_string().contains(because), "{why}");
        let named = choose(question, Some(Model::Axisymmetric));
        match model {
            Model::Axisymmetric => assert!(named.is_ok()),
            _ => assert!(matches!(named, Err(PlanError::Unsuited { model: Model::Axisymmetric, .. })), "{named:?}"),
        }
    }
    let lattice = choose(&oblique, Some(Model::MassSpring)).expect_err("springs in (r, z)").to_string();
    assert!(lattice.contains("the needle is oblique") && lattice.contains("\"auto\" or \"volumetric\""), "{lattice}");
    assert_eq!(choose(&flat, Some(Model::None)), Err(PlanError::NoModel));
}

#[test]
fn a_named_model_is_used_and_its_error_is_told() {
    let wish = PlanRequest { model: Some(Model::MassSpring), tolerance: 0.01, judging: Judging::Second };
    let planned = plan(&Problem3::flat(&flat()), &wish).expect("a plan");
    assert_eq!(planned.field.model(), Model::MassSpring);
    assert!(!planned.met && planned.estimated_relative_error > 0.05, "{}", planned.estimated_relative_error);
    for words in ["was requested", "does not meet", "axisymmetric"] {
        assert!(planned.reason.to_string().contains(words), "{}", planned.reason);
    }
}

#[test]
fn what_meets_the_tolerance_says_so() {
    for tolerance in [0.05, 0.01] {
        let planned = plan(&Problem3::flat(&flat()), &PlanRequest { model: None, tolerance, judging: Judging::Second })
            .expect("a plan");
        assert!(planned.met && planned.estimated_relative_error <= tolerance, "{}", planned.reason);
        assert!(planned.reason.to_string().contains("cheapest"), "{}", planned.reason);
    }
}

fn radii_m() -> Vec<f64> {
    (0..=20).map(|at| 0.001 * f64::from(at)).collect()
}

/// A push on the skin of layers, seen at the radii.
fn question(layers: &[ElasticLayer]) -> Problem3 {
    let slab = Slab { layers: layers.to_vec(), radius_m: 10.0 };
    Problem3::flat(&Problem { slab, load: SKIN, sample_r_m: radii_m(), sample_depth_m: vec![] })
}

/// Axial displacement at the samples, in m, of a load of the skin on a slab.
fn answer_m(slab: &Slab) -> Vec<f64> {
    let problem = Problem { slab: slab.clone(), load: SKIN, sample_r_m: vec![], sample_depth_m: vec![] };
    let model = Axisymmetric::new(&problem, &MeshSpec::graded(&problem, 6.0)).expect("a model");
    let inside = |&r_m: &f64| if r_m <= slab.radius_m { model.displacement_m(r_m, 0.0)[0] } else { 0.0 };
    radii_m().iter().map(inside).collect()
}

#[test]
fn a_patch_is_as_wide_as_its_tolerance_asks_and_no_wider() {
    let deep = vec![layer(0.0008, 132e3), layer(0.0084, 33e3), layer(2.0, 198e3)];
    let [coarse, fine] = [0.1, 0.01].map(|tolerance| find_reach(&question(&deep), tolerance).expect("a reach"));
    assert!(fine.radius_m > coarse.radius_m, "{coarse:?} {fine:?}");
    for (Reach { radius_m, relative_change }, tolerance) in [(coarse, 0.1), (fine, 0.01)] {
        assert!(relative_change <= tolerance, "{relative_change}");
        let [narrow, wide] = [1.0, 16.0].map(|times| answer_m(&cut_patch(&deep, 0.0, times * radius_m)));
        let wrong: f64 = narrow.iter().zip(&wide).map(|(a, b)| (a - b) * (a - b)).sum();
        let whole: f64 = wide.iter().map(|b| b * b).sum();
        let off = (wrong / whole).sqrt();
        // All doublings beyond it together take at most as much again as the first one: the changes halve or better.
        assert!(off <= 2.0 * tolerance, "{off} beyond the patch of {radius_m} m");
    }
}

#[test]
fn layers_below_the_reach_of_the_needle_are_left_out() {
    let mut layers = lower_back();
    layers.extend([layer(0.0, 1e3), layer(1.0, 198e3), layer(1.0, 50e3)]);
    let slab = cut_patch(&layers, 0.0092, 0.06);
    assert_eq!(slab.layers.len(), 4, "neither the sheet without thickness nor what is too deep: {slab:?}");
    assert!((slab.boundaries_m()[4] - 0.0692).abs() < 1e-12 && (slab.radius_m - 0.06).abs() < 1e-12, "{slab:?}");
}
