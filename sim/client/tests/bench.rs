//! `stylet bench`, shortened: every file it promises is there, and the figures that do not depend on the machine hold.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::{repository, stylet, text};

#[test]
fn ruptures_lag_one_tick_at_most_and_only_law_1_rattles() {
    let folder = TempDir::new().expect("a folder");
    let out = folder.path().join("new/folder");
    stylet(&["bench", "force", "--quick", "--out", text(&out)]).ends(0);
    check_encoder(&out);
    let table = fs::read_to_string(out.join("force-error.csv")).expect("a table");
    for row in table.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let number = |column: usize| cells[column].parse::<f64>().expect("a number");
        let (late_mm, one_tick_mm) = (number(2), number(3));
        assert!(late_mm <= one_tick_mm * (1.0 + 1e-9), "{row}");
        assert_eq!(cells[5], "0", "every rupture of the closed form comes: {row}");
    }
    let pictures = [
        "force-error.svg",
        "force-depth-lower-back-paper.svg",
        "force-depth-lower-back-training.svg",
        "force-encoder.svg",
    ];
    for picture in pictures {
        let svg = fs::read_to_string(out.join(picture)).expect("a picture");
        assert!(svg.contains("</svg>") && svg.contains(", N") | svg.contains(", mm"), "{picture} has units");
    }
    assert!(fs::read_to_string(out.join("force.md")).expect("a report").contains("ns per tick"));
}

/// An encoder's steps rattle under the first law, and not under the second.
fn check_encoder(out: &Path) {
    let table = fs::read_to_string(out.join("force-encoder.csv")).expect("a table");
    let rows: Vec<Vec<f64>> =
        table.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect();
    let ideal_n = rows[0][3];
    for row in &rows {
        let (law, step_um, share, mean_n, jumps) = (row[0], row[1], row[2], row[3], row[4]);
        if law > 1.0 {
            assert!(share > 0.999 && jumps <= 0.0 && (mean_n / ideal_n - 1.0).abs() < 0.02, "{row:?}");
        } else if step_um > 0.0 {
            assert!(share < 0.5 && jumps > 10.0, "{row:?}");
        }
    }
}

#[test]
fn fits_of_known_curves_are_judged() {
    let folder = TempDir::new().expect("a folder");
    stylet(&["bench", "calibrate", "--quick", "--out", text(folder.path())]).ends(0);
    let table = fs::read_to_string(folder.path().join("calibrate.csv")).expect("a table");
    assert!(table.lines().next().is_some_and(|head| head.ends_with(",holds")), "{table}");
    let held: Vec<&str> =
        table.lines().skip(1).filter_map(|row| row.rsplit(',').next()).filter(|cell| !cell.is_empty()).collect();
    let share = held.iter().filter(|cell| **cell == "true").count() as f64 / held.len() as f64;
    assert!(held.len() >= 8 && share > 0.7, "{share} of {} intervals hold the truth", held.len());
}

#[test]
fn recordings_are_measured() {
    let folder = TempDir::new().expect("a folder");
    stylet(&["bench", "recording", "--quick", "--out", text(folder.path())]).ends(0);
    let report = fs::read_to_string(folder.path().join("recording.md")).expect("a report");
    for figure in ["× real time", "MB", "µs", "% of a core", "read and score"] {
        assert!(report.contains(figure), "'{figure}' is missing in: {report}");
    }
    let left = fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(left, 3, "a table, a report and a picture, and no recording left behind");
}

#[test]
fn the_servo_is_measured_on_the_clock_and_says_its_priority() {
    let folder = TempDir::new().expect("a folder");
    stylet(&["bench", "servo", "--quick", "--out", text(folder.path())]).ends(0);
    let report = fs::read_to_string(folder.path().join("servo.md")).expect("a report");
    for figure in ["lateness, p99", "compute, p99.9", "stalls", "priority", "≤ 50"] {
        assert!(report.contains(figure), "'{figure}' is missing in: {report}");
    }
    let table = fs::read_to_string(folder.path().join("servo.csv")).expect("a table");
    let count = |what: &str| {
        let row = table.lines().find(|row| row.starts_with(what)).expect("a row");
        row.split(',').nth(1).and_then(|cell| cell.parse::<u64>().ok()).expect("a count")
    };
    assert!(count("ticks") >= 2000, "every reading became a tick: {table}");
    assert_eq!(count("records dropped"), 0, "the recorder kept up");
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 3, "no recording is left behind");
}

