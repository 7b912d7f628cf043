//! `stylet check` and `stylet schema`: every issue of every file with its place; sound documents with their closed form.
//! Would fail if a bad document were let through, if only its first issue were named, or if the closed form moved.

use std::fs;
use std::path::PathBuf;

use serde_json::Value;
use tempfile::TempDir;

use crate::{Run, repository, stylet, text};

/// Checks the paper's scene after a change to its text.
fn changed(from: &str, to: &str) -> (TempDir, Run) {
    let paper = fs::read_to_string(repository("curricula/scenes/lower-back-paper.toml")).expect("a scene");
    assert!(paper.contains(from), "'{from}' is not in the scene");
    let folder = TempDir::new().expect("a folder");
    let file = folder.path().join("scene.toml");
    fs::write(&file, paper.replacen(from, to, 1)).expect("a file");
    let run = stylet(&["check", text(&file)]);
    (folder, run)
}

/// Asserts that a change is found (exit 1) and named with file, line and the given parts.
#[track_caller]
fn found(from: &str, to: &str, parts: &[&str]) {
    let (_folder, run) = changed(from, to);
    let run = run.ends(1);
    run.says(parts);
    for line in run.stderr.lines() {
        let place = line.split_once("scene.toml:").expect("a file").1;
        let line: usize = place.split(':').next().expect("a line").parse().expect("a number");
        assert!(line > 0);
    }
}

fn shipped() -> Vec<PathBuf> {
    let scenes = fs::read_dir(repository("curricula/scenes")).expect("a folder");
    let scenes = scenes.map(|entry| entry.expect("an entry").path());
    let folders = fs::read_dir(repository("curricula")).expect("a folder").map(|entry| entry.expect("an entry").path());
    let courses = folders.map(|folder| folder.join("course.toml")).filter(|course| course.is_file());
    scenes.chain(courses).collect()
}

#[test]
fn everything_shipped_is_sound() {
    let files = shipped();
    let args: Vec<&str> = ["check", "--json"].into_iter().chain(files.iter().map(|file| text(file))).collect();
    let run = stylet(&args).ends(0);
    assert_eq!(run.stderr, "");
    let reports = run.json();
    assert_eq!(reports.as_array().map(Vec::len), Some(files.len()));
    let courses = reports.as_array().expect("reports").iter().filter(|report| report["kind"] == "curriculum");
    let exercises: Vec<usize> = courses.map(|course| course["plans"].as_array().expect("plans").len()).collect();
    assert!(exercises.len() >= 5 && exercises.iter().sum::<usize>() >= 13, "{exercises:?}");
    for plan in
        reports.as_array().expect("reports").iter().flat_map(|report| report["plans"].as_array().expect("plans"))
    {
        assert_eq!(plan["model"], "axisymmetric", "{plan}");
        let number = |key: &str| plan[key].as_f64().expect("a number");
        assert!(number("bytes") > 0.0 && number("bytes") <= 64e6, "{plan}");
        assert!(number("unknowns") > 0.0 && number("expected_relative_error") > 0.0, "{plan}");
        assert!(number("expected_relative_error") <= number("tolerance") && plan["met"] == true, "{plan}");
        let worst = plan["worst_load"].as_str().expect("a load");
        assert!(worst.starts_with("push on ") || worst.starts_with("drag along "), "{worst}");
    }
}

/// The plan of the training scene with a table for its tissue.
fn plan_with(tissue: &str) -> Value {
    let folder = TempDir::new().expect("a folder");
    let scene = fs::read_to_string(repository("curricula/scenes/lower-back-training.toml")).expect("a scene");
    let file = folder.path().join("scene.toml");
    fs::write(&file, scene.replacen("[needle]", &format!("[tissue]\n{tissue}\n[needle]"), 1)).expect("a file");
    stylet(&["check", "--json", text(&file)]).ends(0).json()[0]["plans"][0].clone()
}

#[test]
fn a_scene_pays_only_for_the_tissue_that_it_names() {
    let none = plan_with("model = \"none\"");
    assert_eq!(
        (&none["model"], &none["reason"].as_str().map(|why| why.contains("force law alone"))),
        (&"none".into(), &Some(true))
    );
    for free in ["unknowns", "bytes", "setup_s", "step_s", "radius_mm"] {
        assert_eq!(none[free].as_f64(), Some(0.0), "{free}");
    }
    let [coarse, fine] = ["tolerance = 0.2", "tolerance = 0.01"].map(plan_with);
    for grows in ["unknowns", "bytes", "radius_mm"] {
        assert!(fine[grows].as_f64() > coarse[grows].as_f64(), "{grows}: {fine} {coarse}");
    }
    assert!(fine["expected_relative_error"].as_f64() < coarse["expected_relative_error"].as_f64());
}

