//! `stylet calibrate`: a curve gives back the scene that it was made from, with its residual and with what it does not tell;
//! what is no curve is refused on one line; the shipped epidural scene is what the command makes of its data.
//!
//! Would fail if units or columns were mixed up between file and law, if the residual were another scene's than the
//! one written, if an unsound or half-written scene were left behind, or if a mistake were passed over.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::{Run, repository, stylet, text};

const EPIDURAL: &str = "curricula/scenes/epidural-71kg.toml";
const EPIDURAL_CURVE: &str = "tests/data/calibrate/epidural-71kg.csv";

/// Thickness in m, stiffness in N/m, threshold in N, friction in N/m, cutting in N of the layers that curves are made from.
const LAYERS: [(&str, [f64; 5]); 3] = [
    ("skin", [0.003, 400.0, 2.0, 60.0, 0.3]),
    ("fat", [0.012, 300.0, 1.2, 15.0, 0.1]),
    ("muscle", [0.03, 600.0, 3.0, 40.0, 0.3]),
];

/// A folder with a curve in it, and where the scene goes.
struct Place {
    folder: TempDir,
}

impl Place {
    fn new(curve: &str) -> Self {
        let place = Self { folder: TempDir::new().expect("a folder") };
        fs::write(place.curve(), curve).expect("a curve");
        place
    }

    fn curve(&self) -> PathBuf {
        self.folder.path().join("curve.csv")
    }

    fn scene(&self) -> PathBuf {
        self.folder.path().join("made.toml")
    }

    fn calibrate(&self, more: &[&str]) -> Run {
        calibrate(&self.curve(), &self.scene(), more)
    }
}

fn calibrate(curve: &Path, scene: &Path, more: &[&str]) -> Run {
    stylet(&[&["calibrate", text(curve), "--out", text(scene)], more].concat())
}

/// The force law's answer to a needle that goes in to `deepest_mm` and back to `back_mm` in steps of 5 µm a second, a sample every
/// 0.05 mm: a measured needle does not move in steps from sample to sample.
fn law(deepest_mm: f64, back_mm: f64) -> Vec<(f64, f64)> {
    let folder = TempDir::new().expect("a folder");
    let (scene, track) = (folder.path().join("scene.json"), folder.path().join("track.csv"));
    let layers = LAYERS.map(|(name, [thickness, stiffness, threshold, friction, cutting])| {
        json!({ "name": name, "thickness_m": thickness, "stiffness_n_per_m": stiffness, "damping_n_s_per_m2": 0.0,
            "tip_rupture_n": threshold, "rim_rupture_n": 0.0, "friction_n_per_m": friction, "cutting_n": cutting })
    });
    let needle =
        json!({ "tip_to_rim_m": 0.0, "presliding_stiffness_n_per_m": 2000.0, "angle_rad": 0.0, "layers": layers });
    fs::write(&scene, needle.to_string()).expect("a scene");
    let steps = |mm: f64| (mm / 0.005).round() as u32;
    let depths = (0..steps(deepest_mm)).chain((steps(back_mm)..=steps(deepest_mm)).rev());
    let mut rows = String::from("t_s,x_m\n");
    depths.enumerate().for_each(|(t, x)| writeln!(rows, "{t},{}", f64::from(x) * 0.005e-3).expect("a row"));
    fs::write(&track, rows).expect("a track");
    let table = stylet(&["force", text(&scene), "--trajectory", text(&track)]).ends(0).stdout;
    let number = |row: &str, column: usize| row.split(',').nth(column).and_then(|n| n.parse().ok()).expect("a number");
    table.lines().skip(1).step_by(10).map(|row| (number(row, 1), number(row, 3))).collect()
}

fn csv(samples: &[(f64, f64)]) -> String {
    let rows = samples.iter().map(|(x, force)| format!("{x},{force}\n"));
    ["depth_m,force_n\n".to_owned()].into_iter().chain(rows).collect()
}