#[test]
fn the_picture_is_timed() {
    let folder = TempDir::new().expect("a folder");
    stylet(&["bench", "render", "--quick", "--out", text(folder.path())]).ends(0);
    let table = fs::read_to_string(folder.path().join("render.csv")).expect("a table");
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let rows: Vec<_> = rows.records().map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), 40, "eight views at five qualities: {table}");
    for row in rows {
        let number = |column: usize| row[column].parse::<f64>().expect("a number");
        assert!(number(2) > 0.0 && number(3) >= number(2), "{row:?}");
    }
    let report = fs::read_to_string(folder.path().join("render.md")).expect("a report");
    for part in ["Drawn by", "triangles", "shadows of 2048²", "![time of a frame](render.svg)"] {
        assert!(report.contains(part), "'{part}' is missing in: {report}");
    }
}

#[test]
fn hard_cases_stay_in_bounds_and_quick_report_states_its_scope() {
    let folder = TempDir::new().expect("a folder");
    let out = folder.path();
    stylet(&["bench", "hard-cases", "--quick", "--out", text(out)]).ends(0);
    let table = fs::read_to_string(out.join("hard-cases.csv")).expect("a table");
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    assert_eq!(
        rows.headers().expect("a header"),
        "case,model,trial,measures,bound,measured,unit,pass".split(',').collect::<Vec<_>>()
    );
    let mut count = 0;
    for row in rows.records() {
        let row = row.expect("a row");
        let number = |column: usize| row[column].parse::<f64>().expect("a number");
        assert!(number(5) <= number(4) && &row[7] == "yes", "{row:?}");
        count += 1;
    }
    assert!(count > 0, "no trial was run");
    let report = fs::read_to_string(out.join("hard-cases.md")).expect("a report");
    let said = [format!("Trials: {count}; failed: 0."), "Only the trials of the force law were run.".to_owned()];
    assert!(said.iter().all(|said| report.contains(said)), "{report}");
}

/// The planner's choices keep their tolerance on the reference cases.
fn check_choices(out: &Path) {
    let table = fs::read_to_string(out.join("field.csv")).expect("a table");
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let (mut chosen, mut models) = (0, std::collections::BTreeSet::new());
    for row in rows.records() {
        let row = row.expect("a row");
        models.insert(row[2].to_owned());
        // Springs have a floor of 3 to 36 % on these cases. Where the case's force was not applied to them, they stood at 2 400 %.
        let error: f64 = row[6].parse().expect("a number");
        assert!(&row[2] != "mass-spring" || error < 0.5, "{row:?}");
        if let Ok(tolerance) = row[3].parse::<f64>() {
            let number = |column: usize| row[column].parse::<f64>().expect("a number");
            let (error, estimate) = (number(6), number(7));
            assert!(error <= tolerance, "{row:?}");
            // The estimate covers the radial displacement, too, which this table does not list.
            assert!(error <= 3.0 * estimate && estimate <= tolerance, "the estimate bounds the error: {row:?}");
            chosen += 1;
        }
    }
    assert!(chosen >= 12 && models.len() == 3, "{table}");
    for picture in ["field-time-lower_back.svg", "field-convergence-lower_back.svg", "field-growth.svg"] {
        assert!(fs::read_to_string(out.join(picture)).expect("a picture").contains("</svg>"), "{picture}");
    }
    let report = fs::read_to_string(out.join("field.md")).expect("a report");
    for part in ["What the planner chooses", "An oblique needle", "Growth", "dolfinx", "tests/peers/run"] {
        assert!(report.contains(part), "'{part}' is missing");
    }
}