#[test]
fn unmet_tissue_tolerance_is_reported_with_its_worst_load() {
    let folder = TempDir::new().expect("a folder");
    let scene = fs::read_to_string(repository("curricula/scenes/lower-back-training.toml")).expect("a scene");
    let file = folder.path().join("scene.toml");
    let springs = "[tissue]\nmodel = \"mass-spring\"\ntolerance = 0.02\n[needle]";
    fs::write(&file, scene.replacen("[needle]", springs, 1)).expect("a file");
    let run = stylet(&["check", "--json", text(&file)]).ends(0);
    let plan = run.json()[0]["plans"][0].clone();
    assert!(plan["met"] == false && plan["expected_relative_error"].as_f64() > Some(0.02), "{plan}");
    run.says(&[
        "warning:",
        "scene.toml: [tissue] tolerance = 0.02 is not met",
        plan["worst_load"].as_str().expect("a load"),
    ]);
}

#[test]
fn paper_trocar_ruptures_where_the_closed_form_predicts() {
    let scene = repository("curricula/scenes/lower-back-paper.toml");
    let run = stylet(&["check", "--json", text(&scene)]).ends(0);
    let report = run.json();
    let ruptures = report[0]["plans"][0]["ruptures"].as_array().expect("ruptures").clone();
    let expected = [(3.021, 1.0), (5.927, 1.726), (6.824, 0.5), (10.029, 1.012), (12.218, 1.5), (15.023, 1.9)];
    assert_eq!(ruptures.len(), expected.len());
    for (rupture, (x_mm, force_n)) in ruptures.iter().zip(expected) {
        assert!((rupture["x_mm"].as_f64().expect("a number") - x_mm).abs() < 5e-4, "{rupture}");
        assert!((rupture["force_before_n"].as_f64().expect("a number") - force_n).abs() < 5e-4, "{rupture}");
    }
}

#[test]
fn people_see_layers_spread_ruptures_and_the_model() {
    let scene = repository("curricula/scenes/lower-back-training.toml");
    let run = stylet(&["check", text(&scene)]).ends(0);
    for part in [
        "1.9 ± 0.2",
        "tip into skin",
        "5.008",
        "2.445",
        "model axisymmetric: ",
        "unknowns within",
        "expected error",
        "worst under the ",
    ] {
        assert!(run.stdout.contains(part), "'{part}' is missing in: {}", run.stdout);
    }
}

#[test]
fn people_are_told_which_needle_the_ruptures_hold_for() {
    let plain = fs::read_to_string(repository("curricula/scenes/lower-back-training.toml")).expect("a scene");
    let muscle = "[[layer.relaxation]]\nshare = 0.4\ntime_s = 2\n[layer.fibres]\nangle_deg = 30\nalong_threshold = 0.8\n[needle]";
    let optioned = plain.replacen("tip = \"diamond\"", "tip = \"bevel\"", 1).replacen("[needle]", muscle, 1);
    let folder = TempDir::new().expect("a folder");
    let file = folder.path().join("scene.toml");
    for (scene, told) in [(&plain, false), (&optioned, true)] {
        fs::write(&file, scene).expect("a file");
        let run = stylet(&["check", text(&file)]).ends(0);
        for part in ["of a needle: so slow that every boundary relaxes", "of a needle: its edge along the patient's x"]
        {
            assert_eq!(run.stdout.contains(part), told, "'{part}': {}", run.stdout);
        }
    }
}

#[test]
fn bad_documents_are_found_with_the_place() {
    found("thickness_mm = 0.8", "thickness_mm = -0.8", &["layer[0].thickness_mm", "-0.8 mm"]);
    found("thickness_mm = 0.8", "thickness_mm = nan", &["layer[0].thickness_mm", "nan"]);
    found("thickness_mm = 0.8", "thickness_m = 0.0008", &["thickness_m", "thickness_mm"]);
    found("stiffness_n_per_m = 331", "stifness_n_per_m = 331", &["stifness_n_per_m", "stiffness_n_per_m"]);
    found("id = ", "id = = ", &["scene.toml:"]);
}

#[test]
fn an_unsound_scene_is_refused_with_what_would_be_sound() {
    // Softer fat is tented 11 mm deep before it gives 0.5 N; the muscle, tented 3 mm by then, takes over with 1.3 N.
    let (_folder, run) = changed("stiffness_n_per_m = 83", "stiffness_n_per_m = 45");
    let run = run.ends(1);
    run.says(&["scene.toml:", "boundary 1 (fat)", "unsound", " N", " mJ", "largest sound threshold is"]);
}