/// A fitted parameter and its interval.
fn parameter(report: &Value, layer: &str, name: &str) -> (f64, Option<[f64; 2]>) {
    let rows = report["parameters"].as_array().expect("parameters");
    let row = rows.iter().find(|row| row["layer"] == layer && row["parameter"] == name).expect("a parameter");
    let end = |at: usize| row["interval_95"][at].as_f64();
    (row["value"].as_f64().expect("a value"), end(0).zip(end(1)).map(|(low, high)| [low, high]))
}

fn undetermined(report: &Value) -> Vec<&str> {
    report["undetermined"].as_array().expect("a list").iter().filter_map(Value::as_str).collect()
}

#[test]
fn a_curve_gives_back_the_scene_it_was_made_from() {
    let place = Place::new(&csv(&law(32.0, 2.0)));
    let run = place.calibrate(&["--json"]).ends(0);
    assert_eq!(run.stderr, "");
    let report = run.json();
    assert!(report["residual_relative_to_peak"].as_f64().is_some_and(|part| part < 1e-3), "{report}");
    let value = |layer: &str, name: &str| parameter(&report, layer, name).0;
    for (at, (_, [thickness_m, stiffness, threshold, friction, cutting])) in LAYERS.into_iter().enumerate() {
        let layer = format!("layer {}", at + 1);
        let near = |name: &str, truth: f64, by: f64| {
            let found = value(&layer, name);
            assert!((found - truth).abs() <= by, "{name} of {layer}: {found}, not {truth} ± {by}");
        };
        near("stiffness", stiffness, 0.01 * stiffness);
        // Where in a gap of 0.05 mm a boundary gives way, no sample tells.
        near("tip threshold", threshold, 25e-6 * stiffness + 0.02);
        near("friction", friction, 2.0);
        near("cutting", cutting, 0.03);
        if at < 2 {
            near("thickness", thickness_m * 1e3, 0.1);
        }
    }
    stylet(&["check", text(&place.scene())]).ends(0);
}

#[test]
fn calibration_reports_residual_peaks_and_undetermined_values() {
    let place = Place::new(&csv(&law(32.0, 2.0)));
    let said = place.calibrate(&[]).ends(0).stdout;
    for words in [
        "made.toml",
        "residual",
        "N rms",
        "% of the peak",
        "tip into layer 2",
        "the curve cannot determine:",
        "thickness of layer 3: the curve does not depend on the far side",
        "damping of every layer",
    ] {
        assert!(said.contains(words), "'{words}' is missing in: {said}");
    }
    let scene = fs::read_to_string(place.scene()).expect("a scene");
    assert!(scene.contains("fitted by stylet calibrate to curve.csv, rms residual 0.0"), "{scene}");
}

#[test]
fn the_residual_is_that_of_the_scene_as_written() {
    let noisy: Vec<_> = law(32.0, 2.0).into_iter().zip(0_u32..).map(|((x, f), n)| (x, f + ripple(n))).collect();
    let place = Place::new(&csv(&noisy));
    let report = place.calibrate(&["--json"]).ends(0).json();
    // The ripple alone, 0.02 N · sin, has an rms of 0.0141 N.
    let residual_n = report["residual_rms_n"].as_f64().expect("a residual");
    assert!((0.013..0.016).contains(&residual_n), "{residual_n} N");
    let start = place.folder.path().join("again.toml");
    let again = calibrate(&place.curve(), &start, &["--start", text(&place.scene()), "--json"]).ends(0).json();
    let second_n = again["residual_rms_n"].as_f64().expect("a residual");
    assert!(second_n <= residual_n, "{second_n} N after a start at {residual_n} N");
}

/// White to the fit, the same in every run: the number hashed (the finalizer of MurmurHash3).
fn ripple(n: u32) -> f64 {
    let mixed = (n ^ (n >> 16)).wrapping_add(1).wrapping_mul(0x85eb_ca6b);
    let mixed = (mixed ^ (mixed >> 13)).wrapping_mul(0xc2b2_ae35);
    0.02 * libm::sin(f64::from(mixed ^ (mixed >> 16)) / f64::from(u32::MAX) * std::f64::consts::TAU)
}

