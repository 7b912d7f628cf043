//! Sets `STYLET_GIT_REVISION` for the program and the Python package, which store it in their
//! recordings: the commit that is checked out, with `-dirty` appended if the simulator's sources
//! differ from it. An environment variable of the same name overrides it; without git it is empty.

use std::path::Path;
use std::process::Command;

/// The simulator's sources, relative to this crate.
const SOURCES: [&str; 2] = ["../../sim", "../../Cargo.lock"];

fn main() {
    println!("cargo:rerun-if-env-changed=STYLET_GIT_REVISION");
    SOURCES.iter().for_each(|path| println!("cargo:rerun-if-changed={path}"));
    let given = std::env::var("STYLET_GIT_REVISION").ok().filter(|revision| !revision.is_empty());
    println!("cargo:rustc-env=STYLET_GIT_REVISION={}", given.or_else(checked_out).unwrap_or_default());
}

/// Returns the commit that git has checked out, if this folder belongs to that repository.
fn checked_out() -> Option<String> {
    // A release that was unpacked inside another repository does not have that repository's
    // revision.
    let here = std::env::var("CARGO_MANIFEST_DIR").ok()?;
    let here = Path::new(&here).canonicalize().ok()?;
    let own = Path::new(&git(&["rev-parse", "--show-toplevel"])?).join("sim").join(here.file_name()?);
    if own.canonicalize().ok()? != here {
        return None;
    }
    watch();
    let revision = git(&["rev-parse", "HEAD"])?;
    let changed = git(&[&["status", "--porcelain", "--untracked-files=no", "--"][..], &SOURCES].concat())?;
    Some(if changed.is_empty() { revision } else { revision + "-dirty" })
}

/// Reruns this script when another commit is checked out. Git deletes the branch's own file when it
/// packs refs and recreates it with the next commit, so every file that may change is watched if it
/// exists.
fn watch() {
    let branch = git(&["symbolic-ref", "-q", "HEAD"]);
    for name in ["HEAD", "logs/HEAD", "packed-refs"].into_iter().chain(branch.as_deref()) {
        let path = git(&["rev-parse", "--git-path", name]).filter(|path| Path::new(path).exists());
        path.iter().for_each(|path| println!("cargo:rerun-if-changed={path}"));
    }
}

/// Returns the trimmed output of a git command, or `None` if it fails.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
