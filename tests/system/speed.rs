//! How fast ten pages and three scenes are, each relative to a fixed computation of the same process, so that runs on different machines
//! compare. A run of it is appended to docs/speed.csv, and committed, by
//!
//! ```text
//! cargo test --release --workspace --test system speed -- --ignored
//! ```

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::hint::black_box;
use std::io;
use std::time::{Duration, Instant};

use assessment::staging::{AttemptMaker, Staging};
use attempt::HandChoice;
use documents::ExerciseBundle;
use model::Moment;
use nalgebra::DMatrix;
use tests::{Service, root, run_ok};

use crate::visitor::Visitor;

const FILE: &str = "docs/speed.csv";
const HEADER: &str = "run,figure,per_s,ratio";
const PASSWORD: &str = "a password for measurements";

/// Pages, each with the role and the address of its visitor.
const PAGES: [(&str, &str, &str); 10] = [
    ("trainee", "ada.okafor@demo.example", "/"),
    ("trainee", "ada.okafor@demo.example", "/assignments"),
    ("trainee", "ada.okafor@demo.example", "/curricula"),
    ("instructor", "miriam.osei@demo.example", "/"),
    ("instructor", "miriam.osei@demo.example", "/cohorts"),
    ("instructor", "miriam.osei@demo.example", "/review"),
    ("instructor", "miriam.osei@demo.example", "/assignments"),
    ("administrator", "ingrid.halvorsen@demo.example", "/"),
    ("administrator", "ingrid.halvorsen@demo.example", "/people"),
    ("administrator", "ingrid.halvorsen@demo.example", "/admin/audit"),
];

/// Exercises, whose attempts are simulated from the file to the recording.
const SCENES: [&str; 3] = [
    "lower-back-basics/3-reach-the-muscle",
    "lumbar-epidural-on-a-body/1-midline",
    "percutaneous-kidney-access/1-lower-pole",
];

/// Rounds of a figure, of which the median counts, and how long each lasts.
const ROUNDS: usize = 9;
const ROUND: Duration = Duration::from_millis(300);
/// A figure of the last run is at least so much of that of the run before it.
const LEAST: f64 = 0.9;

/// How much a second does: a repetition of `amount` returns its own share.
#[expect(clippy::disallowed_methods, reason = "it measures")]
fn rate(mut amount: impl FnMut() -> f64) -> f64 {
    let (begun, mut done) = (Instant::now(), 0.0);
    while begun.elapsed() < ROUND {
        done += amount();
    }
    done / begun.elapsed().as_secs_f64()
}

/// The fixed computation: factorises a matrix.
fn factorise() -> f64 {
    let matrix = DMatrix::from_fn(160, 160, |row, column| 1.0 / (1.0 + row.abs_diff(column) as f64));
    black_box(matrix.lu().determinant());
    1.0
}

/// The rate of `amount` per second and its ratio to the fixed computation's: the median of several rounds of both in turn.
fn measure(mut amount: impl FnMut() -> f64) -> [f64; 2] {
    amount();
    let mut rounds: Vec<[f64; 2]> = (0..ROUNDS)
        .map(|_| {
            let fixed = rate(factorise);
            let own = rate(&mut amount);
            [own, own / fixed]
        })
        .collect();
    rounds.sort_by(|one, other| one[1].total_cmp(&other[1]));
    rounds[ROUNDS / 2]
}

/// Simulates an attempt from its file; its length, in s.
fn simulate(exercise: &str) -> f64 {
    let bundle = ExerciseBundle::read(&root().join(format!("curricula/{exercise}.toml"))).expect("an exercise");
    let hand: HandChoice = "novice".parse().expect("a hand");
    let maker = AttemptMaker {
        device: "speed",
        device_max_force_n: f64::INFINITY,
        seed: 1,
        tick_hz: 1e3,
        version: "",
        git: "",
    };
    let session = maker.session(&bundle, uuid::Uuid::nil(), Moment::from_micros(0).to_utc());
    let staging = Staging::new(&bundle, &session).expect("a scene");
    let mut source = hand.source(&bundle.plan(), 1).expect("a hand that needs no file");
    staging.record(source.as_mut(), io::sink()).expect("nothing is refused").duration_s
}

/// Every figure's name, in order.
fn figures() -> impl Iterator<Item = String> {
    let pages = PAGES.iter().map(|(role, _, path)| format!("{role} {path}"));
    pages.chain(SCENES.iter().map(|scene| (*scene).to_owned()))
}

#[test]
#[ignore = "measures, and writes docs/speed.csv"]
fn speed_is_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    run_ok("web-admin", &["demo", "--password", PASSWORD, "--data-dir", &data.to_string_lossy()]);
    let service = Service::start(&data);
    let pages = PAGES.iter().map(|(_, email, path)| {
        let visitor = Visitor::signed_in(&service.url, email, PASSWORD);
        measure(|| {
            visitor.page(path);
            1.0
        })
    });
    let measured: Vec<[f64; 2]> = pages.chain(SCENES.iter().map(|scene| measure(|| simulate(scene)))).collect();
    let mut text = fs::read_to_string(root().join(FILE)).unwrap_or_else(|_| format!("{HEADER}\n"));
    let run = read_runs(&text).last_key_value().map_or(1, |(last, _)| last + 1);
    for (figure, [per_s, ratio]) in figures().zip(measured) {
        writeln!(text, "{run},{figure},{per_s:.1},{ratio:.4}").expect("a text");
    }
    fs::write(root().join(FILE), text).expect("docs/speed.csv");
}

/// The ratios of each run, figure by figure.
fn read_runs(text: &str) -> BTreeMap<u32, Vec<(String, f64)>> {
    let mut runs: BTreeMap<u32, Vec<(String, f64)>> = BTreeMap::new();
    for line in text.lines().skip(1) {
        let [run, figure, _, ratio] = *line.split(',').collect::<Vec<_>>() else { panic!("{line}: no figure") };
        let (run, ratio) = (run.parse().expect("a run"), ratio.parse().expect("a ratio"));
        runs.entry(run).or_default().push((figure.to_owned(), ratio));
    }
    runs
}

#[test]
fn no_page_and_no_scene_is_slower_than_in_the_run_before() {
    let text = fs::read_to_string(root().join(FILE)).expect("docs/speed.csv");
    assert_eq!(text.lines().next(), Some(HEADER));
    let runs = read_runs(&text);
    let last: Vec<_> = runs.values().rev().take(2).collect();
    let known: Vec<String> = last[0].iter().map(|(figure, _)| figure.clone()).collect();
    assert_eq!(known, figures().collect::<Vec<_>>(), "the last run has other figures");
    for (figure, ratio) in last.iter().flat_map(|run| run.iter()) {
        assert!(*ratio > 0.0 && ratio.is_finite(), "{figure}: {ratio}");
    }
    for (figure, before) in last.get(1).into_iter().flat_map(|run| run.iter()) {
        let now = last[0].iter().find(|(name, _)| name == figure).map_or(f64::INFINITY, |(_, ratio)| *ratio);
        assert!(now >= LEAST * before, "{figure}: {now} after {before}");
    }
}
