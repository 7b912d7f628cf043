//! The Python package, as its wheel is installed: the same numbers as the commands to the bit, nothing but exceptions for what is wrong, types
//! that hold, and the notebooks. Fails when a number is computed twice in two ways, or an array or a file brings the interpreter down.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use tests::{program, root};

/// The package as deploy/wheel has unpacked it, beside the programs.
fn site() -> PathBuf {
    let stylet = program("stylet");
    let target = stylet.parent().and_then(Path::parent).expect("a folder of builds");
    let site = target.join("wheel/site");
    assert!(site.exists(), "{} is missing: run `deploy/wheel --for-tests` first", site.display());
    site
}

/// Runs Python with the package; what it printed.
fn run_python(folder: &Path, arguments: &[&str]) -> String {
    let python = std::env::var("STYLET_TEST_PYTHON").unwrap_or_else(|_| "target/venv/bin/python".to_owned());
    let output = Command::new(root().join(python))
        .args(arguments)
        .env("PYTHONPATH", site())
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("MPLCONFIGDIR", folder)
        .current_dir(folder)
        .output()
        .expect("python is missing: deploy/test makes its environment");
    let [said, complained] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    assert!(output.status.success(), "{arguments:?}: {said}{complained}");
    said.into_owned()
}

fn path(file: &str) -> String {
    root().join(file).to_string_lossy().into_owned()
}

#[test]
fn package_matches_commands_bit_for_bit_and_raises_on_bad_input() {
    let folder = tempfile::tempdir().expect("a folder");
    let (script, stylet) = (path("tests/python/check_package.py"), program("stylet"));
    let files = folder.path().join("files");
    std::fs::create_dir(&files).expect("a folder");
    let arguments = [script.as_str(), &stylet.to_string_lossy(), &files.to_string_lossy()];
    let said: Value = serde_json::from_str(&run_python(folder.path(), &arguments)).expect("JSON");
    let count = |what: &str| said[what].as_u64().expect("a count");
    assert!(count("compared") > 1_000_000, "only {} numbers were compared", count("compared"));
    assert!(count("refused") > 50 && count("spoiled") > 100, "{said}");
}

#[test]
fn what_the_package_says_of_its_types_is_so() {
    let folder = tempfile::tempdir().expect("a folder");
    run_python(folder.path(), &["-m", "mypy", "--strict", "--package", "stylet"]);
    run_python(folder.path(), &["-m", "mypy.stubtest", "stylet"]);
}

#[test]
fn notebooks_run_and_draw() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |name: &str| {
        let said = run_python(folder.path(), &[&path(&format!("docs/notebooks/{name}.py"))]);
        let picture = folder.path().join(format!("{name}.png"));
        let size = bytes_of_picture(&picture);
        assert!(size > 20_000, "{name}.png has {size} bytes");
        said
    };
    let figure = run("paper_figure_7");
    assert!(figure.ends_with("6 pops\n"), "{figure}");
    let groups = run("known_groups");
    // An area of 0.5 is chance; the second number is the lower end of the interval.
    let number = |metric: &str, column: usize| -> f64 {
        let row = groups.lines().find(|line| line.split_whitespace().next() == Some(metric));
        row.and_then(|row| row.split_whitespace().nth(column)).and_then(|number| number.parse().ok()).expect("a number")
    };
    for (metric, least) in [("overshoot_mm", 0.7), ("depth_error_mm", 0.6)] {
        assert!(number(metric, 1) > least && number(metric, 2) > 0.5, "{metric}: {groups}");
    }
}

fn bytes_of_picture(picture: &Path) -> u64 {
    let begins = std::fs::read(picture).expect("a picture");
    assert!(begins.starts_with(b"\x89PNG"), "{} is no PNG", picture.display());
    begins.len() as u64
}
