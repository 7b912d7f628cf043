//! From metrics to points, reasons and a pass.
//! Fails when points do not add up to the score, a reason misleads, or an attempt that was not made earns points.

use assessment::words::{deduction_in_words, failure_in_words};
use assessment::{Absent, Assessment, Metric, assess, suffices};
use documents::{ExerciseBundle, RubricLine};
use recording::{EventKind, Recording};

use crate::support::{bundle, down, judge, limit, line, mark, press, record};

fn to_depth(depth_mm: f64) -> Recording {
    record(1000.0, 12.0, |t_s| down(0.0, 0.0, depth_mm * t_s.min(10.0) / 10.0 - 0.001))
}

fn with(rubric: Vec<RubricLine>) -> ExerciseBundle {
    let mut bundle = bundle();
    bundle.exercise.rubric = rubric;
    bundle
}

fn why(assessment: &Assessment, metric: &str) -> String {
    deduction_in_words(assessment.deductions.iter().find(|d| d.metric == metric).expect("every line is listed"))
}

#[test]
fn the_score_is_the_weighted_mean_and_the_points_add_up_to_it() {
    let lines = vec![line("depth_error_mm", 0.5, 4.5, 3.0), line("time_total_s", 6.0, 18.0, 1.0)];
    let assessment = judge(&to_depth(22.501), &with(lines));
    // Depth: 2.5 mm is halfway, 0.5 of 75 points; time: 12 s is halfway, 0.5 of 25 points.
    assert!((assessment.score - 50.0).abs() < 1e-6, "{}", assessment.score);
    let lost: f64 = assessment.deductions.iter().map(|d| d.points).sum();
    assert!((100.0 - lost - assessment.score).abs() < 1e-9);
    assert_eq!(assessment.deductions[0].metric, "depth_error_mm", "the dearest first");
    assert!(!assessment.passed);
}

#[test]
fn reasons_say_what_to_do() {
    let lines = vec![line("depth_error_mm", 0.5, 4.5, 1.0), line("peak_force_n", 2.0, 6.0, 1.0)];
    let mut recording = to_depth(21.921);
    press(&mut recording, 5.0..6.0, |_| 3.04);
    let assessment = judge(&recording, &with(lines.clone()));
    assert_eq!(why(&assessment, "depth_error_mm"), "1.9 mm too deep: −18 points");
    assert_eq!(
        why(&assessment, "peak_force_n"),
        "peak force 3 N, full marks for 2 N or less – push more gently: −13 points"
    );
    let shallow = judge(&to_depth(18.001), &with(lines));
    assert_eq!(why(&shallow, "depth_error_mm"), "2 mm too shallow: −19 points");
    assert_eq!(why(&shallow, "peak_force_n"), "peak force 0 N: no points lost");
}

#[test]
fn a_needle_that_never_reached_the_skin_earns_nothing() {
    let lines = ["time_total_s", "structure_hits", "over_insertion_mm", "depth_error_mm"];
    let bundle = with(lines.iter().map(|metric| line(metric, 100.0, 200.0, 1.0)).collect());
    let assessment = judge(&record(1000.0, 2.0, |_| down(0.0, 0.0, -3.0)), &bundle);
    assert!(assessment.score.abs() < 1e-9 && !assessment.passed);
    assert_eq!(why(&assessment, "structure_hits"), "structures hit: the needle never reached the skin: −25 points");
}

#[test]
fn stored_metrics_give_the_recordings_score_where_they_suffice() {
    let lines = ["depth_error_mm", "over_insertion_mm.muscle.tip", "rupture_energy_mj", "structure_hits"];
    let mut bundle = with(lines.iter().map(|metric| line(metric, 0.5, 5.0, 1.0)).collect());
    bundle.exercise.hard_fails = vec![limit("depth_error_mm", 1.0, "Far too deep.")];
    for depth_mm in [0.5, 22.0] {
        let assessed = judge(&to_depth(depth_mm), &bundle);
        let stored: Vec<Metric> = assessed.metrics.clone();
        assert!(suffices(&bundle.exercise, &stored));
        assert_eq!(assessment::judge(stored, &bundle.exercise, &assessed.simulator_version).unwrap(), assessed);
    }
    let stored = judge(&to_depth(22.0), &bundle).metrics;
    let changed = |id: &str, change: fn(&mut Metric)| {
        let mut metrics = stored.clone();
        metrics.iter_mut().filter(|metric| metric.id == id).for_each(change);
        suffices(&bundle.exercise, &metrics)
    };
    assert!(!changed("structure_hits", |metric| metric.version = 0), "of an earlier definition");
    assert!(!changed("depth_error_mm", |metric| metric.id.clear()), "not measured");
    assert!(!changed("over_insertion_mm.muscle.tip", |metric| {
        (metric.value, metric.absent) = (None, Some(Absent::OfAnotherVersion));
    }));
    assert!(changed("time_total_s", |metric| metric.version = 0), "nobody asks for it");
}

