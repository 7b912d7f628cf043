//! The benchmark that others run, run on Stylet. Fails when Stylet leaves a tolerance, when the answers are not those that their script
//! makes, when a wrong answer scores as right, or when the folder leans on the rest of the project.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use tests::{program, python, python_ok, root};

fn folder() -> PathBuf {
    root().join("tests/benchmark")
}

fn script(name: &str) -> String {
    folder().join(name).display().to_string()
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The names of all cases.
fn names() -> Vec<String> {
    let cases: Value = serde_json::from_str(&read(&folder().join("cases.json"))).expect("JSON");
    let names = cases["cases"].as_array().expect("cases").iter();
    names.map(|case| case["name"].as_str().expect("a name").to_owned()).collect()
}

/// What the script says of a folder of results, and its exit status.
fn scored(results: &Path) -> (Value, Option<i32>) {
    let output = python(&[&script("score.py"), &results.display().to_string(), "--json"]);
    let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
    let told = serde_json::from_slice(&output.stdout).unwrap_or(Value::String(complaint));
    (told, output.status.code())
}

/// A folder with the answer of one case as its result, changed.
fn changed(case: &str, change: impl Fn(Vec<String>) -> Vec<String>) -> tempfile::TempDir {
    let results = tempfile::tempdir().expect("a folder");
    let file = format!("{case}.csv");
    let lines = read(&folder().join("answers").join(&file)).lines().map(str::to_owned).collect();
    std::fs::write(results.path().join(file), change(lines).join("\n")).expect("written");
    results
}

/// The state of the one case that was given, the reason for a refusal, and the exit status.
fn judged(case: &str, change: impl Fn(Vec<String>) -> Vec<String>) -> (String, String, Option<i32>) {
    let (told, status) = scored(changed(case, change).path());
    let one = told["cases"].as_array().and_then(|cases| cases.iter().find(|one| one["case"] == case));
    let text = |key: &str| one.and_then(|one| one[key].as_str()).unwrap_or_default().to_owned();
    (text("state"), text("reason"), status)
}

/// A field of a row as the change says; row 0 is the header.
fn with_field(mut lines: Vec<String>, row: usize, column: usize, change: impl Fn(&str) -> String) -> Vec<String> {
    let mut fields: Vec<String> = lines[row].split(',').map(str::to_owned).collect();
    fields[column] = change(&fields[column]);
    lines[row] = fields.join(",");
    lines
}

#[test]
fn stylet_meets_every_case() {
    let results = tempfile::tempdir().expect("a folder");
    let run = Command::new("bash").arg(script("run_stylet.sh")).arg(results.path()).arg(program("stylet")).output();
    let run = run.expect("bash");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let (told, status) = scored(results.path());
    assert_eq!((status, &told["counts"]["met"]), (Some(0), &names().len().into()), "{told:#}");
    for one in told["cases"].as_array().expect("cases") {
        assert!(one["seconds"].as_f64().is_some_and(|s| s > 0.0), "{one}");
        // Further in than a stranger has to be: half of a tolerance is a change that somebody should look at.
        for measure in one["measures"].as_array().expect("measures") {
            let [error, tolerance] = ["error", "tolerance"].map(|key| measure[key].as_f64().expect("a number"));
            assert!(error <= 0.5 * tolerance, "{one}");
        }
    }
}

#[test]
fn answers_are_those_that_their_script_makes() {
    let made = tempfile::tempdir().expect("a folder");
    python_ok(&[&script("make_answers.py"), &made.path().display().to_string()]);
    let (told, status) = scored(made.path());
    assert_eq!(status, Some(0), "{told:#}");
    let given: Vec<_> = std::fs::read_dir(made.path()).expect("a folder").flatten().collect();
    assert_eq!(told["counts"]["met"], given.len());
    assert!(given.len() > 12, "only {} answers are made", given.len());
    for measure in
        told["cases"].as_array().expect("cases").iter().flat_map(|one| one["measures"].as_array().expect("some"))
    {
        let error = measure["error"].as_f64().expect("a number");
        assert!(error <= 1e-8, "{measure}");
    }
}

#[test]
fn given_references_match_the_project_and_the_answer_script() {
    let check = "import csv, sys; sys.path.insert(0, sys.argv[1]); import make_answers as made
for name in ['table_i', 'trocar', 'training_in_hold_out_in', 'encoder_55um']:
    with open(f'{sys.argv[2]}/{name}.csv') as file: given = list(csv.DictReader(file))
    ours = list(made.force_rows(made.HERE / 'cases' / name))
    assert len(given) == len(ours), name
    for a, b in zip(given, ours):
        assert float(a['t_s']) == float(b[0]) and a['events'] == b[2] and abs(float(a['F_n']) - float(b[1])) < 1e-10, (name, a, b)";
    python_ok(&["-B", "-c", check, &folder().display().to_string(), &script("../data/force")]);
}

#[test]
fn wrong_answers_are_found() {
    let force = "trocar";
    let same = |lines: Vec<String>| lines;
    assert_eq!(judged(force, same), ("met".to_owned(), String::new(), Some(0)));
    let louder = |lines| with_field(lines, 900, 1, |n| format!("{}", n.parse::<f64>().expect("a number") + 0.01));
    assert_eq!(judged(force, louder), ("not met".to_owned(), String::new(), Some(1)));
    let silent = |lines: Vec<String>| lines.into_iter().map(|line| line.replace("rim:1", "")).collect();
    assert_eq!(judged(force, silent), ("not met".to_owned(), String::new(), Some(1)));
    let mirrored = |lines: Vec<String>| {
        (1..lines.len()).fold(lines, |lines, row| {
            with_field(lines, row, 3, |n| format!("{}", -n.parse::<f64>().expect("a number")))
        })
    };
    assert_eq!(judged("homogeneous", mirrored), ("not met".to_owned(), String::new(), Some(1)));
}

#[test]
fn what_cannot_be_scored_is_refused_with_the_place() {
    let refused = |case: &str, change: &dyn Fn(Vec<String>) -> Vec<String>, says: &str| {
        let (state, reason, status) = judged(case, change);
        assert_eq!((state.as_str(), status), ("refused", Some(1)), "{reason}");
        assert!(reason.contains(says), "{reason}");
    };
    refused("trocar", &|lines| with_field(lines, 7, 1, |_| "NaN".to_owned()), "row 7: F_n is NaN; it must be finite");
    refused("trocar", &|lines| with_field(lines, 7, 1, |_| "much".to_owned()), "row 7: F_n is 'much'");
    refused("trocar", &|lines| with_field(lines, 0, 1, |_| "force".to_owned()), "column F_n is missing");
    refused("trocar", &|lines| with_field(lines, 7, 0, |_| "9".to_owned()), "row 7: t_s is 9; the case has 0.06 there");
    refused("trocar", &|lines| with_field(lines, 7, 2, |_| "tip:0".to_owned()), "tip:0 opened in row 7 already");
    let short = |mut lines: Vec<String>| {
        lines.pop();
        lines
    };
    refused("trocar", &short, "2462 rows; the case has 2463 samples");
    let long = |mut lines: Vec<String>| {
        lines.extend(lines.last().cloned());
        lines
    };
    refused("lower_back", &long, "325 rows; the case has 324 samples");
    refused("lower_back", &|lines| with_field(lines, 3, 3, |n| format!("{n},{n}")), "row 3 has 6 fields");
    refused("lower_back", &|_| Vec::new(), "is empty");
}

#[test]
fn a_case_left_out_is_told_and_nothing_given_is_no_success() {
    let (told, status) = scored(changed("trocar", |lines| lines).path());
    assert_eq!(status, Some(0));
    assert_eq!(told["counts"]["not given"], names().len() - 1);
    let empty = tempfile::tempdir().expect("a folder");
    assert_eq!(scored(empty.path()).1, Some(1));
    std::fs::write(empty.path().join("trocart.csv"), "t_s,F_n,events\n").expect("written");
    let (told, status) = scored(empty.path());
    assert_eq!(status, Some(2));
    assert!(told.as_str().is_some_and(|said| said.contains("trocart: no case has this name")), "{told}");
}

#[test]
fn the_folder_is_whole_small_and_described() {
    let readme = read(&folder().join("README.md"));
    let mut bytes = 0;
    for name in names() {
        assert!(readme.contains(&format!("| `{name}` |")), "the README says nothing of {name}");
        for file in [format!("cases/{name}/case.json"), format!("answers/{name}.csv")] {
            bytes += folder().join(&file).metadata().unwrap_or_else(|error| panic!("{file}: {error}")).len();
        }
        bytes += folder().join(format!("cases/{name}/motion.csv")).metadata().map_or(0, |found| found.len());
    }
    assert!(bytes < 3_000_000, "{bytes} bytes");
    assert!(read(&root().join("CITATION.cff")).contains("tests/benchmark"), "CITATION.cff does not name the benchmark");
}