#[test]
fn what_a_curve_without_withdrawal_does_not_tell_is_named() {
    // One millimetre of muscle at four samples under a ripple: too little to see friction grow.
    let coarse = |back_mm: f64| -> Vec<(f64, f64)> {
        let samples = law(21.0, back_mm).into_iter().step_by(5).zip(0_u32..);
        samples.map(|((x, f), n)| (x, f + 3.0 * ripple(n))).collect()
    };
    let report =
        |back_mm: f64| Place::new(&csv(&coarse(back_mm))).calibrate(&["--layers", "3", "--json"]).ends(0).json();
    let hides = |report: &Value| undetermined(report).iter().any(|words| words.contains("the curve has no withdrawal"));
    let (one_way, both_ways) = (report(21.0), report(2.0));
    assert!(hides(&one_way), "{:?}", undetermined(&one_way));
    assert_eq!(parameter(&one_way, "layer 3", "friction").1, None);
    assert!(!hides(&both_ways), "{:?}", undetermined(&both_ways));
    let (friction, ends) = parameter(&both_ways, "layer 3", "friction");
    assert!(
        ends.is_some_and(|[low, high]| (low..=high).contains(&40.0)),
        "{friction}, {ends:?}: {}, {:?}",
        both_ways["misfit"],
        undetermined(&both_ways)
    );
}

#[test]
fn a_start_keeps_its_words_and_what_lies_beyond_the_curve() {
    let shipped = fs::read_to_string(repository(EPIDURAL)).expect("the scene");
    let started = shipped.replacen("stiffness_n_per_m = 1212.0", "stiffness_n_per_m = 1180.0", 1);
    assert_ne!(started, shipped);
    let place = Place::new(&fs::read_to_string(repository(EPIDURAL_CURVE)).expect("the curve"));
    let start = place.folder.path().join("start.toml");
    fs::write(&start, started).expect("a start");
    place.calibrate(&["--start", text(&start), "--weight-kg", "90"]).ends(0);
    let made = fs::read_to_string(place.scene()).expect("a scene");
    let comments =
        |text: &str| text.lines().filter(|line| line.starts_with('#')).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(comments(&made), comments(&shipped));
    let table = |text: &str, name: &str| text.split("[[").find(|t| t.contains(name)).expect("a table").to_owned();
    assert!(table(&made, "\"dura\"").contains("density_kg_per_m3 = 1130"));
    // (90/71.1)^1.5 = 1.4242: resistance is lost 48.38 mm deep in the curve's patient.
    let checked = stylet(&["check", text(&place.scene())]).ends(0).stdout;
    let loss = checked.lines().find(|line| line.contains("tip into epidural space")).expect("resistance is lost");
    let depth_mm: f64 = loss.split_whitespace().nth(4).and_then(|word| word.parse().ok()).expect("a depth");
    assert!((depth_mm - 48.38 * 1.4242).abs() < 0.1, "{depth_mm} mm");
}

#[test]
fn a_start_that_is_made_of_a_body_has_no_layers_to_fit() {
    let place = Place::new("");
    let body = repository("curricula/scenes/epidural-midline.toml");
    let run = calibrate(&repository(EPIDURAL_CURVE), &place.scene(), &["--start", text(&body)]).ends(2);
    assert!(
        run.stderr.contains("anatomy: a body; allowed here: [[layer]], the layers made from the body"),
        "{}",
        run.stderr
    );
}

#[test]
fn the_shipped_scene_is_a_start_from_which_its_profile_is_met() {
    let place = Place::new("");
    let args = ["--start", text(&repository(EPIDURAL)), "--json"].map(str::to_owned);
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let run = calibrate(&repository(EPIDURAL_CURVE), &place.scene(), &args).ends(0);
    let report = run.json();
    let percent = 100.0 * report["residual_relative_to_peak"].as_f64().expect("a part");
    // The profile bends where the law opens a boundary.
    assert!(percent < 5.0, "{percent} % of the peak");
    let peaks = report["peaks"].as_array().expect("peaks");
    let measured = peaks.iter().filter(|peak| !peak["measured_depth_mm"].is_null());
    assert_eq!(measured.clone().count(), 2, "{peaks:?}");
    for peak in measured {
        assert!(peak["depth_error_mm"].as_f64().is_some_and(|mm| mm.abs() <= 1.0), "{peak}");
        assert!(peak["force_error_relative"].as_f64().is_some_and(|part| part.abs() <= 0.15), "{peak}");
    }
}

