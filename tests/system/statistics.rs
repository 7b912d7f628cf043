//! Our statistics against independent packages, on ratings and groups that a generator made. Fails when a formula is right on the
//! published example only.

use std::io::Write;
use std::process::{Command, Stdio};

use assessment::statistics::{
    area_under_curve, content_validity, cronbach_alpha, hedges_g, holm_adjusted, intraclass_correlation, item_analysis,
    mann_whitney, scale_content_validity,
};
use serde_json::{Value, json};
use tests::root;

/// Whole numbers below a limit, one after the other.
fn draws_from(seed: u64) -> impl FnMut(u64) -> u64 {
    let mut state = seed;
    move |below| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    }
}

/// Ratings 1–4 of `objects` by `raters`, who agree more or less.
fn ratings(objects: u64, raters: u64, seed: u64) -> Vec<Vec<u8>> {
    let mut draw = draws_from(seed);
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

/// What the packages find.
fn independent(input: &Value) -> Value {
    let python = std::env::var("STYLET_TEST_PYTHON").unwrap_or_else(|_| "target/venv/bin/python".to_owned());
    let mut child = Command::new(root().join(python))
        .arg("tests/python/compare_statistics.py")
        .current_dir(root())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("python is missing: deploy/test makes its environment");
    // A script that fails may close its input before it is written.
    let _ = child.stdin.take().expect("an input").write_all(input.to_string().as_bytes());
    let output = child.wait_with_output().expect("it ends");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// What pingouin rounds to three digits is as near as this.
const ROUNDED: f64 = 5.1e-4;

fn near(what: &str, ours: f64, theirs: &Value, apart: f64) {
    let theirs = theirs.as_f64().unwrap_or(f64::NAN);
    assert!((ours - theirs).abs() < apart, "{what}: {ours} here, {theirs} there");
}

fn same(what: &str, ours: f64, theirs: &Value) {
    near(what, ours, theirs, 1e-8);
}

#[test]
fn alpha_icc_and_content_validity_agree_with_pingouin() {
    for (objects, raters, seed) in [(12, 4, 1), (24, 10, 2), (6, 3, 3), (60, 7, 4)] {
        let rows = ratings(objects, raters, seed);
        let theirs = independent(&json!({ "rows": rows }));
        let table: Vec<Vec<Option<f64>>> =
            rows.iter().map(|row| row.iter().map(|rating| Some(f64::from(*rating))).collect()).collect();
        let icc = intraclass_correlation(&table).expect("a full table");
        let alpha = cronbach_alpha(&table).expect("a full table");
        same("alpha", alpha.alpha, &theirs["alpha"]);
        near("the interval of alpha", alpha.low, &theirs["alpha_low"], ROUNDED);
        near("the interval of alpha", alpha.high, &theirs["alpha_high"], ROUNDED);
        for (at, item) in item_analysis(&table).expect("a full table").iter().enumerate() {
            same("item–rest", item.rest_correlation.expect("variance"), &theirs["item_rest"][at]);
            same("alpha without", item.alpha_without.expect("items enough"), &theirs["alpha_without"][at]);
        }
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

/// Two groups of whole numbers, which have ties, or of numbers with thirty bits, which have none.
fn groups(sizes: [usize; 2], ties: bool, seed: u64) -> [Vec<f64>; 2] {
    let mut draw = draws_from(seed);
    let below = if ties { 7 } else { 1 << 30 };
    let mut values = |n: usize, shift: f64| (0..n).map(|_| draw(below) as f64 / below as f64 * 7.0 + shift).collect();
    [values(sizes[0], 0.0), values(sizes[1], if ties { 1.0 } else { 1.5 })]
}

#[test]
fn comparisons_of_groups_agree_with_scipy_and_pingouin() {
    let cases =
        [([4, 5], true), ([8, 8], true), ([5, 9], false), ([20, 18], false), ([30, 25], true), ([60, 41], false)];
    let mut probabilities = Vec::new();
    for (seed, (sizes, ties)) in (1..).zip(cases) {
        let [first, second] = groups(sizes, ties, seed);
        let theirs = independent(&json!({ "first": first, "second": second }));
        let test = mann_whitney(&first, &second).expect("two groups");
        assert_eq!(test.exact, sizes[0] + sizes[1] <= 40);
        same("U", test.u, &theirs["u"]);
        same("p", test.p, if test.exact { &theirs["p_dealt"] } else { &theirs["p_normal"] });
        let g = hedges_g(&first, &second).expect("two groups");
        same("g", g.value, &theirs["g"]);
        same("the interval of g", g.low, &theirs["g_low"]);
        same("the interval of g", g.high, &theirs["g_high"]);
        same("AUC", area_under_curve(&first, &second).expect("two groups").value, &theirs["cles"]);
        probabilities.push(test.p);
    }
    let theirs = independent(&json!({ "p": probabilities }));
    for (at, adjusted) in holm_adjusted(&probabilities).into_iter().enumerate() {
        same("Holm", adjusted, &theirs["holm"][at]);
    }
}