#[test]
fn the_field_carries_the_laws_force_to_a_hundredth() {
    let folder = TempDir::new().expect("a folder");
    stylet(&["bench", "coupling", "--out", text(folder.path())]).ends(0);
    let table = fs::read_to_string(folder.path().join("coupling.csv")).expect("a table");
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let rows: Vec<Vec<f64>> = rows
        .records()
        .map(|row| row.expect("a row").iter().map(|cell| cell.parse().expect("a number")).collect())
        .collect();
    let bar = rows.iter().find(|row| row[..3] == [10.0, 0.0, 120.0]).expect("10 mm/s at 120 Hz");
    assert!(bar[5] <= 0.01, "the bar of 1 % at 120 Hz: {bar:?}");
    assert!(bar[5] < bar[3], "a forecast is better than holding: {bar:?}");
    assert!(
        fs::read_to_string(folder.path().join("coupling.svg")).expect("a picture").contains("rate of the field, Hz")
    );
}

#[test]
fn a_soak_reports_every_shipped_scene() {
    let folder = TempDir::new().expect("a folder");
    stylet(&["bench", "soak", "--quick", "--out", text(folder.path())]).ends(0);
    let table = fs::read_to_string(folder.path().join("soak.csv")).expect("a table");
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let rows: Vec<_> = rows.records().map(|row| row.expect("a row")).collect();
    assert!(rows.len() >= 6, "{table}");
    for row in rows {
        let number = |column: usize| row[column].parse::<f64>().expect("a number");
        assert!(number(3) > 0.0, "something ruptured: {row:?}");
        assert!(number(8) > 1e-3, "the field follows: {row:?}");
        assert!(
            number(4) <= number(5) && number(6) <= 1e-3 && number(9) <= 1.0 + 1e-12 && &row[11] == "yes",
            "{row:?}"
        );
    }
    assert!(fs::read_to_string(folder.path().join("soak.md")).expect("a report").contains("lower-back-training"));
}

/// Exercises with an incised skin or an introducer, which does not give way: hands advance at their own speed.
const OPEN_SKINS: [&str; 3] = ["lumbar-puncture-pencil-point", "veress-needle", "primary-trocar"];

#[test]
fn operators_report_ranks_novice_intermediate_and_expert() {
    let folder = TempDir::new().expect("a folder");
    stylet(&["bench", "operators", "--quick", "--out", text(folder.path())]).ends(0);
    let table = fs::read_to_string(folder.path().join("operators.csv")).expect("a table");
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let head = reader.headers().expect("a head").clone();
    let column = |name: &str| head.iter().position(|cell| cell == name).expect("a column");
    let rows: Vec<_> = reader.records().map(|row| row.expect("a row")).collect();
    let number = |row: &csv::StringRecord, name: &str| row[column(name)].parse::<f64>().expect("a number");
    assert_eq!(rows.len(), 54, "{table}");
    let mut without_fault = 0.0;
    for presets in rows.chunks(3) {
        let over_mm = presets.iter().filter_map(|row| row[column("overshoot_of_the_skin_mm_median")].parse().ok());
        let over_mm: Vec<f64> = over_mm.collect();
        let in_order = OPEN_SKINS.contains(&&presets[0][0])
            || over_mm.len() == 3 && over_mm.windows(2).all(|pair| pair[0] > pair[1]);
        assert!(in_order, "novice, intermediate, expert: {presets:?}");
        assert!(presets.iter().all(|row| number(row, "furthest_mm") < number(row, "needle_mm")), "{presets:?}");
        if &presets[0][0] == "paper-insertion" {
            continue; // An experiment of one line, no exercise of a course.
        }
        let score: Vec<f64> = presets.iter().map(|row| number(row, "score_median")).collect();
        assert!(score[0] < score[1] && score[1] < score[2], "novice, intermediate, expert: {presets:?}");
        let (passed, perfect) = (number(&presets[2], "passed"), number(&presets[2], "perfect"));
        assert!(passed >= 4.0, "of five experts nearly all pass: {presets:?}");
        without_fault += perfect;
    }
    let experts = 5.0 * rows.len() as f64 / 3.0;
    assert!(without_fault < 0.6 * experts, "there is room above {without_fault} of {experts} experts");
    let report = fs::read_to_string(folder.path().join("operators.md")).expect("a report");
    assert!(report.contains("| stop-in-the-epidural-space | novice |"), "{report}");
}

