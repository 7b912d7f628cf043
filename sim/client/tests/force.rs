//! `stylet force` against an independent implementation's tables, and its refusals. Would fail on any change of the
//! force law, of the columns or their order, of the events, or on numbers that lose bits when printed.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use tempfile::TempDir;

use crate::{Run, program, repository, stylet, text};

const COLUMNS: &str = "t_s,x_m,v_m_per_s,F_n,F_tip_n,F_rim_n,F_viscous_n,F_friction_n,F_cutting_n,depth_m,events";

fn reference(name: &str) -> PathBuf {
    repository("tests/data/force").join(name)
}

fn force(scene: &Path, trajectory: &Path) -> Run {
    stylet(&["force", text(scene), "--trajectory", text(trajectory)])
}

/// Runs the trocar's scene on a trajectory given as text.
fn trocar(trajectory: &str) -> (TempDir, Run) {
    let folder = TempDir::new().expect("a folder");
    let file = folder.path().join("t.csv");
    fs::write(&file, trajectory).expect("a file");
    let run = force(&reference("trocar.json"), &file);
    (folder, run)
}

/// Relative 1e-9, absolute 1e-12 near zero: the bar of the verification cases.
fn agrees(ours: f64, theirs: f64) -> bool {
    (ours - theirs).abs() <= 1e-12_f64.max(1e-9 * theirs.abs())
}

#[track_caller]
fn reproduces(case: &str) {
    let table = reference(&format!("{case}.csv"));
    let run = force(&reference(&format!("{case}.json")), &table).ends(0);
    let theirs = fs::read_to_string(table).expect("a reference");
    assert_eq!(run.stdout.lines().next(), Some(COLUMNS));
    assert_eq!(run.stdout.lines().count(), theirs.lines().count());
    for (line, (ours, theirs)) in run.stdout.lines().zip(theirs.lines()).enumerate().skip(1) {
        let (ours, theirs): (Vec<_>, Vec<_>) = (ours.split(',').collect(), theirs.split(',').collect());
        assert_eq!(ours.len(), 11, "line {line}");
        assert_eq!(ours[10], theirs[10], "events in line {line}");
        for (column, (ours, theirs)) in ours.iter().zip(&theirs).take(10).enumerate() {
            let (ours, theirs): (f64, f64) = (ours.parse().expect("a number"), theirs.parse().expect("a number"));
            assert!(agrees(ours, theirs), "line {line}, column {column}: {ours} instead of {theirs}");
        }
    }
}

#[test]
fn table_i_is_reproduced() {
    reproduces("table_i");
}

#[test]
fn the_trocar_is_reproduced() {
    reproduces("trocar");
}

#[test]
fn in_hold_out_in_is_reproduced() {
    reproduces("training_in_hold_out_in");
}

#[test]
fn inputs_read_back_to_the_same_bits() {
    let (_folder, run) = trocar("t_s,x_m\n0,0.1\n1e-7,0.30000000000000004\n0.1,-5e-324\n");
    let run = run.ends(0);
    let read: Vec<(f64, f64)> = run
        .stdout
        .lines()
        .skip(1)
        .map(|line| line.split(',').take(2).map(|n| n.parse().expect("a number")).collect::<Vec<f64>>())
        .map(|row| (row[0], row[1]))
        .collect();
    assert_eq!(read, [(0.0, 0.1), (1e-7, 0.300_000_000_000_000_04), (0.1, -5e-324)]);
}

#[test]
fn a_teleport_through_everything_is_one_cascade_in_order() {
    let (_folder, run) = trocar("note,x_m,t_s\nabove,-0.001,0\nthrough,0.05,0.001\n");
    let run = run.ends(0);
    let last = run.stdout.lines().last().expect("a row");
    assert!(last.ends_with(",tip:0+tip:1+tip:2+rim:0+rim:1+rim:2"), "{last}");
}

