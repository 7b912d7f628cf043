//! Attacks on a running service that measure no times: who reaches what, what counts as proved, what is planted in pages, letters and
//! tables. Fails when one of them gets through, or when its honest counterpart does not. `tests/attack/run` tries the others too.

use tests::{program, python_ok, root};

/// Those that need no quiet machine.
const FAMILIES: [&str; 6] = ["belonging", "blinding", "names", "outsiders", "proof", "signing_in"];

#[test]
fn no_attack_gets_through() {
    let script = root().join("tests/attack/main.py").to_string_lossy().into_owned();
    let binary = program("web-admin").to_string_lossy().into_owned();
    let _ = program("stylet");
    // Others compile and test beside it: whoever waits long is no attack.
    let asked = [script.as_str(), "--binary", &binary, "--slack", "30"];
    let said = python_ok(&[&asked[..], &FAMILIES].concat());
    let refused = said.lines().filter(|line| line.starts_with("refused ")).count();
    assert!(refused >= 40, "only {refused} were refused: {said}");
}
