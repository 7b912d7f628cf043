//! The life of a recording: simulated, verified, scored, cut and recovered. Would fail if the same seed gave other bits,
//! if a file were half-written or overwritten, or if damage went unnoticed or ended in a panic.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use recording::write::SceneDrawing;
use recording::{Recording, Sample, Writer};
use tempfile::TempDir;

use crate::{Run, program, repository, run, stylet, text};

const SESSION: &str = "01890a5d-ac96-774b-bcce-b302099a8057";
const START: &str = "2026-01-31T09:00:00Z";

fn exercise() -> PathBuf {
    repository("curricula/lower-back-basics/3-reach-the-muscle.toml")
}

/// Simulates into `out` as `operator`, with everything fixed that is not drawn from the seed.
fn simulate(out: &Path, operator: &str, more: &[&str]) -> Run {
    let exercise = exercise();
    let fixed = ["--session-id", SESSION, "--started-at", START, "--operator", operator, "--out", text(out)];
    run(program().arg("simulate").arg(exercise).args(fixed).args(more))
}

/// A folder with a short recording in it: a fast straight insertion.
pub fn recorded() -> (TempDir, PathBuf) {
    let folder = TempDir::new().expect("a folder");
    let file = folder.path().join("attempt.mcap");
    simulate(&file, "constant:20", &["--seed", "3"]).ends(0);
    (folder, file)
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_one_does_not() {
    let folder = TempDir::new().expect("a folder");
    let record = |name: &str, seed: &str| {
        let file = folder.path().join(name);
        simulate(&file, "expert", &["--seed", seed]).ends(0);
        fs::read(file).expect("a recording")
    };
    let first = record("a.mcap", "5");
    assert!(first == record("b.mcap", "5"), "twice the same call, twice the same bytes");
    assert!(first != record("c.mcap", "6"), "another seed, another patient and another hand");
}

/// The commit that is checked out; none where the tree is no repository.
fn checked_out() -> Option<String> {
    let output = std::process::Command::new("git").args(["-C", text(&repository("")), "rev-parse", "HEAD"]).output();
    let output = output.ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).expect("a hash").trim().to_owned())
}

#[test]
fn a_recording_names_the_commit_it_was_made_by() {
    let (_folder, file) = recorded();
    let git = Recording::read(File::open(&file).expect("a recording")).expect("it reads").session.git;
    let built_from = git.trim_end_matches("-dirty");
    // Whoever builds without git may say the commit, and need not.
    let expected = checked_out().or_else(|| std::env::var("STYLET_GIT_REVISION").ok()).unwrap_or_default();
    assert_eq!(built_from, expected, "{git}");
}

#[test]
fn what_was_simulated_verifies_to_the_bit() {
    for operator in ["novice", "constant:20"] {
        let folder = TempDir::new().expect("a folder");
        let file = folder.path().join("attempt.mcap");
        let summary = simulate(&file, operator, &["--json", "--trainee", "T-17"]).ends(0).json();
        assert_eq!(summary["session_id"], SESSION);
        let verification = stylet(&["verify", text(&file), "--json"]).ends(0).json();
        assert_eq!(verification["largest_deviation_n"], 0.0, "{operator}: {verification}");
        assert_eq!(verification["event_differences"], 0, "{operator}: {verification}");
        assert_eq!(verification["ticks"], summary["ticks"], "{operator}");
    }
}

#[test]
fn a_score_has_the_promised_shape_and_reasons() {
    let (_folder, file) = recorded();
    let score = stylet(&["score", text(&file), "--json"]).ends(0).json();
    let mut members: Vec<&str> = score.as_object().expect("an object").keys().map(String::as_str).collect();
    members.sort_unstable();
    assert_eq!(members, ["deductions", "hard_fails", "metrics", "passed", "rubric", "score", "simulator_version"]);
    let lost: f64 =
        score["deductions"].as_array().expect("a list").iter().map(|d| d["points"].as_f64().expect("points")).sum();
    let points = score["score"].as_f64().expect("a number");
    assert!((points + lost - 100.0).abs() < 1e-6, "what was lost explains the score: {points} and {lost}");
    let people = stylet(&["score", text(&file)]).ends(0);
    for part in ["Score ", "Points", "depth_error_mm", "not a clinical claim"] {
        assert!(people.stdout.contains(part), "'{part}' is missing in: {}", people.stdout);
    }
}