#[test]
fn skins_that_bend_claim_no_less_than_they_are_off() {
    let folder = TempDir::new().expect("a folder");
    stylet(&["bench", "lumps", "--quick", "--out", text(folder.path())]).ends(0);
    let mut table = csv::Reader::from_path(folder.path().join("lumps.csv")).expect("a table");
    let rows: Vec<csv::StringRecord> = table.records().map(|row| row.expect("a row")).collect();
    let percent = |row: &csv::StringRecord, column: usize| -> f64 {
        row[column].trim_end_matches(" %").parse().expect("a number")
    };
    assert_eq!(rows.len(), 2, "{rows:?}");
    for row in &rows {
        assert!(percent(row, 2) <= percent(row, 3), "{row:?}");
    }
    assert_eq!((&rows[0][1], &rows[1][1]), ("axisymmetric", "volumetric"), "{rows:?}");
    assert!(percent(&rows[1], 4) > percent(&rows[1], 2), "flat layers are no better: {rows:?}");
}

#[test]
fn bodies_have_published_dimensions_and_free_needle_paths() {
    let folder = TempDir::new().expect("a folder");
    stylet(&["bench", "anatomy", "--quick", "--out", text(folder.path())]).ends(0);
    let mut table = csv::Reader::from_path(folder.path().join("anatomy.csv")).expect("a table");
    let rows: Vec<csv::StringRecord> = table.records().map(|row| row.expect("a row")).collect();
    let number = |row: &csv::StringRecord, column: usize| row[column].parse::<f64>().expect("a number");
    let of = |what: &str| rows.iter().filter(|row| &row[1] == what).collect::<Vec<_>>();
    assert_eq!(of("drawn").len(), 65, "{rows:?}");
    for row in of("drawn") {
        let [mean, sd, found, spread] = [3, 4, 7, 8].map(|column| number(row, column));
        assert!((found - mean).abs() < 0.2 * sd && (0.8..1.25).contains(&(spread / sd)), "{row:?}");
    }
    for row in of("surface") {
        let [mean, sd, found] = [3, 4, 7].map(|column| number(row, column));
        assert!((found - mean).abs() < 2.5 * sd, "two bodies lie within the spread: {row:?}");
    }
    for posture in ["prone", "sitting", "side"] {
        let paths: Vec<f64> = of(posture).iter().step_by(2).map(|row| number(row, 7)).collect();
        assert!(paths.len() == 5 && paths.iter().all(|share| (0.0..=1.0).contains(share)), "{posture}: {paths:?}");
    }
    let report = fs::read_to_string(folder.path().join("anatomy.md")).expect("a report");
    assert!(report.contains("| canal depth mm | 19.0 ± 2.0; "), "{report}");
}

/// What a row of the tissue's table tells whatever the machine: case, depth, model, tolerance, unknowns, error and estimate.
fn told_rows(path: &Path) -> Vec<csv::StringRecord> {
    let mut table = csv::Reader::from_path(path).expect("a table");
    let told = |row: csv::StringRecord| [0, 1, 2, 3, 4, 6, 7].iter().map(|&column| row[column].to_owned()).collect();
    table.records().map(|row| told(row.expect("a row"))).collect()
}

