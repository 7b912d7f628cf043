//! What is deployed is whole. Fails when the container copies what is not there or lacks what the service needs besides its
//! program, when notices do not travel, or when a debugger's part stays in the programs.

use std::fs;
use std::process::Command;

use tests::{program, root};

fn text(path: &str) -> String {
    fs::read_to_string(root().join(path)).expect(path)
}

#[test]
fn the_container_brings_courses_documents_and_notices() {
    let container = text("deploy/Containerfile");
    let copied: Vec<&str> = container
        .lines()
        .filter(|line| line.starts_with("COPY --from=build"))
        .flat_map(|line| line.split_whitespace().filter_map(|word| word.strip_prefix("/source/")))
        .collect();
    for wanted in ["curricula", "docs", "LICENSE-MIT", "LICENSE-APACHE", "THIRD-PARTY.txt", "target/release/web-admin"]
    {
        assert!(copied.contains(&wanted), "{wanted} is not copied: {copied:?}");
    }
    let made = |path: &str| path.starts_with("target/") || path == "THIRD-PARTY.txt";
    let ignored: Vec<String> = text(".containerignore").lines().map(str::to_owned).collect();
    for path in copied.iter().filter(|path| !made(path)) {
        assert!(root().join(path).exists(), "{path} is copied and not there");
        assert!(!ignored.iter().any(|line| line == path), "{path} is copied and ignored");
    }
    assert!(container.contains("target/release/xtask notices THIRD-PARTY.txt web-admin"));
}

#[test]
fn symbols_are_kept_apart_and_the_program_still_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let copy = folder.path().join("xtask");
    fs::copy(program("xtask"), &copy).expect("a copy");
    let before = fs::metadata(&copy).expect("a program").len();
    // Twice: what has been done is not done again, which would leave an empty file for the debugger.
    let script = "source deploy/lib.sh; symbols_apart \"$1\"; symbols_apart \"$1\"";
    let output = Command::new("bash")
        .args(["-euo", "pipefail", "-c", script, "bash"])
        .arg(&copy)
        .current_dir(root())
        .output()
        .expect("bash");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let after = fs::metadata(&copy).expect("a program").len();
    let apart = fs::metadata(copy.with_extension("debug")).expect("symbols").len();
    assert!(after < before - before / 4 && apart > before / 4, "{before} bytes became {after} and {apart}");
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 2, "nothing else is left");
    let refused = Command::new(&copy).output().expect("it still runs");
    assert_eq!(refused.status.code(), Some(2), "it prints its usage");
}
