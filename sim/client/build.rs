//! Tells the program, and the Python package, from which revision it is built, for the recordings it makes: the commit that is checked out, with `-dirty`
//! where the simulator's sources differ from it; nothing where there is no git, unless `STYLET_GIT_REVISION` says it.

use std::path::Path;
use std::process::Command;

/// What the simulator is made of, from here.
const SOURCES: [&str; 2] = ["../../sim", "../../Cargo.lock"];

fn main() {
    println!("cargo:rerun-if-env-changed=STYLET_GIT_REVISION");
    SOURCES.iter().for_each(|path| println!("cargo:rerun-if-changed={path}"));
    let given = std::env::var("STYLET_GIT_REVISION").ok().filter(|revision| !revision.is_empty());
    println!("cargo:rustc-env=STYLET_GIT_REVISION={}", given.or_else(checked_out).unwrap_or_default());
}

/// The revision that git has checked out here, if this folder is one of its own.
fn checked_out() -> Option<String> {
    // A release that was unpacked inside somebody else's repository is not of their revision.
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

/// Builds again when another commit is checked out. The branch's own file goes when git packs it, and comes back with the next
/// commit, so all the files that could tell are watched that are there.
fn watch() {
    let branch = git(&["symbolic-ref", "-q", "HEAD"]);
    for name in ["HEAD", "logs/HEAD", "packed-refs"].into_iter().chain(branch.as_deref()) {
        let path = git(&["rev-parse", "--git-path", name]).filter(|path| Path::new(path).exists());
        path.iter().for_each(|path| println!("cargo:rerun-if-changed={path}"));
    }
}

/// What git answers, where it answers.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
