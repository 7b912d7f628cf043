//! The JSON of `stylet force`: the reference cases read, and mistakes are placed.
//!
//! Would fail if a field were dropped, if a typo were ignored, or if an error pointed at another layer.

use documents::force_case::parse;

use crate::support::mistake;

const TROCAR: &str = include_str!("../../../../tests/data/force/trocar.json");
const TABLE_I: &str = include_str!("../../../../tests/data/force/table_i.json");
const TRAINING: &str = include_str!("../../../../tests/data/force/training_in_hold_out_in.json");

#[test]
fn the_reference_cases_read() {
    let table_i = parse("t", TABLE_I).unwrap();
    assert_eq!((table_i.spec.tip_to_rim_m, table_i.angle_rad), (0.0, 0.0));
    let training = parse("t", TRAINING).unwrap().spec;
    assert_eq!((training.layers[1].friction_n_per_m, training.layers[1].cutting_n), (15.0, 0.1));
    assert_eq!(training.layers[2].name, "muscle");
}

#[test]
fn an_angle_and_a_rate_are_optional() {
    let text = TROCAR.replace("\"angle_rad\": 0.0,", "\"rate\": {\"p_infinity_n\": 2.0, \"v0_m_per_s\": 0.05},");
    let case = parse("t", &text).unwrap();
    assert_eq!((case.angle_rad, case.edge_rad), (0.0, 0.0));
    assert_eq!(case.spec.rate.map(|r| (r.p_infinity_n, r.v0_m_per_s)), Some((2.0, 0.05)));
}

/// Would fail if an option of version 3 were lost on its way from the file.
#[test]
fn every_option_of_version_3_is_read() {
    let options = r#""options": {"stiffening_n_per_m2": 4e4, "branches": [{"share": 0.5, "time_s": 2}], "static_friction_n_per_m": 70,
        "sheet": {"fibres": [0.6, 0.8], "along_stiffness": 0.9, "along_threshold": 0.3}}, "name": "fat""#;
    let text = TROCAR
        .replace(
            "\"angle_rad\": 0.0,",
            "\"edge_rad\": 0.5, \"law\": 3, \"breakaway\": {\"slid_m\": 1e-3, \"rest_s\": 1},",
        )
        .replace("\"name\": \"fat\"", options);
    let case = parse("t", &text).unwrap();
    assert_eq!((case.edge_rad, case.spec.law), (0.5, law::axial::ForceLaw::Version3));
    assert_eq!(case.spec.breakaway.map(|b| (b.slid_m, b.rest_s)), Some((1e-3, 1.0)));
    let read = &case.spec.layers[1].options;
    assert_eq!((read.stiffening_n_per_m2, read.static_friction_n_per_m), (4e4, Some(70.0)));
    assert_eq!(read.branches.iter().map(|b| (b.share, b.time_s)).collect::<Vec<_>>(), [(0.5, 2.0)]);
    let sheet = read.sheet.unwrap();
    assert_eq!((sheet.fibres, sheet.along_stiffness, sheet.along_threshold), ([0.6, 0.8], 0.9, 0.3));
    let four = mistake(parse, &text, ("\"law\": 3", "\"law\": 2"));
    assert!(four.contains("must be absent before version 3 of the law"), "{four}");
}

#[test]
fn a_value_out_of_range_is_placed_in_its_own_layer() {
    let second = TROCAR.replace("83.0", "-83.0");
    let error = parse("case.json", &second).unwrap_err().to_string();
    let line = second.lines().position(|l| l.contains("-83.0")).unwrap() + 1;
    assert!(error.starts_with(&format!("case.json:{line}:")), "{error}");
    assert!(error.contains("layers[1].stiffness_n_per_m: -83 N/m"), "{error}");
}

#[test]
fn mistakes_are_refused_with_line_and_column() {
    for (from, to, said) in [
        ("\"cutting_n\"", "\"cuting_n\"", "unknown field `cuting_n`"),
        ("0.0084", "\"8.4 mm\"", "invalid type"),
        ("\"thickness_m\": 0.0084,", "", "missing field `thickness_m`"),
        ("0.0084", "1e999", "out of range"),
        ("0.0084", "NaN", "case.json:"),
        ("\"angle_rad\": 0.0", "\"angle_rad\": 1.5", "angle_rad: 1.5 rad; allowed: 0 to 1.0472 rad"),
    ] {
        let error = mistake(parse, TROCAR, (from, to));
        assert!(error.contains(said), "{error}");
    }
    assert!(parse("case.json", "").unwrap_err().to_string().starts_with("case.json:1:"));
}

#[test]
fn a_case_without_layers_is_refused() {
    let start = TROCAR.find("\"layers\"").unwrap();
    let text = format!("{}\"layers\": []}}", &TROCAR[..start]);
    assert!(parse("case.json", &text).unwrap_err().to_string().contains("layers"));
}
