//! The tables that `web-admin export` writes of the demonstration school, as pandas and polars read them. Fails when either cannot, when
//! the codebook has other columns, when somebody's name or address is in them, and when a table of before is overwritten.

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tests::{program, root, run_ok};

/// Of a data folder whose school has these accounts, as `demo` prints them.
pub(super) fn check(data: &Path, folder: &Path, accounts: &str) {
    let (data, out) = (data.to_string_lossy(), folder.join("tables"));
    let export = ["export", "--data-dir", &data, "--samples", "--out", &out.to_string_lossy()];
    let said = run_ok("web-admin", &export);
    let told = read_with_others(&out);
    assert!(said.contains(&format!("{} attempts", told["attempts"])), "{said}");
    assert_eq!(told["roles"], serde_json::json!(["instructor", "trainee"]), "guests are in their study alone");
    assert!(said.contains("attempts excluded"), "{said}");
    assert!(told["people"].as_u64().is_some_and(|people| people >= 10), "{told}");
    assert!(told["mean_score"].as_f64().is_some_and(|score| (20.0..100.0).contains(&score)), "{told}");
    assert!(told["mean_peak_force_n"].as_f64().is_some_and(|force| (1.0..20.0).contains(&force)), "{told}");
    assert!(told["longest_s"].as_f64().is_some_and(|time| (5.0..600.0).contains(&time)), "{told}");
    let text = told["text"].as_str().expect("the table of attempts");
    for line in accounts.lines().filter(|line| line.contains('@')) {
        let email = line.split_whitespace().find(|word| word.contains('@')).expect("an address");
        let family = line.split_whitespace().last().expect("a name");
        assert!(!text.contains(email) && !text.contains(family), "{line} is in the table");
    }
    let again = Command::new(program("web-admin")).args(export).output().expect("it runs");
    assert_eq!(again.status.code(), Some(2), "tables of before stay");
}

/// What check_tables.py says.
fn read_with_others(out: &Path) -> Value {
    let python = std::env::var("STYLET_TEST_PYTHON").unwrap_or_else(|_| "target/venv/bin/python".to_owned());
    let checked = Command::new(root().join(python))
        .arg("tests/python/check_tables.py")
        .arg(out)
        .current_dir(root())
        .output()
        .expect("python is missing: deploy/test makes its environment");
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
    serde_json::from_slice(&checked.stdout).expect("JSON")
}
