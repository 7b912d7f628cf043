//! A field knows what every needle does, however it leans. It would fail where the responses were those of the exercise's angle, where
//! the polynomial between angles strayed, or where a claim were below the error.

use tissue::axisymmetric::{MeshSpec, Oblique};
use tissue::follow::{FLATTEST_RAD, Field, TissueSpec};
use tissue::volumetric::Problem3;
use tissue::{ElasticLayer, Judging, Load, Model, Problem, relative_distance};

use crate::follow;

/// Angles between those that any field solves for, in degrees.
const TILTS_DEG: [f64; 4] = [0.0, 11.0, 33.0, 58.0];

/// The lower back in the middle of a body, under a needle of a radius in m.
fn body(load_radius_m: f64, tolerance: f64) -> TissueSpec {
    let mut tissue = TissueSpec { load_radius_m, tolerance, ..follow::lower_back() };
    tissue.slab.radius_m = 0.25;
    tissue
}

/// Displacement along a needle of every boundary that it meets, in m/N, by a mesh far finer than any that is chosen.
fn on_body_m(tissue: &TissueSpec, load: Load, tilt_rad: f64) -> Vec<f64> {
    let sample_depth_m = tissue.boundaries_m[..tissue.layers()].to_vec();
    let flat = Problem { slab: tissue.slab.clone(), load, sample_r_m: vec![0.0], sample_depth_m };
    let question = Problem3 { tilt_rad, ..Problem3::flat(&flat) };
    let mesh = MeshSpec::even(&question.flat, 9, 0.9);
    question.all_along_needle_m(&Oblique::new(&question, &mesh, 5).expect("a model"))
}

/// The largest error of the responses to any load, at an angle in rad.
fn worst_error(tissue: &TissueSpec, field: &Field, tilt_rad: f64) -> f64 {
    let responses = field.on_axis().at(libm::cos(tilt_rad));
    let of_load = |(at, load): (usize, Option<Load>)| {
        let mut unit_n = vec![0.0; 2 * tissue.layers()];
        unit_n[at] = 1.0;
        let found: Vec<f64> = (0..tissue.layers()).map(|point| responses.axial_m(point, &unit_n)).collect();
        relative_distance(&found, &on_body_m(tissue, load.expect("every layer has a length"), tilt_rad))
    };
    tissue.loads().into_iter().enumerate().map(of_load).fold(0.0, f64::max)
}

/// Soft layers that hardly give in volume: what is held at the side is felt farthest.
fn soft_body(load_radius_m: f64, tolerance: f64) -> TissueSpec {
    let mut tissue = body(load_radius_m, tolerance);
    for (layer, (thickness_m, youngs_modulus_pa, poisson_ratio)) in
        tissue.slab.layers.iter_mut().zip([(1e-3, 30e3, 0.49), (20e-3, 10e3, 0.499), (60e-3, 20e3, 0.45)])
    {
        *layer = ElasticLayer { thickness_m, youngs_modulus_pa, poisson_ratio, ..*layer };
    }
    tissue.boundaries_m = tissue.slab.boundaries_m();
    tissue
}

#[test]
fn at_every_angle_the_error_is_no_more_than_is_claimed() {
    for tissue in [body(0.5e-3, 0.01), body(1e-3, 0.05), soft_body(0.9e-3, 0.05)] {
        let field = Field::new(&tissue).expect("a field");
        let claim = field.plan().expected_relative_error;
        assert!(claim <= tissue.tolerance, "{claim}");
        for tilt_deg in TILTS_DEG {
            let error = worst_error(&tissue, &field, tilt_deg.to_radians());
            assert!(error <= claim, "{error} at {tilt_deg}°, claimed {claim}");
        }
    }
}

#[test]
fn what_the_exercise_asks_for_changes_no_response() {
    let fields = [0.0, 0.4].map(|tilt_rad| Field::new(&TissueSpec { tilt_rad, ..body(1e-3, 0.05) }).expect("a field"));
    assert_eq!(fields[0].on_axis(), fields[1].on_axis());
    assert_eq!(fields[1].planned(), &fields[0].on_axis().at(libm::cos(0.4)));
    assert!(fields[0].planned() != fields[1].planned());
}

#[test]
fn a_field_of_the_exercise_alone_is_the_same_at_every_angle() {
    for tissue in [
        TissueSpec { judging: Judging::Second, ..body(1e-3, 0.05) },
        TissueSpec { model: Some(Model::MassSpring), ..body(2e-3, 0.05) },
    ] {
        let field = Field::new(&tissue).expect("a field");
        assert_eq!(&field.on_axis().at(0.6), field.planned());
    }
}

#[test]
fn field_clamps_flatter_needles_to_the_flattest_known_angle() {
    let field = Field::new(&body(1e-3, 0.05)).expect("a field");
    let flattest = field.on_axis().at(libm::cos(FLATTEST_RAD));
    for cosine in [0.4, 0.0, -1.0] {
        assert_eq!(field.on_axis().at(cosine), flattest);
    }
    // An exercise that asks for a flatter one makes it known.
    let flat = Field::new(&TissueSpec { tilt_rad: 1.2, ..body(1e-3, 0.05) }).expect("a field");
    assert!(flat.on_axis().at(libm::cos(1.2)) != flat.on_axis().at(0.5));
    assert_eq!(flat.planned(), &flat.on_axis().at(libm::cos(1.2)));
}

#[test]
fn a_sheet_without_thickness_is_met_where_it_lies() {
    let mut tissue = body(1e-3, 0.05);
    tissue.boundaries_m = vec![0.0, 0.0008, 0.0092, 0.0092, 0.0482];
    tissue.recoil_time_s = vec![1e-3; 4];
    let responses = Field::new(&tissue).expect("a field").on_axis().at(0.8);
    let of = |point, load| responses.of_m_per_n(point, load);
    assert!(of(2, 0) > 0.0 && (of(2, 0) - of(3, 0)).abs() <= 0.0 && (of(2, 2) - of(3, 3)).abs() <= 0.0);
    assert!(of(1, 6).abs() <= 0.0, "nothing drags along it");
}
