//! Documents that must be refused, each with the line, column, field, value, unit and what is allowed.
//!
//! Would fail if a mistake slipped through, or were reported without its place or its remedy.

use documents::Issue;
use documents::load::read_document;
use phrase::Phrase;

use crate::support::{CURRICULUM, EXERCISE, INSTRUMENT, SCENE, folder, read_text, write};

/// The error of a text whose `from` was replaced by `to`.
fn error(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from} is not in the document");
    let text = text.replacen(from, to, 1);
    match read_text(&folder(), &text) {
        Err(error) => {
            error.issues.iter().for_each(|issue| can_be_translated(issue, &text));
            error.to_string()
        }
        Ok(document) => panic!("accepted: {document:?}"),
    }
}

/// What is not a sentence, which a catalogue may hold, was written by somebody, or is what a library or the system says.
fn can_be_translated(issue: &Issue, text: &str) {
    assert!(matches!(issue.allowed, Phrase::Sentence { .. }), "{issue}");
    if let Phrase::Data(found) = &issue.found
        && issue.field != "TOML"
        && !found.contains("(os error ")
    {
        let written = found.split(' ').next().unwrap().trim_matches('"').trim_end_matches('…');
        assert!(text.contains(written), "{issue}");
    }
}

/// Asserts that an error says all of it.
fn says(error: &str, parts: &[&str]) {
    for part in parts {
        assert!(error.contains(part), "{part:?} is not said by:\n{error}");
    }
}

#[test]
fn unknown_key_is_reported_with_its_place_and_nearest_match() {
    says(&error(SCENE, "title =", "titel ="), &["document.toml:2:1: titel: unknown key", "did you mean `title`?"]);
}

#[test]
fn a_unit_in_the_wrong_key_is_refused_and_the_right_key_named() {
    says(
        &error(SCENE, "thickness_mm = 0.8", "thickness_m = 0.0008"),
        &[":6:1: layer[0].thickness_m: unknown key", "did you mean `thickness_mm`? The unit is part of the key"],
    );
    says(
        &error(SCENE, "stiffness_n_per_m = 83", "stiffness_n_per_mm = 0.083"),
        &["layer[1].stiffness_n_per_mm: unknown key", "did you mean `stiffness_n_per_m`?"],
    );
}

#[test]
fn a_number_out_of_range_is_shown_with_its_unit_and_the_range() {
    says(
        &error(SCENE, "thickness_mm = 8.4", "thickness_mm = -8.4"),
        &[":13:16: layer[1].thickness_mm: -8.4 mm", "allowed: a number from 0 to 500 mm"],
    );
    says(
        &error(SCENE, "diameter_mm = 2.0", "diameter_mm = 2000"),
        &["needle.diameter_mm: 2000 mm", "from 0.1 to 15 mm"],
    );
}

#[test]
fn numbers_that_are_not_finite_are_refused_in_every_spelling() {
    for value in ["nan", "+nan", "-nan", "inf", "+inf", "-inf", "1e999"] {
        let error = error(SCENE, "thickness_mm = 8.4", &format!("thickness_mm = {value}"));
        says(&error, &["layer[1].thickness_mm", value, "mm"]);
    }
}

#[test]
fn a_value_of_the_wrong_type_is_refused() {
    says(&error(SCENE, "= 8.4", "= \"8.4\""), &["layer[1].thickness_mm: \"8.4\" mm", "a number"]);
    says(&error(SCENE, "\"skin\"", "7"), &["layer[0].name: 7"]);
    says(&error(SCENE, "diameter_mm = 2.0", "flexible = \"no\""), &["needle.flexible", "true or false"]);
    says(&error(SCENE, "[needle]\ndiameter_mm = 2.0", "[[needle]]\ndiameter_mm = 2.0"), &["needle", "a table"]);
}

