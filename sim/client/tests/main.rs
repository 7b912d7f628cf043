//! The program as a user meets it: the real binary, its output, its exit status, and one-line errors.

#![expect(clippy::expect_used, reason = "a helper that cannot do its part has nobody to tell but the test")]

mod anatomy;
#[cfg(feature = "reports")]
mod bench;
mod calibrate;
mod call;
mod check;
mod doctor;
mod export;
mod field;
mod force;
mod outbox;
mod picture;
mod recordings;
mod stand_in;
mod upload;
mod validate;

use std::path::{Path, PathBuf};
use std::process::Command;

/// What a run of `stylet` came to.
struct Run {
    status: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Run {
    /// Asserts the exit status, showing standard error when it is another.
    #[track_caller]
    fn ends(self, status: i32) -> Self {
        assert_eq!(self.status, Some(status), "stdout: {}\nstderr: {}", self.stdout, self.stderr);
        self
    }

    /// Asserts that it is refused (exit 2) with exactly one line on standard error that holds every one of `parts`.
    #[track_caller]
    fn refused(self, parts: &[&str]) {
        let run = self.ends(2);
        assert_eq!(run.stderr.lines().count(), 1, "one line: {}", run.stderr);
        run.says(parts);
    }

    /// Asserts that standard error holds every one of `parts`, and nothing of a panic.
    #[track_caller]
    fn says(&self, parts: &[&str]) {
        for part in parts {
            assert!(self.stderr.contains(part), "'{part}' is missing in: {}", self.stderr);
        }
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
    }

    /// Standard output as JSON.
    #[track_caller]
    fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout).expect("JSON on standard output")
    }
}

/// The program, without the caller's token, outbox and pairing.
fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stylet"));
    let home = Path::new(env!("CARGO_TARGET_TMPDIR")).join("home");
    command.env_remove("STYLET_TOKEN").env_remove("STYLET_OUTBOX");
    command.env("XDG_CONFIG_HOME", home.join("config")).env("XDG_DATA_HOME", home.join("data"));
    command
}

/// Runs `stylet` with arguments.
fn stylet(args: &[&str]) -> Run {
    run(program().args(args))
}

/// Runs a prepared command.
fn run(command: &mut Command) -> Run {
    let output = command.output().expect("the program starts");
    Run {
        status: output.status.code(),
        stdout: String::from_utf8(output.stdout).expect("UTF-8 on standard output"),
        stderr: String::from_utf8(output.stderr).expect("UTF-8 on standard error"),
    }
}

/// A path in the repository.
fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

/// A path as an argument.
fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}
