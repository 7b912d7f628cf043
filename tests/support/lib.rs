//! What the system tests share: the project's own tree, its programs, and a service on a free port.

#![expect(clippy::panic, reason = "a test that cannot go on says why and stops")]

pub mod dice;
pub mod endings;
pub mod processes;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

pub use xtask::root;

/// The dependency graph of the default features on this platform.
///
/// # Panics
/// When `cargo metadata` refuses the workspace.
#[must_use]
pub fn metadata() -> cargo_metadata::Metadata {
    metadata_with("")
}

/// The dependency graph of the default features and of `features`, separated by commas, on this platform.
///
/// # Panics
/// When `cargo metadata` refuses the workspace.
#[must_use]
pub fn metadata_with(features: &str) -> cargo_metadata::Metadata {
    xtask::read_metadata(features).unwrap_or_else(|error| panic!("cargo metadata refuses the workspace: {error}"))
}

/// A program of the workspace, built beside this test.
///
/// # Panics
/// When it has not been built: `cargo test --workspace --no-run` comes first.
#[must_use]
pub fn program(name: &str) -> PathBuf {
    let test = std::env::current_exe().unwrap_or_default();
    let profile = test.parent().and_then(Path::parent).unwrap_or(Path::new("."));
    let path = profile.join(name);
    assert!(path.exists(), "{} is missing: run `cargo test --workspace --no-run` first", path.display());
    path
}

/// Runs a program of the workspace to its end.
///
/// # Panics
/// When it cannot be started.
#[must_use]
pub fn run(name: &str, arguments: &[&str]) -> Output {
    let output = Command::new(program(name)).args(arguments).current_dir(root()).output();
    output.unwrap_or_else(|error| panic!("{name} cannot be started: {error}"))
}

/// Runs a program that must succeed, and returns what it printed.
///
/// # Panics
/// When it fails; the message holds its standard error.
pub fn run_ok(name: &str, arguments: &[&str]) -> String {
    let output = run(name, arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{name} {arguments:?} failed: {stderr}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Runs a script of `tests/python`, or any with its whole path, with the packages of `tests/python/requirements.txt`.
///
/// # Panics
/// When it cannot be started.
#[must_use]
pub fn python(arguments: &[&str]) -> Output {
    let python = std::env::var("STYLET_TEST_PYTHON").unwrap_or_else(|_| "target/venv/bin/python".to_owned());
    let output = Command::new(root().join(python)).args(arguments).current_dir(root().join("tests/python")).output();
    output.unwrap_or_else(|error| panic!("python is missing: deploy/test makes its environment: {error}"))
}

/// Runs a script that must succeed, and returns what it printed.
///
/// # Panics
/// When it fails; the message holds all it said.
pub fn python_ok(arguments: &[&str]) -> String {
    let output = python(arguments);
    let [said, complained] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    assert!(output.status.success(), "{arguments:?}: {said}{complained}");
    said.into_owned()
}

/// A running `web-admin serve`, ended when dropped.
pub struct Service {
    child: Child,
    /// Address with scheme, for example `http://127.0.0.1:40123`.
    pub url: String,
}

impl Service {
    /// Serves a data folder on a free port and waits until it answers.
    ///
    /// # Panics
    /// When it does not start; its own words go to the test's standard error.
    #[must_use]
    pub fn start(data_dir: &Path) -> Self {
        Self::start_at(data_dir, "127.0.0.1:0")
    }

    /// Ends, and returns where it listened.
    #[must_use]
    pub fn stop(self) -> String {
        self.url.trim_start_matches("http://").trim_end_matches('/').to_owned()
    }

    /// Serves a data folder at an address and waits until it answers.
    ///
    /// # Panics
    /// When it does not start; its own words go to the test's standard error.
    #[must_use]
    pub fn start_at(data_dir: &Path, address: &str) -> Self {
        Self::start_with(data_dir, &["--listen", address])
    }

    /// Serves a data folder as it is told and waits until it answers.
    ///
    /// # Panics
    /// When it does not start; its own words go to the test's standard error.
    #[must_use]
    pub fn start_with(data_dir: &Path, arguments: &[&str]) -> Self {
        let mut child = Command::new(program("web-admin"))
            .arg("serve")
            .args(arguments)
            .arg("--data-dir")
            .arg(data_dir)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("web-admin cannot be started: {error}"));
        let stdout = child.stdout.take().map(BufReader::new);
        let mut lines = stdout.into_iter().flat_map(BufRead::lines).map_while(Result::ok);
        let url = lines.find_map(|line| line.find("http://").map(|at| line[at..].trim().to_owned()));
        Self { child, url: url.unwrap_or_else(|| panic!("web-admin printed no address")) }
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        // A service that has ended by itself leaves nothing to kill.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Every shipped document, relative to the root, in a stable order.
#[must_use]
pub fn documents() -> Vec<String> {
    let mut found = Vec::new();
    let mut open = vec![PathBuf::from("curricula")];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(root().join(&folder)).into_iter().flatten().flatten() {
            let path = folder.join(entry.file_name());
            if entry.path().is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "toml") {
                found.push(path.to_string_lossy().into_owned());
            }
        }
    }
    found.sort();
    found
}

/// Every page of the tree that people read, relative to the root, in a stable order.
///
/// # Panics
/// When a folder cannot be read.
#[must_use]
pub fn pages() -> Vec<String> {
    let mut found = Vec::new();
    let mut open = vec![root()];
    while let Some(folder) = open.pop() {
        let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        for entry in entries.flatten() {
            let (path, name) = (entry.path(), entry.file_name());
            let is_ours = !name.to_string_lossy().starts_with(['.']) && name != "target" && name != "node_modules";
            if path.is_dir() && is_ours {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                found.extend(path.strip_prefix(root()).ok().map(|page| page.to_string_lossy().into_owned()));
            }
        }
    }
    found.sort();
    found
}

/// The first exercise of the first shipped course, relative to the root.
///
/// # Panics
/// When no exercise is shipped.
#[must_use]
pub fn first_exercise() -> String {
    let is_exercise = |path: &&String| !path.contains("/scenes/") && !path.ends_with("course.toml");
    documents().iter().find(is_exercise).cloned().unwrap_or_else(|| panic!("no exercise is shipped"))
}
