//! What a field claims of an attempt is what the attempt sees: every boundary pushed, the shaft's drag along every layer, on the
//! whole body. It would fail where the claim is that of a push on the skin, or of the patch that it was computed on.

use tissue::axisymmetric::{Axisymmetric, MeshSpec};
use tissue::follow::{AttemptLoad, Field, TissueSpec};
use tissue::{FieldModel, Judging, Load, Problem, relative_distance};

use crate::follow;

/// The lower back in the middle of a body, under a needle of a radius in m.
fn body(load_radius_m: f64, tolerance: f64) -> TissueSpec {
    let mut tissue = TissueSpec { load_radius_m, tolerance, ..follow::lower_back() };
    tissue.slab.radius_m = 0.25;
    tissue
}

/// Displacement of every boundary on the axis, in m/N, by a mesh far finer than any that is chosen.
fn on_body_m(tissue: &TissueSpec, load: Load) -> Vec<f64> {
    let sample_depth_m = tissue.boundaries_m[..tissue.layers()].to_vec();
    let problem = Problem { slab: tissue.slab.clone(), load, sample_r_m: vec![0.0], sample_depth_m };
    let mesh = MeshSpec::even(&problem, 10, 0.7).graded_to_side();
    let model = Axisymmetric::new(&problem, &mesh).expect("a model");
    problem.sample_depth_m.iter().map(|&depth_m| -model.displacement_m(0.0, depth_m)[0]).collect()
}

/// The relative error of the responses to each load.
fn errors(tissue: &TissueSpec, field: &Field) -> Vec<f64> {
    let loads = tissue.loads();
    let error = |at: usize, load: Load| {
        let mut unit_n = vec![0.0; loads.len()];
        unit_n[at] = 1.0;
        let found: Vec<f64> = (0..tissue.layers()).map(|point| field.planned().axial_m(point, &unit_n)).collect();
        relative_distance(&found, &on_body_m(tissue, load))
    };
    loads.iter().enumerate().map(|(at, load)| error(at, load.expect("every layer has a length"))).collect()
}

#[test]
fn claimed_error_is_of_the_worst_load_and_meets_the_tolerance() {
    for (radius_m, tolerance) in [(1e-3, 0.05), (1.75e-3, 0.05), (1e-3, 0.002), (0.4e-3, 0.01)] {
        let tissue = TissueSpec { judging: Judging::Second, ..body(radius_m, tolerance) };
        let field = Field::new(&tissue).expect("a field");
        let (errors, claim) = (errors(&tissue, &field), field.plan().expected_relative_error);
        let worst = errors.iter().copied().fold(0.0, f64::max);
        assert!(claim <= tolerance, "{claim} of {tolerance}");
        assert!(worst <= 1.1 * claim && claim <= 1.5 * worst, "{worst}, claimed {claim}: {errors:?}");
        let named = match field.plan().worst.expect("a load") {
            AttemptLoad::Push(boundary) => boundary,
            AttemptLoad::Drag(layer) => tissue.layers() + layer,
        };
        assert!(errors[named] > 0.8 * worst, "{named} of {errors:?}");
    }
}

#[test]
fn a_push_on_the_skin_alone_claims_less_than_the_attempt_sees() {
    let tissue = TissueSpec { judging: Judging::First, ..body(1.75e-3, 0.05) };
    let field = Field::new(&tissue).expect("a field");
    let worst = errors(&tissue, &field).into_iter().fold(0.0, f64::max);
    let claim = field.plan().expected_relative_error;
    assert!(worst > 1.5 * claim && worst > 0.05, "{worst}, claimed {claim}");
    assert_eq!(field.plan().worst, None);
}

#[test]
fn a_model_that_cannot_meet_its_tolerance_says_by_how_much() {
    let tissue = TissueSpec { model: Some(tissue::Model::MassSpring), ..body(2e-3, 0.05) };
    let field = Field::new(&tissue).expect("a field");
    let worst = errors(&tissue, &field).into_iter().fold(0.0, f64::max);
    let claim = field.plan().expected_relative_error;
    assert!(claim > 0.05 && worst <= 1.1 * claim && claim <= 1.5 * worst, "{worst}, claimed {claim}");
}
