//! Documents of before are judged as before, and second versions see through a tremor.
//! Fails when a line without a version comes to mean another definition, when a rubric of before gets another hash, or when a
//! filter, a band or a threshold is not the one that scipy and the definitions say.

use assessment::{Deduction, suffices};
use documents::ExerciseBundle;
use recording::{EventKind, Recording};

use crate::support::{bundle, decimate, down, expect, expect_absent, expect_anew, judge, line, mark, plunge, record};

const PI: f64 = std::f64::consts::PI;

/// An exercise as it was shipped before anything was required and before any metric had a second version.
fn of_before(exercise: &str, scene: &str) -> ExerciseBundle {
    ExerciseBundle::from_parts(exercise.as_bytes(), scene.as_bytes(), &[]).expect("documents of before still parse")
}

fn feel_the_layers() -> ExerciseBundle {
    of_before(
        include_str!("../../../../tests/data/exercises/feel-the-layers-of-before.toml"),
        include_str!("../../../../curricula/scenes/lower-back-training.toml"),
    )
}

#[test]
fn a_rubric_of_before_keeps_its_hash() {
    let avoid = of_before(
        include_str!("../../../../tests/data/exercises/avoid-the-vessel-of-before.toml"),
        include_str!("../../../../curricula/scenes/lower-back-vessel.toml"),
    );
    // As it stood in scores before there were versions.
    assert_eq!(avoid.exercise.rubric_sha256(), "bbaa4af978f72b052241634ea8dd83d8c6e0ed8d981d90ca1152200a2cac6154");
}

#[test]
fn earlier_exercise_still_scores_a_prick_as_it_did_then() {
    let bundle = feel_the_layers();
    let judged = judge(&plunge(3.2), &bundle);
    // Two boundaries that were never opened, no force and one entry: 3, 2, 2 and 1 of 10; the depth is 14.8 mm off.
    assert!((judged.score - 80.0).abs() < 1e-9 && judged.passed, "{}", judged.score);
    assert!(judged.deductions.iter().all(|d| d.version == 1));
    let mut today = bundle;
    today.exercise.required = Some(documents::Required::default());
    assert!((judge(&plunge(3.2), &today).score - 30.0).abs() < 1e-9, "what was not opened earns nothing");
}

#[test]
fn a_line_means_the_first_version_unless_it_says_otherwise() {
    let recording = trembling();
    let mut bundle = bundle();
    bundle.exercise.rubric = vec![line("path_length_mm", 0.0, 40.0, 1.0)];
    let first = judge(&recording, &bundle);
    bundle.exercise.rubric[0].version = 2;
    let second = judge(&recording, &bundle);
    assert!(first.score < 30.0 && second.score > 75.0, "{} {}", first.score, second.score);
    assert_eq!([first.deductions[0].version, second.deductions[0].version], [1, 2]);
    assert_ne!(first.rubric.sha256, second.rubric.sha256);
    let mut measured_before = second.metrics;
    assert!(suffices(&bundle.exercise, &measured_before));
    measured_before.retain(|metric| metric.version == 1);
    assert!(!suffices(&bundle.exercise, &measured_before), "the recording has to be measured again");
}

#[test]
fn a_score_stored_before_there_were_versions_has_the_first() {
    let stored = r#"{ "metric": "overshoot_mm", "points": 3.0, "why": "because" }"#;
    let deduction: Deduction = serde_json::from_str(stored).expect("as it was stored");
    assert_eq!(deduction.version, 1);
}

/// 2 mm/s, from 2 s on 10 mm/s for 0.3 s, then none; a tremor of 9 Hz along the axis and of 10 Hz across it.
fn trembling() -> Recording {
    let depth_mm = |t_s: f64| 2.0 * t_s.min(2.0) + 10.0 * (t_s - 2.0).clamp(0.0, 0.3);
    let mut recording = record(1000.0, 6.0, |t_s| {
        down(0.08 * libm::cos(20.0 * PI * t_s), 0.0, depth_mm(t_s) + 0.1 * libm::sin(18.0 * PI * t_s))
    });
    recording.events.retain(|event| event.kind == EventKind::Contact);
    mark(&mut recording, 2.0, EventKind::TipRupture, Some(2));
    recording
}

#[test]
fn behind_4_hz_the_figures_are_those_of_scipy() {
    for recording in [decimate(&trembling(), 0), trembling()] {
        let judged = judge(&recording, &bundle());
        // scipy 1.17: butter(2, 4 Hz), filtfilt with odd padding of 500 points at 250 Hz; the definitions written out in numpy.
        expect_anew(&judged, "path_length_mm", 7.728_211_891_540_09, 1e-6);
        expect_anew(&judged, "path_in_tissue_mm", 7.717_293_363_308_014_5, 1e-6);
        expect_anew(&judged, "axis_travel_mm", 7.526_343_027_512_314, 1e-6);
        expect_anew(&judged, "idle_fraction", 0.595_333_333_333_333_3, 1e-9);
        expect_anew(&judged, "stop_time_s.muscle.tip", 0.32, 1e-9);
        expect(&judged, "smoothness_sparc", -2.099_042_020_787_122, 1e-6);
        // The same motion at 20 Hz: four fifths of the way are the tremor's, and it is never idle.
        expect(&judged, "path_length_mm", 31.378_730_521_351_55, 1e-3);
        expect(&judged, "idle_fraction", 0.0, 1e-9);
    }
}

#[test]
fn a_needle_that_goes_on_for_good_never_stands() {
    let mut recording = record(1000.0, 4.0, |t_s| down(0.0, 0.0, 2.0 * t_s));
    mark(&mut recording, 2.0, EventKind::TipRupture, Some(2));
    let judged = judge(&recording, &bundle());
    assert_eq!(judged.value_of("stop_time_s", 2), None);
    expect_absent(&judged, "stop_time_s");
}

#[test]
fn action_and_pause_each_last_over_a_fifth_of_a_second() {
    // Strokes of 80 mm/s across the skin from 1 s on: so long in s, and so long a pause after each.
    let count = |strokes: &[(f64, f64)]| {
        let ends: Vec<f64> = strokes
            .iter()
            .scan(1.0, |at, (on, off)| {
                *at += on + off;
                Some(*at)
            })
            .collect();
        let way = |t_s: f64| -> f64 {
            let gone = strokes.iter().zip(&ends).map(|((on, off), end)| (t_s - (end - on - off)).clamp(0.0, *on));
            gone.sum::<f64>() * 80.0
        };
        let judged = judge(&record(1000.0, 6.0, |t_s| down(way(t_s), 0.0, -5.0)), &bundle());
        judged.value_of("translational_actions", 2).map(|count| count as u32)
    };
    assert_eq!(count(&[(0.6, 0.0)]), Some(1), "one stroke");
    assert_eq!(count(&[(0.1, 0.0)]), Some(0), "a twitch");
    assert_eq!(count(&[(0.6, 0.6), (0.6, 0.0)]), Some(2), "two strokes");
    assert_eq!(count(&[(0.6, 0.1), (0.6, 0.0)]), Some(1), "a stutter");
    assert_eq!(count(&[]), Some(0));
}
