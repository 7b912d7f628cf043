//! Our statistics against an independent package, on ratings that a generator made. Fails when a formula is right on the
//! published example only. Without pingouin it says so and shows nothing.

use std::io::Write;
use std::process::{Command, Stdio};

use assessment::statistics::{content_validity, cronbach_alpha, intraclass_correlation, scale_content_validity};
use serde_json::{Value, json};
use tests::root;

const NOT_INSTALLED: i32 = 77;

/// Ratings 1–4 of `objects` by `raters`, who agree more or less.
fn ratings(objects: u64, raters: u64, seed: u64) -> Vec<Vec<u8>> {
    let mut state = seed;
    let mut draw = |below: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    };
    let object = |truth: u64, draw: &mut dyn FnMut(u64) -> u64| -> Vec<u8> {
        (0..raters).map(|_| u8::try_from((truth + draw(3)).clamp(1, 4)).expect("small")).collect()
    };
    (0..objects)
        .map(|_| {
            let truth = draw(4);
            object(truth, &mut draw)
        })
        .collect()
}

/// What the package finds; none where it is not installed.
fn independent(rows: &[Vec<u8>]) -> Option<Value> {
    let python = std::env::var("STYLET_TEST_PYTHON").unwrap_or_else(|_| "target/venv/bin/python".to_owned());
    let mut child = Command::new(root().join(python))
        .arg("tests/python/compare_statistics.py")
        .current_dir(root())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("python is missing: deploy/test makes its environment");
    let input = json!({ "rows": rows }).to_string();
    // A script that skips may close its input before it is written.
    let _ = child.stdin.take().expect("an input").write_all(input.as_bytes());
    let output = child.wait_with_output().expect("it ends");
    if output.status.code() == Some(NOT_INSTALLED) {
        return None;
    }
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(serde_json::from_slice(&output.stdout).expect("JSON"))
}

fn same(what: &str, ours: f64, theirs: &Value) {
    let theirs = theirs.as_f64().unwrap_or(f64::NAN);
    // The package rounds what it tells.
    assert!((ours - theirs).abs() < 1e-4, "{what}: {ours} here, {theirs} there");
}

#[test]
fn alpha_icc_and_content_validity_agree_with_pingouin() {
    for (objects, raters, seed) in [(12, 4, 1), (24, 10, 2), (6, 3, 3), (60, 7, 4)] {
        let rows = ratings(objects, raters, seed);
        let Some(theirs) = independent(&rows) else {
            eprintln!("skipped: pingouin is not installed (pip install pingouin)");
            return;
        };
        let table: Vec<Vec<Option<f64>>> =
            rows.iter().map(|row| row.iter().map(|rating| Some(f64::from(*rating))).collect()).collect();
        let icc = intraclass_correlation(&table).expect("a full table");
        same("alpha", cronbach_alpha(&table).expect("a full table").alpha, &theirs["alpha"]);
        same("ICC(2,1)", icc.single_random, &theirs["icc_2_1"]);
        same("ICC(3,1)", icc.single_fixed, &theirs["icc_3_1"]);
        same("ICC(2,k)", icc.average_random.expect("raters who agree a little"), &theirs["icc_2_k"]);
        same("ICC(3,k)", icc.average_fixed, &theirs["icc_3_k"]);
        let item = |at: usize| rows.iter().map(|row| Some(row[at])).collect::<Vec<_>>();
        let items: Vec<_> = (0..rows[0].len()).map(item).collect();
        for (at, item) in items.iter().enumerate() {
            same("I-CVI", content_validity(item).expect("rated").value, &theirs["i_cvi"][at]);
        }
        same("S-CVI", scale_content_validity(&items).expect("rated").value, &theirs["s_cvi"]);
    }
}
