//! The JSON of `stylet field`: the reference cases read, depths meet boundaries, and mistakes are placed.
//!
//! Would fail if a depth missed its boundary by a rounding, if a typo were ignored, or if an error pointed elsewhere.

use documents::field_case::parse;
use tissue::LoadKind;

use crate::support::mistake;

const LOWER_BACK: &str = include_str!("../../../../tests/data/field/lower_back.json");

fn load_depth_m(problem: &tissue::Problem) -> f64 {
    match problem.load.kind {
        LoadKind::Contactor { depth_m } => depth_m,
        LoadKind::Drag { .. } => f64::NAN,
    }
}

#[test]
fn the_reference_case_reads_and_its_depths_are_its_boundaries() {
    let case = parse("c", LOWER_BACK).unwrap();
    assert_eq!((case.force_n, case.load_depths_m.len()), (0.05, 3));
    let boundaries = case.problems[0].slab.boundaries_m();
    for (problem, boundary) in case.problems.iter().zip(&boundaries) {
        assert_eq!(load_depth_m(problem).to_bits(), boundary.to_bits());
        assert_eq!(problem.sample_depth_m[2].to_bits(), boundaries[2].to_bits());
    }
}

#[test]
fn depths_of_the_load_come_before_those_of_solutions() {
    let with = LOWER_BACK.replacen("\"solutions\"", "\"load_depths_m\": [0.0040], \"solutions\"", 1);
    let case = parse("c", &with).unwrap();
    assert_eq!(case.problems.iter().map(load_depth_m).collect::<Vec<_>>(), [0.004]);
}

#[test]
fn a_layer_without_thickness_carries_nothing() {
    let empty = "{ \"thickness_m\": 0, \"youngs_modulus_pa\": 1e6, \"poisson_ratio\": 0.3 }, {";
    let with = LOWER_BACK.replacen("\"layers\": [\n  {", &format!("\"layers\": [{empty}"), 1);
    assert_ne!(with, LOWER_BACK);
    assert_eq!(parse("c", &with).unwrap().problems, parse("c", LOWER_BACK).unwrap().problems);
}

#[test]
fn mistakes_are_refused_with_their_place() {
    for (from, to, said) in [
        ("\"poisson_ratio\": 0.45", "\"poisson_ratio\": 0.5", "layers[0].poisson_ratio: 0.5"),
        ("\"radius_m\": 0.05", "\"radius_m\": 0", "radius_m: 0 m"),
        ("\"load_radius_m\": 0.001", "\"load_radius_m\": -1", "load_radius_m: -1 m"),
        ("\"force_n\": 0.05", "\"force_n\": 1e300", "force_n"),
        ("\"force_n\"", "\"force\"", "unknown field `force`"),
        ("0.00025", "0.25", "sample_r_m[1]: 0.25 m"),
    ] {
        let error = mistake(parse, LOWER_BACK, (from, to));
        assert!(error.contains(said), "{error}");
    }
    assert!(parse("case.json", "{}").unwrap_err().to_string().starts_with("case.json:1:"));
}