#[test]
fn a_missing_key_is_named_where_its_table_begins() {
    says(
        &error(SCENE, "tip_rupture_n = 0.5\n", ""),
        &[":11:1: layer[1].tip_rupture_n: missing", "a number from 0 to 100 N"],
    );
}

#[test]
fn a_scene_without_layers_is_refused() {
    let without = &SCENE[..SCENE.find("[[layer]]").unwrap()];
    let needle = format!("{without}[needle]\ndiameter_mm = 2\n");
    says(&read_text(&folder(), &needle).unwrap_err().to_string(), &["layer: missing", "1 to 32 tables"]);
    says(&read_text(&folder(), &format!("layer = []\n{without}")).unwrap_err().to_string(), &["layer: 0 tables"]);
    says(&read_text(&folder(), without).unwrap_err().to_string(), &["of an unknown kind", "[[layer]]"]);
}

#[test]
fn every_issue_is_reported_at_once_and_in_order() {
    let text = SCENE.replace("8.4", "-1").replace("name = \"fat\"", "name = \"skin\"").replace("2.0", "inf");
    let issues = read_text(&folder(), &text).unwrap_err().issues;
    let fields: Vec<_> = issues.iter().map(|i| i.field.as_str()).collect();
    assert_eq!(fields, ["layer[1].name", "layer[1].thickness_mm", "needle.diameter_mm"]);
    assert!(issues.is_sorted_by_key(|i| (i.line, i.column)));
}

#[test]
fn names_must_be_unique_and_fit_into_metric_ids() {
    says(&error(SCENE, "name = \"fat\"", "name = \"skin\""), &["layer[1].name: \"skin\"", "layer[0] already has it"]);
    says(&error(SCENE, "name = \"fat\"", "name = \"f.at\""), &["layer[1].name", "without a dot"]);
    says(&error(SCENE, "id = \"small\"", "id = \"a b\""), &["id: \"a b\"", "letters, digits"]);
}

#[test]
fn text_that_is_not_toml_is_refused_with_its_place() {
    says(&error(SCENE, "id = \"small\"", "id = "), &["document.toml:1:", "TOML"]);
    says(&error(SCENE, "title = \"Small\"", "id = \"again\""), &["document.toml:2:1", "duplicate key"]);
    let error = read_document(&write(&folder(), "latin.toml", b"id = \"x\"\ntitle = \"\xe9\"\n")).unwrap_err();
    says(&error.to_string(), &["latin.toml:2:10", "UTF-8"]);
}

#[test]
fn a_needle_has_no_rim_and_a_trocars_rim_needs_thresholds() {
    let bad = "kind = \"needle\"\ntip_to_rim_mm = 2";
    says(&error(SCENE, "diameter_mm = 2.0", bad), &["needle.tip_to_rim_mm: 2 mm", "no rim"]);
    says(&error(SCENE, "rim_rupture_n = 0.6\n", ""), &["layer[1].rim_rupture_n: missing", "needed for a trocar"]);
    says(&error(SCENE, "diameter_mm = 2.0", "flexible = true"), &["needle.flexible: true", "a trocar is rigid"]);
    let wide = "diameter_mm = 2.0\ninner_diameter_mm = 2.0";
    says(&error(SCENE, "diameter_mm = 2.0", wide), &["needle.inner_diameter_mm: 2 mm", "less than 2 mm"]);
    let coupled = "[tissue]\nmodel = \"none\"\ncoupling = \"field\"\n[needle]";
    says(&error(SCENE, "[needle]", coupled), &["tissue.coupling: \"field\"", "model = \"none\" has no field"]);
}

