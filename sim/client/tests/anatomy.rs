//! `stylet anatomy body`: which files it writes, and its refusals. Would fail if a part were left out, the table lost a column, or a
//! body that nobody has were made.

use std::fs;

use tempfile::TempDir;

use crate::{stylet, text};

#[test]
fn a_body_is_written_part_by_part() {
    let folder = TempDir::new().expect("a folder");
    let out = folder.path().join("body");
    let run =
        stylet(&["anatomy", "body", "--posture", "sitting", "--seed", "3", "--quality", "low", "--out", text(&out)])
            .ends(0);
    assert!(run.stdout.contains("41 parts"), "{}", run.stdout);
    let stl = fs::read(out.join("vertebra-L3.stl")).expect("a mesh");
    let count = u32::from_le_bytes([stl[80], stl[81], stl[82], stl[83]]) as usize;
    assert!(count > 500 && stl.len() == 84 + 50 * count, "{count} triangles in {} bytes", stl.len());
    let table = fs::read_to_string(out.join("body.csv")).expect("the dimensions");
    assert!(table.starts_with("dimension,level,body,published_mean,published_sd,standing,source\n"), "{table}");
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(out.join("body.json")).expect("the report")).expect("JSON");
    assert_eq!(json["posture"], "sitting");
    assert!(json["triangles"].as_u64().is_some_and(|all| (10_000..100_000).contains(&all)), "{json}");
}

#[test]
fn a_body_that_nobody_has_is_refused() {
    let refused = |option: &str, value: &str, parts: &[&str]| {
        stylet(&["anatomy", "body", "--posture", "prone", option, value, "--out", "nowhere"]).refused(parts);
    };
    refused("--weight-kg", "12", &["weight_kg = 12 kg", "40 to 160 kg"]);
    refused("--weight-kg", "NaN", &["weight_kg = NaN kg", "40 to 160 kg"]);
    refused("--age-years", "7", &["age_years = 7", "18 to 95 years"]);
    refused("--posture", "standing", &["--posture"]);
    assert!(!std::path::Path::new("nowhere").exists());
}
