//! The SCIM endpoints before another project's compliance checks. Fails when one of them does.

use tests::{program, python_ok, root};

#[test]
fn another_projects_checks_of_scim_pass() {
    let script = root().join("tests/counterparts/scim.py").to_string_lossy().into_owned();
    let printed = python_ok(&[&script, &program("web-admin").to_string_lossy()]);
    assert!(printed.contains("checks passed"), "{printed}");
}