#[test]
fn a_structure_has_the_keys_of_its_shape() {
    let with = |keys: &str| {
        let structure = format!("[[structure]]\nname = \"v\"\nkind = \"vessel\"\nposition_mm = [0, 0, -20]\n{keys}\n");
        format!("{structure}[needle]")
    };
    says(
        &error(SCENE, "[needle]", &with("shape = \"sphere\"")),
        &["structure[0].radius_mm: missing", "required for a sphere"],
    );
    let twice = with("shape = \"sphere\"\nradius_mm = 2\nhalf_extents_mm = [1, 1, 1]");
    says(&error(SCENE, "[needle]", &twice), &["structure[0].half_extents_mm: not a key of this shape"]);
    let flat = with("shape = \"box\"\nhalf_extents_mm = [1, 0, 1]");
    says(&error(SCENE, "[needle]", &flat), &["structure[0].half_extents_mm", "each above 0 mm"]);
    let far = with("shape = \"sphere\"\nradius_mm = 2").replace("-20", "-2000");
    says(&error(SCENE, "[needle]", &far), &["structure[0].position_mm: [0, 0, -2000] mm", "from -1500 to 1500 mm"]);
}

#[test]
fn an_exercise_that_cannot_be_scored_is_refused() {
    says(&error(EXERCISE, "zero = 4", "zero = 0.5"), &["rubric[0].zero: 0.5", "other than full"]);
    says(&error(EXERCISE, "zero = 4", "zero = 4\nweight = 0"), &["rubric[0].weight: 0"]);
    says(&error(EXERCISE, "title =", "pass_mark = 101\ntitle ="), &["pass_mark: 101", "from 0 to 100"]);
    says(
        &error(EXERCISE, "depth_mm = 20", "depth_mm = 160"),
        &["target.depth_mm: 160 mm", "150 mm, the needle's length"],
    );
    says(
        &error(EXERCISE, "[target]", "[required]\nreached = \"brain\"\n[target]"),
        &["required.reached: \"brain\"", "skin"],
    );
    says(
        &error(EXERCISE, "[target]", "[required]\nwithin_mm = 0\n[target]"),
        &["required.within_mm: 0 mm", "from 0.1"],
    );
    says(
        &error(EXERCISE, "[target]", "[required]\nconfirmed = 1\n[target]"),
        &["required.confirmed: 1", "true or false"],
    );
    says(
        &error(EXERCISE, "zero = 4", "zero = 4\nversion = 2"),
        &["rubric[0].version: 2", "no such version; allowed: 1 to 1"],
    );
    let twice = "[[rubric]]\nmetric = \"depth_error_mm\"\nfull = 1\nzero = 2\n\n[[rubric]]\n";
    says(&error(EXERCISE, "[[rubric]]\n", twice), &["rubric[1].metric", "must be unique"]);
}

#[test]
fn a_metric_that_the_scene_cannot_have_is_refused() {
    for (metric, why) in [
        ("depth_eror_mm", "not a metric"),
        ("depth_error_mm.skin", "allowed in this scene: depth_error_mm"),
        ("peak_force_layer_n", "peak_force_layer_n.skin, peak_force_layer_n.fat"),
        ("peak_force_layer_n.bone", "peak_force_layer_n.skin"),
        ("over_insertion_mm.skin", "over_insertion_mm.skin.tip, over_insertion_mm.skin.rim"),
        ("cutting_energy_mj.liver", "cutting_energy_mj, cutting_energy_mj.skin"),
        ("structure_hits.liver", "structure_hits.vessel"),
        ("structure_clearance_mm.artery", "nothing that structure_clearance_mm could refer to"),
    ] {
        says(&error(EXERCISE, "depth_error_mm", metric), &["rubric[0].metric", metric, why]);
        let fail = format!("[[hard_fail]]\nmetric = \"{metric}\"\nabove = 1\nwhy = \"x\"\n\n[[rubric]]");
        says(&error(EXERCISE, "[[rubric]]", &fail), &["hard_fail[0].metric", metric, why]);
    }
}

#[test]
fn coaching_must_arm_again_below_its_limit() {
    let rule = "[[coaching]]\nquantity = \"force_n\"\nabove = 4\nrearm_below = 5\nmessage = \"x\"\n\n[[rubric]]";
    says(&error(EXERCISE, "[[rubric]]", rule), &["coaching[0].rearm_below: 5", "at most 4"]);
}