#[test]
fn bad_trajectories_are_refused_with_the_place() {
    // Lines are counted as an editor counts them, however they end.
    let refused = |csv: &str, parts: &[&str]| {
        for end in ["\n", "\r\n"] {
            trocar(&csv.replace('\n', end)).1.refused(parts);
        }
    };
    refused("t_s,x_m\n0,0\n0.01,NaN\n", &["t.csv:3:", "x_m = NaN m", "finite"]);
    refused("t_s,x_m\n0,0\n0.01,inf\n", &["t.csv:3:", "x_m = inf m", "finite"]);
    refused("t_s,x_m\n0,0\n0,0\n", &["t.csv:3:", "t_s = 0 s", "increase"]);
    refused("t_s,x_m\n0,0\n0.02,0\n0.01,0\n", &["t.csv:4:", "t_s = 0.01 s", "0.02 s"]);
    refused("t_s,x_m\n0,zero\n", &["t.csv:2:", "x_m = zero", "number"]);
    refused("t_s,x_m\n0,\n", &["t.csv:2:", "x_m", "number"]);
    refused("t_s,x_m\n0,15\n", &["t.csv:2:", "15 m", "mm?"]);
    refused("t_s,x_m\n0\n", &["t.csv:2:", "1 fields", "2"]);
    refused("t_s,x_mm\n0,1\n", &["t.csv:1:", "x_m is missing", "t_s,x_mm"]);
    refused("t_s,x_m,x_m\n0,1,2\n", &["t.csv:1:", "x_m appears twice"]);
    refused("# about\n\nt_s,x_m\n\n0,0\n# more\n\n0.01,NaN", &["t.csv:8:", "x_m = NaN m"]);
    refused("t_s,x_m\n0,0\n\n# more\n0\n", &["t.csv:5:", "1 fields"]);
    refused("t_s,x_m\n", &["t.csv", "no rows"]);
    refused("", &["t.csv", "no rows"]);
}

#[test]
fn bad_scenes_are_refused_with_the_place() {
    let folder = TempDir::new().expect("a folder");
    let scene = folder.path().join("scene.json");
    let good = fs::read_to_string(reference("trocar.json")).expect("a reference");
    let refused = |json: &str, parts: &[&str]| {
        fs::write(&scene, json).expect("a file");
        force(&scene, &reference("trocar.csv")).refused(parts);
    };
    refused(&good.replacen("0.0008", "-0.0008", 1), &["scene.json", "thickness_m", "-0.0008"]);
    refused(&good.replacen("\"thickness_m\"", "\"thickness_mm\"", 1), &["scene.json", "thickness_mm"]);
    refused("{", &["scene.json:1:"]);
    force(Path::new("nowhere.json"), &reference("trocar.csv")).refused(&["nowhere.json", "cannot be read"]);
    force(&reference("trocar.json"), Path::new("nowhere.csv")).refused(&["nowhere.csv", "No such file"]);
}

#[test]
fn an_unsound_scene_is_warned_of_and_computed() {
    let folder = TempDir::new().expect("a folder");
    let scene = folder.path().join("scene.json");
    let good = fs::read_to_string(reference("table_i.json")).expect("a reference");
    // Fat that holds to 2 N is tented 24 mm deep; when it gives way, muscle that holds to 12 N takes over with 7.8 N.
    let unsound = good.replace("\"tip_rupture_n\": 0.3", "\"tip_rupture_n\": 2.0");
    let unsound = unsound.replace("\"tip_rupture_n\": 1.5", "\"tip_rupture_n\": 12.0");
    fs::write(&scene, unsound).expect("a file");
    let run = force(&scene, &reference("table_i.csv")).ends(0);
    run.says(&["warning:", "unsound", "boundary 1", "fat", " N", " mJ", "largest sound threshold"]);
    assert_eq!(run.stdout.lines().next(), Some(COLUMNS));
}

#[test]
fn a_reader_that_leaves_early_is_no_failure() {
    let mut child = program()
        .args(["force", text(&reference("trocar.json")), "--trajectory", text(&reference("trocar.csv"))])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut first = [0; 3];
    let mut stdout = child.stdout.take().expect("a pipe");
    stdout.read_exact(&mut first).expect("a first line");
    drop(stdout);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!((output.status.code(), output.stderr), (Some(0), Vec::new()));
}