/// The relative L2 error of the axial displacement under the first load of a case, as `stylet field` answers it.
fn answered(case: &str, asked: &[&str]) -> f64 {
    let file = repository(&format!("tests/data/field/{case}.json"));
    let run = stylet(&[&["field", text(&file), "--json"], asked].concat());
    let reference: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&file).expect("the case")).expect("JSON");
    let answer = run.json();
    let axial = |of: &serde_json::Value| -> Vec<f64> {
        let depths = of["solutions"][0]["u_axial_m"].as_array().expect("depths");
        depths.iter().flat_map(|row| row.as_array().expect("samples")).filter_map(serde_json::Value::as_f64).collect()
    };
    let (found, wanted) = (axial(&answer), axial(&reference));
    assert!(!wanted.is_empty() && found.len() == wanted.len());
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|value| value * value).sum::<f64>().sqrt();
    let wrong = norm(&mut found.iter().zip(&wanted).map(|(found, wanted)| found - wanted));
    wrong / norm(&mut wanted.iter().copied())
}

/// The report in the tree is what the program of today computes, row by row.
fn check_committed_rows(out: &Path) {
    let measured = told_rows(&out.join("field.csv"));
    let committed = told_rows(&repository("sim/bench/reports/field.csv"));
    assert!(
        measured.len() >= 3 * (4 + 3 * 2),
        "every case with every tolerance and two meshes of each model: {measured:?}"
    );
    for row in measured {
        assert!(committed.contains(&row), "no longer computed so: {row:?}");
    }
}

/// What the report says of a model on a case is what whoever asks that model for that case is given.
#[test]
fn every_error_of_the_tissues_report_is_that_of_stylet_field() {
    let committed = told_rows(&repository("sim/bench/reports/field.csv"));
    let tolerances = ["0.05", "0.02", "0.01"].map(|tolerance| ["--tolerance", tolerance].to_vec());
    let models = ["mass-spring", "volumetric"].map(|model| ["--tolerance", "0.9", "--model", model].to_vec());
    for case in ["homogeneous", "lower_back", "stiff_skin_soft_fat"] {
        for asked in tolerances.iter().chain(&models) {
            let error = answered(case, asked);
            let is_asked = |row: &&csv::StringRecord| match asked.get(3) {
                Some(model) => &row[2] == *model && row[3].is_empty(),
                None => &row[3] == asked[1],
            };
            let rows = committed.iter().filter(|row| &row[0] == case && &row[1] == "0").filter(is_asked);
            let told: Vec<f64> = rows.map(|row| row[5].parse().expect("an error")).collect();
            assert!(
                told.iter().any(|told| (error / told - 1.0).abs() < 1e-9),
                "{case}, {asked:?}: {error}, not of {told:?}"
            );
        }
    }
}

#[test]
fn tissue_report_meets_tolerance_matches_commit_and_lists_peers() {
    let folder = TempDir::new().expect("a folder");
    let peers = folder.path().join("peers.csv");
    let head = "solver,version,model,dimensions,case,unknowns,relative_error,setup_s,solve_s,machine";
    let lines = ["77,0.31,0.5,0.002", "1077,0.0123,0.7,0.004"]
        .map(|figures| format!("someone-else,9.8.7,\"bricks, order 3\",3,lower_back,{figures},\"Another, 1 threads\""));
    fs::write(&peers, format!("{head}\n{}\n", lines.join("\n"))).expect("a file");
    let out = folder.path().join("out");
    let beside = ["bench", "field", "--quick", "--peers", text(&peers), "--out", text(&out)];
    stylet(&beside).ends(0);
    check_choices(&out);
    check_committed_rows(&out);
    let read = |name: &str| fs::read_to_string(out.join(name)).expect("a result");
    let report = read("field.md");
    for part in [
        "`stylet bench field --peers field-peers.csv --quick --out DIR`",
        "someone-else 9.8.7 on Another, 1 threads. **Not the machine of our figures.**",
        "| lower_back | someone-else, bricks, order 3 | 77 | 31.000 % | 500.00 ms | 2.00 ms | – |",
        "| lower_back | someone-else, bricks, order 3 | 1077 | 1.230 % | 4.00 ms | ",
        "warp.fem",
    ] {
        assert!(report.contains(part), "'{part}' is missing in: {report}");
    }
    assert!(read("field-time-lower_back.svg").contains("someone-else"));
    assert!(!read("field-time-homogeneous.svg").contains("someone-else"));
    fs::write(&peers, format!("{head}\n{}\n", lines[0].replace("0.31", "inf"))).expect("a file");
    stylet(&beside).refused(&["peers.csv:2", "relative_error: inf", "at most 10"]);
    stylet(&["bench", "soak", "--peers", text(&peers), "--out", text(&out)])
        .refused(&["--peers", "only `field` and `all`"]);
}