#[test]
fn a_missing_scene_is_reported_where_it_is_named() {
    let error = error(EXERCISE, "\"scene.toml\"", "\"gone.toml\"");
    says(&error, &["document.toml:3:9: scene:", "gone.toml", "No such file"]);
}

#[test]
fn issues_of_a_scene_are_reported_with_those_of_its_exercise() {
    let folder = folder();
    write(&folder, "scene.toml", SCENE.replace("8.4", "-8.4"));
    let text = EXERCISE.replace("title =", "difficulty = 9\ntitle =");
    let issues = read_text(&folder, &text).unwrap_err().issues;
    let fields: Vec<_> = issues.iter().map(|i| i.field.as_str()).collect();
    assert_eq!(fields, ["difficulty", "layer[1].thickness_mm"]);
    assert!(issues[1].file.ends_with("scene.toml"));
}

#[test]
fn prerequisites_that_need_themselves_are_named_as_a_path() {
    let cycle = "file = \"a.toml\"\nprerequisites = [\"b\"]";
    says(
        &error(CURRICULUM, "file = \"a.toml\"", cycle),
        &["exercise[0].prerequisites", "a → b → a", "without a cycle"],
    );
    says(&error(CURRICULUM, "[\"a\"]", "[\"b\"]"), &["exercise[1].prerequisites", "b → b"]);
}

#[test]
fn a_curriculum_names_what_exists_and_only_once() {
    says(&error(CURRICULUM, "[\"a\"]", "[\"c\"]"), &["exercise[1].prerequisites: \"c\"", "allowed: a, b"]);
    says(&error(CURRICULUM, "b.toml", "gone.toml"), &[":13:8: exercise[1].file:", "gone.toml", "No such file"]);
    says(&error(CURRICULUM, "b.toml", "a.toml"), &["exercise[1].file: \"a.toml\"", "must be unique"]);
    let folder = folder();
    write(&folder, "b.toml", EXERCISE.replace("\"one\"", "\"a\""));
    says(&read_text(&folder, CURRICULUM).unwrap_err().to_string(), &["exercise[1].file: \"a\"", "already has this id"]);
}

#[test]
fn a_mastery_rule_has_its_own_keys() {
    says(&error(CURRICULUM, "of = 5", ""), &["mastery.of: missing", "required for the rule passes"]);
    says(&error(CURRICULUM, "passes = 3", "passes = 6"), &["mastery.passes: 6", "at most 5"]);
    says(&error(CURRICULUM, "of = 5", "of = 5\np0 = 0.1"), &["mastery.p0: not a key of this rule"]);
    let cusum = "rule = \"cusum\"\np0 = 0.2\np1 = 0.1\nalpha = 0.1\nbeta = 0.1";
    says(&error(CURRICULUM, "rule = \"passes\"\npasses = 3\nof = 5", cusum), &["mastery.p1: 0.1", "above 0.2"]);
}

#[test]
fn a_document_that_is_too_long_is_refused_unread() {
    let text = format!("{SCENE}# {}", "x".repeat(300_000));
    says(&read_text(&folder(), &text).unwrap_err().to_string(), &["bytes; allowed: at most 262144 bytes"]);
}

#[test]
fn each_issue_is_one_line() {
    let text = SCENE.replace("\"Small\"", "[\n1,\n2]").replace("[needle]", "\"odd\\nkey\" = 1\n[needle]");
    for issue in read_text(&folder(), &text).unwrap_err().issues {
        assert!(!issue.to_string().contains('\n'), "{issue}");
    }
}

#[test]
fn no_prefix_of_a_document_makes_the_reader_panic() {
    let folder = folder();
    for text in [SCENE, EXERCISE, CURRICULUM, INSTRUMENT] {
        for end in (0..text.len()).filter(|end| text.is_char_boundary(*end)) {
            let _ = read_text(&folder, &text[..end]);
        }
    }
}