#[test]
fn another_exercise_may_judge() {
    let (_folder, file) = recorded();
    let other = repository("curricula/lower-back-basics/2-stop-in-the-fat.toml");
    let score = stylet(&["score", text(&file), "--exercise", text(&other), "--json"]).ends(0).json();
    assert_eq!(score["rubric"]["id"], "stop-in-the-fat");
    stylet(&["score", text(&file), "--exercise", "nowhere.toml"]).refused(&["nowhere.toml"]);
}

#[test]
fn a_recording_is_not_overwritten_unasked() {
    let (folder, file) = recorded();
    let before = fs::read(&file).expect("a recording");
    simulate(&file, "constant:30", &[]).refused(&["attempt.mcap", "exists already", "--force"]);
    assert!(fs::read(&file).expect("a recording") == before);
    simulate(&file, "constant:30", &["--force"]).ends(0);
    assert!(fs::read(&file).expect("a recording") != before);
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "nothing half-written is left");
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    simulate(Path::new("/nowhere/at/all.mcap"), "expert", &[]).refused(&["/nowhere/at/all.mcap", "cannot be created"]);
}

#[test]
fn a_motion_from_a_file_is_recorded_as_it_is() {
    let folder = TempDir::new().expect("a folder");
    let (motion, file) = (folder.path().join("motion.csv"), folder.path().join("attempt.mcap"));
    // Straight in by 20 mm within a second: the tip's path is along the planned axis, so nothing is off it.
    fs::write(&motion, "t_s,x_m\n5.0,-0.005\n6.0,0.015\n6.5,0.015\n").expect("a file");
    let summary = simulate(&file, text(&motion), &["--json"]).ends(0).json();
    assert_eq!(summary["ticks"], 1501);
    assert_eq!(summary["duration_s"], 1.5);
    stylet(&["verify", text(&file)]).ends(0);
    let score = stylet(&["score", text(&file), "--json"]).ends(0).json();
    let metric = |id: &str| {
        let metrics = score["metrics"].as_array().expect("a list");
        metrics.iter().find(|metric| metric["id"] == id).expect(id)["value"].as_f64().expect("a value")
    };
    assert!((metric("depth_error_mm") + 7.0).abs() < 1e-6, "15 mm instead of 22: {}", metric("depth_error_mm"));
    assert!(metric("entry_error_mm").abs() < 1e-9);
}

#[test]
fn bad_motion_files_are_refused_and_nothing_is_written() {
    let folder = TempDir::new().expect("a folder");
    let (motion, file) = (folder.path().join("motion.csv"), folder.path().join("attempt.mcap"));
    let refused = |csv: &str, parts: &[&str]| {
        fs::write(&motion, csv).expect("a file");
        simulate(&file, text(&motion), &[]).refused(parts);
        assert!(!file.exists());
    };
    refused("t_s,x_m\n0,0\n0,0\n", &["motion.csv:3:", "t_s = 0 s", "increase"]);
    refused("t_s,y_m\n0,0\n", &["motion.csv:1:", "x_m", "px_m"]);
    refused("t_s,px_m,py_m\n0,0,0\n", &["motion.csv:1:", "pz_m is missing"]);
    let orientation = "t_s,px_m,py_m,pz_m,qx,qy,qz,qw\n0,0,0,0,0,0,0,0\n";
    refused(orientation, &["motion.csv:2:", "length 0", "1 ± 0.001"]);
}

#[test]
fn a_cut_recording_is_used_and_made_whole() {
    let (folder, file) = recorded();
    let bytes = fs::read(&file).expect("a recording");
    let (cut, fixed) = (folder.path().join("cut.mcap"), folder.path().join("fixed.mcap"));
    for tenths in 1..10 {
        fs::write(&cut, &bytes[..bytes.len() * tenths / 10]).expect("a file");
        let run = stylet(&["score", text(&cut), "--json"]);
        run.says(&[]);
        assert!(matches!(run.status, Some(0 | 2)), "cut at {tenths} tenths: {:?}", run.status);
        let recovered = stylet(&["recover", text(&cut), "--out", text(&fixed), "--force", "--json"]);
        recovered.says(&[]);
        if recovered.status == Some(0) {
            assert_ne!(recovered.json()["damage"], "", "a cut is damage");
            assert!(stylet(&["score", text(&fixed), "--json"]).stderr.find("cut").is_none(), "the output is whole");
        }
    }
    stylet(&["recover", text(&file), "--out", text(&fixed)]).refused(&["fixed.mcap", "exists already"]);
}