/// The report in the tree is what the program of today measures: its first rows, to the last digit.
#[test]
fn estimates_report_matches_the_committed_measurement() {
    let folder = TempDir::new().expect("a folder");
    stylet(&["bench", "estimates", "--quick", "--out", text(folder.path())]).ends(0);
    let measured = fs::read_to_string(folder.path().join("estimates.csv")).expect("a table");
    let committed = fs::read_to_string(repository("sim/bench/reports/estimates.csv")).expect("a table");
    assert_eq!(measured.lines().count(), 11);
    assert_eq!(committed.lines().count(), 1001);
    assert!(committed.starts_with(&measured), "{measured}");
    assert!(fs::read_to_string(folder.path().join("estimates.md")).expect("a report").contains("met by word alone"));
}

#[test]
fn a_hiccup_is_followed_by_force_and_a_lost_device_by_none() {
    let folder = TempDir::new().expect("a folder");
    stylet(&["bench", "hiccup", "--quick", "--out", text(folder.path())]).ends(0);
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).expect("a result");
    let rows = |name: &str| -> Vec<Vec<f64>> {
        let cells = |line: &str| line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        read(name).lines().skip(1).map(cells).collect()
    };
    let hiccup = rows("hiccup-hiccup.csv");
    let part = |tick: usize| hiccup[tick][3] / hiccup[tick][2];
    assert!(part(2990) > 0.95 && hiccup[3150][3] == 0.0, "felt before, gone after 120 ms");
    assert!((0.2..0.9).contains(&part(4000)) && part(5000) > 0.95, "it comes back: {} and {}", part(4000), part(5000));
    assert_eq!(rows("hiccup-lost.csv").len(), 4000, "a lost device ends the attempt");
    assert!(read("hiccup.md").contains("void") && read("hiccup-hiccup.svg").contains("given to the hand"));
}

#[test]
fn catalogue_offers_only_metrics_that_the_report_supports() {
    let folder = TempDir::new().expect("a folder");
    stylet(&["bench", "metrics", "--quick", "--out", text(folder.path())]).ends(0);
    let read = |path: &Path| -> Vec<csv::StringRecord> {
        let mut table = csv::Reader::from_path(path).expect("a table");
        table.records().map(|row| row.expect("a row")).collect()
    };
    let known: Vec<_> = assessment::catalogue::DEFINITIONS.iter().map(|d| (d.id.to_owned(), d.version)).collect();
    for rows in [read(&folder.path().join("metrics.csv")), read(&repository("sim/bench/reports/metrics.csv"))] {
        let measured: Vec<(String, u32)> =
            rows.iter().skip(1).map(|row| (row[0].to_owned(), row[1].parse().expect("a version"))).collect();
        assert_eq!(measured, known, "every version of every metric, after the score");
    }
    for row in read(&repository("sim/bench/reports/metrics.csv")).iter().skip(1) {
        let definition = assessment::catalogue::find_definition(&row[0], row[1].parse().expect("a version"));
        let definition = definition
            .or_else(|| assessment::catalogue::DEFINITIONS.iter().find(|d| d.id == &row[0]).filter(|d| !d.plain));
        let unoffered = definition.expect("of the catalogue").unoffered;
        let nothing_found = row[10].is_empty() || &row[10] == "by content";
        assert!(nothing_found || !unoffered.is_empty(), "{}, version {}: {}, and offered", &row[0], &row[1], &row[10]);
        assert_eq!(&row[11], if unoffered.is_empty() { "yes" } else { "no" }, "the report is of another catalogue");
    }
}