#[test]
fn unreached_layers_cost_nothing_and_unknown_metrics_cost_all() {
    let lines =
        ["over_insertion_mm.muscle.tip", "peak_force_layer_n.muscle", "rupture_energy_mj", "stop_time_s", "charm"];
    let bundle = with(lines.iter().map(|metric| line(metric, 1.0, 5.0, 1.0)).collect());
    let assessment = judge(&record(1000.0, 1.0, |t_s| down(0.0, 0.0, 8.0 * t_s - 1.0)), &bundle);
    let points = |metric: &str| assessment.deductions.iter().find(|d| d.metric == metric).map(|d| d.points);
    assert_eq!(points("over_insertion_mm.muscle.tip"), Some(0.0));
    assert_eq!(points("peak_force_layer_n.muscle"), Some(0.0));
    assert_eq!(points("rupture_energy_mj"), Some(20.0));
    assert_eq!(points("stop_time_s"), Some(20.0));
    assert_eq!(points("charm"), Some(20.0));
    assert!(why(&assessment, "charm").contains("not available in this scene"));
}

#[test]
fn a_hard_fail_fails_a_perfect_score() {
    let mut bundle = bundle();
    bundle.exercise.hard_fails = vec![limit("structure_hits", 0.0, "You met a structure.")];
    let mut recording = to_depth(20.001);
    let clean = judge(&recording, &bundle);
    assert!(clean.passed && clean.hard_fails.is_empty());
    mark(&mut recording, 5.0, EventKind::StructureHit, None);
    let failed = judge(&recording, &bundle);
    assert!((failed.score - 100.0).abs() < 1e-9 && !failed.passed);
    let told: Vec<String> = failed.hard_fails.iter().map(failure_in_words).collect();
    assert_eq!(told, ["You met a structure. (structures hit 1, limit 0)"]);
}

#[test]
fn a_rubric_that_weighs_nothing_is_refused() {
    assert!(assess(&to_depth(20.0), &with(vec![])).is_err());
    assert!(assess(&to_depth(20.0), &with(vec![line("depth_error_mm", 0.5, 4.5, f64::NAN)])).is_err());
}

#[test]
fn the_json_has_the_contract_s_shape() {
    let mut bundle = bundle();
    bundle.exercise.hard_fails = vec![limit("depth_error_mm", -5.0, "Too deep.")];
    let json = serde_json::to_value(judge(&to_depth(20.0), &bundle)).expect("plain data");
    let keys = |v: &serde_json::Value| v.as_object().map(|o| o.keys().cloned().collect::<Vec<_>>()).unwrap_or_default();
    assert_eq!(keys(&json), ["deductions", "hard_fails", "metrics", "passed", "rubric", "score", "simulator_version"]);
    assert_eq!(keys(&json["rubric"]), ["id", "sha256"]);
    assert_eq!(keys(&json["deductions"][0]), ["cause", "metric", "points", "version", "why"]);
    assert_eq!(json["deductions"][0]["cause"]["kind"], "measured");
    assert_eq!(json["hard_fails"][0]["cause"]["kind"], "limit");
    assert!(json["hard_fails"][0]["why"].as_str().is_some_and(|why| why.starts_with("Too deep. (")), "{json}");
    let metrics = json["metrics"].as_array().expect("a list");
    let depth = metrics.iter().find(|m| m["id"] == "depth_error_mm").expect("listed");
    assert_eq!((&depth["unit"], &depth["direction"], &depth["version"]), (&"mm".into(), &"range".into(), &1.into()));
    let absent = metrics.iter().find(|m| m["id"] == "friction_energy_mj").expect("listed");
    assert!(absent["value"].is_null() && absent["applies"] == false, "no ledger was recorded: {absent}");
    assert_eq!(absent["absent"], "no_ledger");
}