#[test]
fn a_prerequisite_cycle_is_found() {
    let folder = TempDir::new().expect("a folder");
    let course = fs::read_to_string(repository("curricula/lower-back-basics/course.toml")).expect("a course");
    let copy = |from: &str| {
        let to = folder.path().join(from);
        fs::create_dir_all(&to).expect("a folder");
        for entry in fs::read_dir(repository("curricula").join(from)).expect("a folder") {
            let entry = entry.expect("an entry");
            fs::copy(entry.path(), to.join(entry.file_name())).expect("a copy");
        }
    };
    copy("scenes");
    copy("lower-back-basics");
    let file = folder.path().join("lower-back-basics/course.toml");
    // The first exercise comes to need the second, which needs the first.
    let first = "file = \"1-feel-the-layers.toml\"\n";
    assert!(course.contains(first));
    fs::write(&file, course.replacen(first, &format!("{first}prerequisites = [\"stop-in-the-fat\"]\n"), 1))
        .expect("a file");
    stylet(&["check", text(&file)]).ends(1).says(&["course.toml:", "prerequisite"]);
}

/// Checks the shipped exercise "stop in the fat" after changes to its text.
fn exercise_with(changes: &[(&str, &str)]) -> Run {
    let folder = TempDir::new().expect("a folder");
    let [course, scenes] = ["course", "scenes"].map(|name| folder.path().join(name));
    fs::create_dir_all(&course).expect("a folder");
    fs::create_dir_all(&scenes).expect("a folder");
    let scene = "lower-back-training.toml";
    fs::copy(repository("curricula/scenes").join(scene), scenes.join(scene)).expect("a copy");
    let shipped = repository("curricula/lower-back-basics/2-stop-in-the-fat.toml");
    let mut exercise = fs::read_to_string(shipped).expect("an exercise");
    for (from, to) in changes {
        assert!(exercise.contains(from), "'{from}' is not in the exercise");
        exercise = exercise.replacen(from, to, 1);
    }
    let file = course.join("exercise.toml");
    fs::write(&file, exercise).expect("a file");
    stylet(&["check", text(&file)])
}

const REQUIRED: &str = "reached = \"fat\"\nwithin_mm = 1.4\nconfirmed = true\nwithdrawn = true\n";

#[test]
fn a_rubric_that_pays_for_nothing_or_does_not_care_is_found() {
    exercise_with(&[]).ends(0);
    let careless = exercise_with(&[(REQUIRED, "")]).ends(1);
    careless.says(&[
        "exercise.toml:",
        "required: ",
        "a prick of",
        "the position is not confirmed",
        "the needle is not withdrawn",
        "`required`",
    ]);
    exercise_with(&[("confirmed = true", "confirmed = false")]).ends(1).says(&["the position is not confirmed"]);
    exercise_with(&[("withdrawn = true", "withdrawn = false")]).ends(1).says(&["the needle is not withdrawn"]);
    let before = exercise_with(&[(&format!("[required]\n{REQUIRED}"), "")]).ends(1);
    before.says(&["a prick of", "earns 60 points", "at most 25 points", "the position is not confirmed"]);
}

#[test]
fn check_locates_reversed_rubric_lines_and_unoffered_metrics() {
    let reversed = exercise_with(&[("full = 0.5\nzero = 5", "full = 5\nzero = 0.5")]).ends(1);
    reversed.says(&["rubric[1].full", "full 5, zero 0.5", "lower overshoot_mm is better"]);
    let unoffered = exercise_with(&[("\"over_insertion_mm.skin.rim\"", "\"stop_time_s.skin.rim\"")]).ends(1);
    unoffered.says(&["rubric[2].metric", "stop_time_s.skin.rim, version 1", "not recommended", "version 2"]);
    let line = unoffered.stderr.split("exercise.toml:").nth(1).and_then(|at| at.split(':').next());
    assert!(line.and_then(|line| line.parse::<usize>().ok()).is_some_and(|line| line > 20), "{}", unoffered.stderr);
}

#[test]
fn a_file_that_is_not_there_is_a_wrong_call() {
    stylet(&["check", "nowhere.toml"]).refused(&["nowhere.toml"]);
    stylet(&["check"]).refused(&["FILE"]);
}

#[test]
fn each_kind_has_a_schema() {
    for kind in ["scene", "exercise", "curriculum"] {
        let schema = stylet(&["schema", kind]).ends(0).json();
        assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema", "{kind}");
        assert!(schema["properties"].is_object(), "{kind}");
    }
}