#[test]
fn every_clear_drop_is_a_layer_without_being_asked_for() {
    let place = Place::new(&fs::read_to_string(repository(EPIDURAL_CURVE)).expect("the curve"));
    let run = place.calibrate(&["--json"]).ends(0);
    // The force falls behind the skin, at the supraspinous ligament and where resistance is lost; the second fall is slow, and no layer.
    let report = run.json();
    let peaks = report["peaks"].as_array().expect("peaks");
    let measured: Vec<f64> = peaks.iter().filter_map(|peak| peak["measured_depth_mm"].as_f64()).collect();
    assert_eq!(measured.len(), 2, "{peaks:?}");
    assert!((measured[0] - 16.9).abs() < 0.2 && (measured[1] - 48.38).abs() < 0.1, "{measured:?}");
    assert_eq!(report["unexplained_drops"].as_array().map(Vec::len), Some(1), "{}", run.stderr);
}

#[test]
fn what_is_no_curve_is_refused_with_its_place() {
    let refused = |curve: &str, parts: &[&str]| {
        let place = Place::new(curve);
        place.calibrate(&[]).refused(parts);
        assert!(!place.scene().exists(), "a scene was left behind");
    };
    let good = csv(&law(32.0, 32.0));
    refused(&good.replacen("force_n", "force", 1), &["curve.csv:1:", "column force_n is missing", "depth_m,force"]);
    refused(
        &format!("# a note\n{}", good.replacen("depth_m", "mm", 1)),
        &["curve.csv:2:", "column depth_m is missing"],
    );
    refused(&good.replacen("\n0,", "\nNaN,", 1), &["curve.csv:2:", "depth_m = NaN m", "finite"]);
    refused("depth_m,force_n\n0,0\n0.001,inf\n", &["curve.csv:3:", "force_n = inf N", "finite"]);
    refused("depth_m,force_n\n0,0\n0.001,much\n", &["curve.csv:3:", "force_n = much N", "number"]);
    refused("# a\n\ndepth_m,force_n\n0,0\n# b\n# c\n0.001,much\n", &["curve.csv:7:", "force_n = much N"]);
    refused("# a\r\ndepth_m,force_n\r\n0,0\r\n# b\r\n0.001,much\r\n", &["curve.csv:5:", "force_n = much N"]);
    refused("depth_m,force_n\n# b\n0,0,0\n", &["curve.csv:3:", "3 fields; allowed: 2"]);
    refused("depth_m,force_n\n0,0\n0.9,1\n", &["curve.csv:3:", "depth_m = 0.9 m", "0.5 m", "mm?"]);
    refused("depth_m,force_n\n0,0\n0.01,900\n", &["curve.csv:3:", "force_n = 900 N", "200 N", "mN"]);
    refused("depth_m,force_n\n", &["curve.csv", "no rows"]);
    refused("depth_m,force_n\n0,0\n0.001,0.2\n0.002,0.4\n", &["curve.csv: samples that move: 3", "at least 12"]);
}

#[test]
fn decimal_commas_are_called_so() {
    let refused = |curve: &str, parts: &[&str]| Place::new(curve).calibrate(&[]).refused(parts);
    let points = "points in numbers (0.5, not 0,5)";
    refused("depth_m;force_n\n0,001;0,5\n", &["curve.csv:1: semicolons between columns", points]);
    refused("# measured\ndepth_m\tforce_n\n0.001\t0.5\n", &["curve.csv:2: tabs between columns", points]);
    refused("depth_m,force_n\n0,001,0,5\n", &["curve.csv:2: 4 fields; allowed: 2", "with a point, not a comma"]);
    refused(
        "depth_m,force_n\n\"0,001\",\"0,5\"\n",
        &["curve.csv:2: depth_m = 0,001 m", "a decimal point instead of a comma"],
    );
}

