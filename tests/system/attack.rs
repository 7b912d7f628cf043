//! Attacks on a running service that measure no times: who reaches what, what counts as proved, what is planted in pages, letters and
//! tables. Fails when one of them gets through, or when its honest counterpart does not. `tests/attack/run` tries the others too.

use tests::{program, python_ok, root};

/// Runs every attack of some families, each of which must be refused, and at least so many of them.
fn refuses(families: &[&str], least: usize) {
    let script = root().join("tests/attack/main.py").to_string_lossy().into_owned();
    let binary = program("web-admin").to_string_lossy().into_owned();
    let _ = program("stylet");
    // Others compile and test beside it: whoever waits long is no attack.
    let asked = [script.as_str(), "--binary", &binary, "--slack", "30"];
    let said = python_ok(&[&asked[..], families].concat());
    let refused = said.lines().filter(|line| line.starts_with("refused ")).count();
    assert!(refused >= least, "only {refused} were refused: {said}");
}

#[test]
fn no_attack_on_who_sees_and_marks_what_gets_through() {
    refuses(&["belonging", "blinding", "names"], 18);
}

#[test]
fn no_attack_by_outsiders_or_on_what_is_proved_gets_through() {
    refuses(&["outsiders", "platforms", "proof"], 19);
}

#[test]
fn no_attack_on_signing_in_gets_through() {
    refuses(&["signing_in"], 12);
}
