//! Where a scene's numbers come from: their classes, and the ranges that measured ones must stay in.
//!
//! Would fail if a number were counted twice or not at all, or if a measured number could leave its range in silence.

use documents::ClassCounts;

use crate::support::{SCENE, folder, read_text, scene};

const LAYER: &str = "tip_rupture_n = 0.5\n";

fn with_provenance(rows: &str) -> String {
    SCENE.replace(LAYER, &format!("{LAYER}provenance = [{rows}]\n"))
}

#[test]
fn numbers_without_provenance_are_choices() {
    let counts = scene(SCENE).count_classes();
    let known = scene(&with_provenance(
        "{ key = \"thickness_mm\", class = \"measured\", low = 6, high = 12, source = \"a study\" }, \
         { key = \"tip_rupture_n\", class = \"derived\" }, { key = \"cutting_n\", class = \"derived\" }",
    ));
    // The layer has no cutting force, so that its class counts nothing.
    let expected = ClassCounts { measured: 1, derived: 1, choices: counts.choices - 2 };
    assert_eq!((counts.measured, counts.derived, known.count_classes()), (0, 0, expected));
    assert!(known.list_departed_numbers().is_empty());
}

#[test]
fn measured_number_outside_its_range_is_remarked() {
    let row = "{ key = \"thickness_mm\", class = \"measured\", low = 1, high = 2 }";
    let remarks = scene(&with_provenance(row)).list_departed_numbers();
    assert_eq!(remarks.len(), 1);
    assert_eq!(remarks[0].field, "layer[1].thickness_mm");
    assert_eq!(remarks[0].allowed.to_string(), "published: 1 to 2");
}

#[test]
fn incomplete_provenance_is_refused_at_its_key() {
    let refused = |rows: &str| read_text(&folder(), &with_provenance(rows)).expect_err("refused").to_string();
    let missing = refused("{ key = \"thickness_mm\", class = \"measured\", low = 1 }");
    assert!(missing.contains("layer[1].provenance[0].high: missing"), "{missing}");
    let twice = refused("{ key = \"cutting_n\", class = \"choice\" }, { key = \"cutting_n\", class = \"derived\" }");
    assert!(twice.contains("layer[1].provenance[1].key: cutting_n; allowed: each number once"), "{twice}");
    let swapped = refused("{ key = \"cutting_n\", class = \"choice\", low = 3, high = 1 }");
    assert!(swapped.contains("provenance[0].low: 3; allowed: at most high, 1"), "{swapped}");
    let unknown = refused("{ key = \"title\", class = \"guessed\" }");
    assert!(unknown.contains("measured, derived, choice"), "{unknown}");
}