#[test]
fn a_curve_that_is_no_slow_insertion_is_refused_with_the_reason() {
    let refused = |samples: &[(f64, f64)], parts: &[&str]| Place::new(&csv(samples)).calibrate(&[]).refused(parts);
    let insertion = law(32.0, 32.0);
    let mut backwards = insertion.clone();
    backwards.reverse();
    refused(&backwards, &["curve.csv: samples deeper than all previous ones: 1", "at least 12"]);
    let held: Vec<_> = insertion.iter().map(|&(_, force_n)| (0.01, force_n)).collect();
    refused(&held, &["curve.csv: depth_m spans", "0.001 m"]);
    let pulled: Vec<_> = insertion.iter().map(|&(x, force_n)| (x, -force_n)).collect();
    refused(&pulled, &["curve.csv: force_n goes down to", "change the sign"]);
    let faint: Vec<_> = insertion.iter().map(|&(x, force_n)| (x, force_n * 1e-3)).collect();
    refused(&faint, &["curve.csv: force_n is at most", "0.02 N", "kN"]);
    let spring: Vec<_> = insertion.iter().map(|&(x, _)| (x, 300.0 * x)).collect();
    refused(&spring, &["curve.csv: drops of at least", "advances: 0; 1 are needed"]);
}

#[test]
fn timed_calibration_needs_law_3_and_errors_name_their_place() {
    let start = repository("curricula/scenes/liver-18g.toml");
    let started =
        |curve: &str, more: &[&str]| Place::new(curve).calibrate(&[&["--start", text(&start)], more].concat());
    started("t_s,depth_m,force_n\n0,0,0\n0.1,0.001,0.1\n0.1,0.002,0.2\n", &[]).refused(&[
        "curve.csv:4:",
        "t_s = 0.1 s",
        "0.1",
    ]);
    let timed: String = law(3.0, 3.0)
        .iter()
        .enumerate()
        .map(|(at, (depth_m, force_n))| format!("{},{depth_m:?},{force_n:?}\n", at as f64 * 0.02))
        .collect();
    let timed = format!("t_s,depth_m,force_n\n{timed}");
    started(&timed, &["--weight-kg", "80"]).refused(&["curve.csv: --weight-kg 80", "cannot be scaled"]);
    started(&csv(&law(3.0, 3.0)), &[]).refused(&["law 3", "t_s"]);
}

#[test]
fn a_call_that_cannot_be_followed_is_refused() {
    let place = Place::new(&csv(&law(32.0, 32.0)));
    place.calibrate(&["--layers", "9"]).refused(&["curve.csv: ", "9 are needed for layers: 9", "--start"]);
    place.calibrate(&["--layers", "0"]).refused(&["--layers", "0", "1..=32"]);
    place.calibrate(&["--tip-to-rim-mm", "-1"]).refused(&["--tip-to-rim-mm", "-1 mm", "0 mm to 50 mm"]);
    place.calibrate(&["--weight-kg", "7"]).refused(&["--weight-kg", "7 kg", "30 kg to 200 kg"]);
    place.calibrate(&["--start", "no-such.toml"]).refused(&["no-such.toml"]);
    stylet(&["calibrate", text(&place.curve())]).refused(&["--out"]);
    stylet(&["calibrate", "no-such.csv", "--out", text(&place.scene())]).refused(&["no-such.csv"]);
    let nowhere = place.folder.path().join("no-such-folder/made.toml");
    calibrate(&place.curve(), &nowhere, &[]).refused(&["no-such-folder", "cannot be created"]);
    assert!(!place.scene().exists(), "a scene was left behind");
}

#[test]
fn a_scene_that_exists_is_replaced_only_by_force() {
    let place = Place::new(&csv(&law(32.0, 32.0)));
    fs::write(place.scene(), "mine").expect("a file");
    place.calibrate(&[]).refused(&["made.toml", "exists already", "--force"]);
    assert_eq!(fs::read_to_string(place.scene()).expect("a file"), "mine");
    place.calibrate(&["--force"]).ends(0);
    assert!(fs::read_to_string(place.scene()).expect("a scene").contains("[[layer]]"));
}
