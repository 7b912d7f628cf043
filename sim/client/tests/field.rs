//! `stylet field`: the reference case is answered as it was asked, and mistakes are one line.
//!
//! Would fail if an answer were in another sign, order or unit, or if the estimate were not the program's own.

use serde_json::Value;

use crate::{repository, stylet, text};

const CASE: &str = "tests/data/field/lower_back.json";

fn column(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .expect("rows")
        .iter()
        .flat_map(|row| row.as_array().expect("a row"))
        .filter_map(Value::as_f64)
        .collect()
}

#[test]
fn a_reference_case_is_answered_within_its_tolerance() {
    let case = repository(CASE);
    let answer = stylet(&["field", text(&case), "--tolerance", "0.01", "--json"]).ends(0).json();
    assert_eq!(answer["model"], "axisymmetric");
    let estimate = answer["estimated_relative_error"].as_f64().expect("an estimate");
    assert!(estimate > 1e-4 && estimate <= 0.01, "{estimate}");
    for key in ["unknowns", "bytes", "setup_s", "solve_s", "answer_s"] {
        assert!(answer[key].as_f64().expect("a number") > 0.0, "{key}");
    }
    assert!(true_error(&answer, &case) <= 0.01);
    assert_eq!((&answer["met"], &answer["warning"]), (&true.into(), &Value::Null));
    assert_eq!(answer["tolerance"].as_f64(), Some(0.01));
}

#[test]
fn a_table_holds_the_displacements_of_the_json_to_the_bit() {
    let case = repository(CASE);
    let answer = stylet(&["field", text(&case), "--json"]).ends(0).json();
    let run = stylet(&["field", text(&case), "--csv"]).ends(0);
    let mut lines = run.stdout.lines();
    assert_eq!(lines.next(), Some("load_depth_m,depth_m,r_m,u_axial_m,u_radial_m"));
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|number| number.parse().expect("a number")).collect()).collect();
    for (at, key) in [(3, "u_axial_m"), (4, "u_radial_m")] {
        let solutions = answer["solutions"].as_array().expect("solutions");
        let told: Vec<f64> = solutions.iter().flat_map(|solution| column(&solution[key])).collect();
        assert_eq!(rows.iter().map(|row| row[at]).collect::<Vec<_>>(), told, "{key}");
    }
    stylet(&["field", text(&case), "--csv", "--json"]).ends(2);
}

#[test]
fn a_tolerance_that_is_not_met_is_never_silent() {
    let case = repository(CASE);
    let run = stylet(&["field", text(&case), "--model", "mass-spring", "--tolerance", "0.05", "--json"]).ends(1);
    run.says(&["warning:", "the tolerance 0.05 is not met: the estimated error is"]);
    let answer = run.json();
    assert_eq!(answer["met"], false);
    assert!(answer["warning"].as_str().expect("a warning").contains("0.05 is not met"));
    assert!(answer["estimated_relative_error"].as_f64() > Some(0.05) && true_error(&answer, &case) > 0.05);
    let solve_s = answer["solve_s"].as_f64().expect("a time");
    assert!(solve_s > 1e-4, "{solve_s} s is no time for a lattice to come to rest in");
}

#[test]
fn a_depth_that_is_listed_again_is_planned_once() {
    let once = repository(CASE);
    let folder = tempfile::TempDir::new().expect("a folder");
    let again = folder.path().join("again.json");
    let mut case: Value = serde_json::from_str(&std::fs::read_to_string(&once).expect("the case")).expect("JSON");
    case["load_depths_m"] = vec![0.0; 2000].into();
    std::fs::write(&again, case.to_string()).expect("a file");
    let [one, many] = [&once, &again].map(|case| stylet(&["field", text(case), "--json"]).ends(0).json());
    let solutions = many["solutions"].as_array().expect("solutions");
    assert_eq!(solutions.len(), 2000);
    assert!(solutions.iter().all(|solution| solution["u_axial_m"] == one["solutions"][0]["u_axial_m"]));
    let [once, many] = [&one, &many].map(|answer| answer["bytes"].as_u64().expect("bytes"));
    assert!(many <= once, "one depth holds {many} bytes, three {once}");
}

#[test]
fn every_model_can_be_named_and_tells_its_own_error() {
    let case = repository("tests/data/field/homogeneous.json");
    for (model, tolerance) in [("axisymmetric", "0.01"), ("volumetric", "0.05"), ("mass-spring", "0.9")] {
        let answer =
            stylet(&["field", text(&case), "--model", model, "--tolerance", tolerance, "--json"]).ends(0).json();
        assert_eq!(answer["model"], model);
        let estimate = answer["estimated_relative_error"].as_f64().expect("an estimate");
        let error = true_error(&answer, &case);
        assert!(error <= tolerance.parse().expect("a number"), "{model}: {error}");
        assert!(error <= 3.0 * estimate && estimate <= 3.0 * error.max(1e-3), "{model}: {error}, estimated {estimate}");
    }
}

/// Largest relative L2 error of the axial and of the radial displacement, over the load depths.
fn true_error(answer: &Value, case: &std::path::Path) -> f64 {
    let reference: Value = serde_json::from_str(&std::fs::read_to_string(case).expect("the case")).expect("JSON");
    let solutions = |of: &Value| of["solutions"].as_array().expect("solutions").clone();
    let errors = solutions(answer).into_iter().zip(solutions(&reference)).map(|(found, wanted)| {
        assert_eq!(found["depth_m"], wanted["depth_m"]);
        ["u_axial_m", "u_radial_m"].map(|part| {
            let (found, wanted) = (column(&found[part]), column(&wanted[part]));
            assert_eq!(found.len(), wanted.len());
            let wrong: f64 = found.iter().zip(&wanted).map(|(f, w)| (f - w) * (f - w)).sum();
            let whole: f64 = wanted.iter().map(|w| w * w).sum();
            (wrong / whole).sqrt()
        })
    });
    let errors = errors.flatten();
    errors.fold(0.0, f64::max)
}

#[test]
fn a_person_reads_what_was_chosen_and_why() {
    let run = stylet(&["field", text(&repository(CASE)), "--tolerance", "0.1", "--model", "axisymmetric"]).ends(0);
    for word in ["axisymmetric: axisymmetric was requested", "unknowns", "estimated error", "µs", "axial mm"] {
        assert!(run.stdout.contains(word), "'{word}' is missing in: {}", run.stdout);
    }
}

#[test]
fn mistakes_are_refused_on_one_line() {
    let case = repository(CASE);
    stylet(&["field", text(&case), "--tolerance", "0"]).refused(&["--tolerance: 0", "1e-6 to 1"]);
    stylet(&["field", text(&case), "--model", "clay"]).refused(&["clay"]);
    stylet(&["field", "no-such-file.json"]).refused(&["no-such-file.json"]);
    let folder = tempfile::TempDir::new().expect("a folder");
    let bad = folder.path().join("bad.json");
    let broken = std::fs::read_to_string(&case).expect("the case").replacen("33100.0", "-1", 1);
    std::fs::write(&bad, broken).expect("a file");
    stylet(&["field", text(&bad)]).refused(&["bad.json:", "layers[1].youngs_modulus_pa"]);
}