#[test]
fn what_is_no_recording_is_refused() {
    let folder = TempDir::new().expect("a folder");
    let (file, fixed) = (folder.path().join("empty.mcap"), folder.path().join("fixed.mcap"));
    for bytes in [&b""[..], b"poem", &[0x89, b'M', b'C', b'A', b'P', 0x30, b'\r', b'\n']] {
        fs::write(&file, bytes).expect("a file");
        stylet(&["score", text(&file)]).refused(&["empty.mcap"]);
        stylet(&["verify", text(&file)]).refused(&["empty.mcap"]);
        stylet(&["recover", text(&file), "--out", text(&fixed)]).refused(&["empty.mcap"]);
        assert!(!fixed.exists());
    }
    stylet(&["score", "nowhere.mcap"]).refused(&["nowhere.mcap"]);
    stylet(&["verify", text(folder.path())]).refused(&["folder"]);
}

/// Writes a recording again after a change to one of its samples.
fn rewrite(from: &Path, to: &Path, change: impl Fn(&mut Sample)) {
    let mut recording = Recording::read(File::open(from).expect("a recording")).expect("a recording");
    let deepest = recording.samples.iter().position(|sample| sample.depth_m > 0.019).expect("a deep sample");
    change(&mut recording.samples[deepest]);
    let file = File::create(to).expect("a file");
    let drawing = SceneDrawing::default();
    let mut writer = Writer::create(file, &recording.session, &recording.attachments, &drawing).expect("a writer");
    let (mut events, mut energies) = (recording.events.iter().peekable(), recording.energies.iter().peekable());
    for sample in &recording.samples {
        writer.sample(sample).expect("written");
        while let Some(event) = events.next_if(|event| event.t_s <= sample.t_s) {
            writer.event(event).expect("written");
        }
        while let Some(energy) = energies.next_if(|energy| energy.t_s <= sample.t_s) {
            writer.energy(energy).expect("written");
        }
    }
    writer.finish().expect("finished");
}

#[test]
fn a_force_that_differs_in_its_last_bit_is_found_and_named() {
    let (folder, file) = recorded();
    let changed = folder.path().join("changed.mcap");
    rewrite(&file, &changed, |_| {});
    stylet(&["verify", text(&changed)]).ends(0);
    rewrite(&file, &changed, |sample| sample.friction_n = f32::from_bits(sample.friction_n.to_bits() + 1));
    let run = stylet(&["verify", text(&changed)]).ends(1);
    for part in ["different", "friction_n"] {
        assert!(run.stdout.contains(part), "'{part}' is missing in: {}", run.stdout);
    }
}

#[test]
fn a_changed_attachment_is_refused() {
    let (folder, file) = recorded();
    let changed = folder.path().join("changed.mcap");
    let mut bytes = fs::read(&file).expect("a recording");
    let stiffness = b"stiffness_n_per_m = 661";
    let at = bytes.windows(stiffness.len()).position(|window| window == stiffness).expect("the scene is attached");
    bytes[at + stiffness.len() - 1] = b'9';
    fs::write(&changed, bytes).expect("a file");
    stylet(&["verify", text(&changed)]).refused(&["changed.mcap"]);
}

/// A recording of before, which re-simulates to the bit.
fn kept_recording(name: &str) -> Recording {
    let file = repository("tests/data/recordings").join(name);
    let verification = stylet(&["verify", text(&file), "--json"]).ends(0).json();
    assert_eq!(verification["largest_deviation_n"], 0.0, "{verification}");
    assert_eq!(verification["largest_tent_deviation_m"], 0.0, "{verification}");
    assert_eq!(verification["event_differences"], 0, "{verification}");
    Recording::read(File::open(&file).expect("a recording")).expect("readable")
}

/// Recorded by the program of before there was a second version of the force law: its scene names none, and cuts.
#[test]
fn a_recording_of_the_first_law_re_simulates_by_the_first_law() {
    let old = kept_recording("force-law-1.mcap");
    let cutting = old.samples.iter().filter(|sample| sample.cutting_n > 0.0).count();
    assert!(cutting > 200, "it must cut, or the laws would not differ: {cutting} ticks");
}

/// Recorded by a program of before recordings said how their field was judged: an oblique attempt at 250 Hz that cuts.
#[test]
fn a_recording_of_before_fields_were_judged_anew_re_simulates() {
    let old = kept_recording("first-judging.mcap");
    assert!(
        old.samples.iter().any(|sample| sample.cutting_n > 0.0) && old.tents.len() > 500,
        "there is much to compare"
    );
}
