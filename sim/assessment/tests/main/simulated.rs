//! Simulated hands at the shipped exercises, judged from what was recorded.
//! Fails when skill does not show in the score, when every expert is perfect, when the recording's rate reaches a metric, when what a recording
//! carries is not what it is judged by, or when any figure of one pinned attempt changes.

use std::path::{Path, PathBuf};

use assessment::{Assessment, DeductionCause, Metric, Tryout, assess, attachments, own_exercise};
use documents::{ExerciseBundle, Patient};
use law::operator::{Operator, Skill};
use recording::{Recording, Writer};

use crate::support::{decimate, session_of};

fn course() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/lower-back-basics")
}

fn exercise(file: &str) -> ExerciseBundle {
    ExerciseBundle::read(&course().join(file)).expect("a shipped exercise is sound")
}

fn attempt(bundle: &ExerciseBundle, skill: &Skill, seed: u64) -> Recording {
    let tryout = Tryout::new(bundle, Patient::draw(&bundle.scene, seed)).expect("a shipped scene is sound");
    tryout.perform(&mut Operator::skilled(skill, &bundle.plan(), seed))
}

fn median_score(bundle: &ExerciseBundle, skill: &Skill) -> f64 {
    let score = |seed| assess(&attempt(bundle, skill, seed), bundle).expect("scored").score;
    let mut scores: Vec<f64> = (1..=7).map(score).collect();
    scores.sort_by(f64::total_cmp);
    scores[3]
}

#[test]
fn experts_score_higher_than_novices() {
    for file in ["2-stop-in-the-fat.toml", "3-reach-the-muscle.toml", "6-avoid-the-vessel.toml"] {
        let bundle = exercise(file);
        let (novice, expert) = (median_score(&bundle, &Skill::novice()), median_score(&bundle, &Skill::expert()));
        assert!(expert > novice + 5.0, "{file}: novice {novice}, expert {expert}");
    }
}

/// The score is to tell good attempts from better ones among those who can do it, too.
#[test]
fn experts_do_well_but_not_all_and_not_always_perfectly() {
    for file in ["2-stop-in-the-fat.toml", "3-reach-the-muscle.toml", "5-oblique-approach.toml"] {
        let bundle = exercise(file);
        let scores: Vec<f64> = (0..10)
            .map(|seed| assess(&attempt(&bundle, &Skill::expert(), seed), &bundle).expect("scored").score)
            .collect();
        let perfect = scores.iter().filter(|score| **score > 99.99).count();
        let mean = scores.iter().sum::<f64>() / scores.len() as f64;
        assert!(perfect < 8, "{file}: {perfect} of 10 experts score 100: {scores:?}");
        assert!(mean > bundle.exercise.pass_mark, "{file}: {scores:?}");
        let range =
            scores.iter().copied().fold(f64::NEG_INFINITY, f64::max) - scores.iter().copied().fold(100.0, f64::min);
        assert!(range > 2.0, "{file}: they score alike: {scores:?}");
    }
}

/// How far apart two recordings of one attempt may be: 1 %, and what a tick of the slower one resolves. Where its samples
/// fall between the grid's points, the steps that cutting puts into the force are seen a little earlier or later, and a
/// run of speed that ends near its limit may count or not.
fn allowed(metric: &Metric, size: f64, from: usize) -> f64 {
    let share = match metric.id.as_str() {
        "force_rate_peak_n_per_s" if from > 0 => 0.025,
        "translational_actions" if from > 0 => 0.1,
        _ => 0.01,
    };
    let tick = match metric.id.as_str() {
        "time_total_s" | "time_in_tissue_s" => 0.004,
        // A stop is seen at a point of the grid.
        _ if metric.version == 2 && metric.id.starts_with("stop_time_s") => 0.004,
        "idle_fraction" => 0.001,
        // A quick hand tents by another tenth of a newton between the last sample and the rupture.
        id if id.starts_with("peak_force") => 0.1,
        // A layer ends up to 4 ms after the last sample in it, and the needle bends on.
        id if id.starts_with("max_lateral_force_n") => 0.006,
        // A hand that comes to rest still goes at 1 mm/s when it confirms, up to 4 ms before the next sample.
        "depth_error_mm" | "overshoot_mm" | "tip_error_mm" => 0.004,
        _ => 0.0,
    };
    share * size + tick
}

#[test]
fn a_quarter_of_the_samples_give_the_same_metrics() {
    let bundle = exercise("6-avoid-the-vessel.toml");
    for (skill, seed, from) in [(Skill::novice(), 3, 0), (Skill::expert(), 4, 0), (Skill::novice(), 5, 2)] {
        let fast = attempt(&bundle, &skill, seed);
        let slow = assess(&decimate(&fast, from), &bundle).expect("scored");
        let fast = assess(&fast, &bundle).expect("scored");
        for (a, b) in fast.metrics.iter().zip(&slow.metrics) {
            let (x, y) = (a.value.unwrap_or(0.0), b.value.unwrap_or(0.0));
            let near = (x - y).abs() <= allowed(a, x.abs().max(y.abs()), from);
            assert!(near && a.applies == b.applies, "{} from {from}: {x} at 1 kHz, {y} at 250 Hz", a.id);
        }
        assert!((fast.score - slow.score).abs() < 1.0, "{} at 1 kHz, {} at 250 Hz", fast.score, slow.score);
    }
}

#[test]
fn every_line_of_the_shipped_rubrics_is_a_metric_of_its_scene() {
    for entry in std::fs::read_dir(course()).expect("shipped") {
        let path = entry.expect("shipped").path();
        if path.ends_with("course.toml") || path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let bundle = ExerciseBundle::read(&path).expect("a shipped exercise is sound");
        let assessment = assess(&attempt(&bundle, &Skill::expert(), 1), &bundle).expect("scored");
        let limits = bundle.exercise.hard_fails.iter().map(|limit| (&limit.metric, limit.version));
        for (id, version) in bundle.exercise.rubric.iter().map(|line| (&line.metric, line.version)).chain(limits) {
            let measured = assessment.metrics.iter().any(|m| m.id == *id && m.version == version);
            assert!(measured, "{}: {id}, version {version}", path.display());
        }
    }
}

#[test]
fn documents_and_catalogue_know_the_same_metrics() {
    let documents = documents::metrics::METRICS.iter();
    let documents: Vec<_> = documents.flat_map(|known| (1..=known.newest).map(|version| (known.id, version))).collect();
    let catalogue: Vec<_> = assessment::catalogue::DEFINITIONS.iter().map(|d| (d.id, d.version)).collect();
    assert_eq!(documents, catalogue);
}

/// Writes an attempt with its documents, and reads it back.
fn through_a_file(attempt: &Recording, bundle: &ExerciseBundle) -> Recording {
    let attachments = attachments(bundle);
    let session = session_of(bundle, attempt.session.clone());
    let mut writer =
        Writer::create(Vec::new(), &session, &attachments, &Default::default()).expect("memory does not refuse");
    for sample in &attempt.samples {
        writer.sample(sample).expect("memory does not refuse");
    }
    for event in &attempt.events {
        writer.event(event).expect("memory does not refuse");
    }
    for energy in &attempt.energies {
        writer.energy(energy).expect("memory does not refuse");
    }
    let bytes = writer.finish().expect("memory does not refuse");
    Recording::read(bytes.as_slice()).expect("just written")
}

/// Nine digits: the last bits are the platform's.
fn rounded(mut assessment: Assessment) -> Assessment {
    let round = |value: f64| format!("{value:.8e}").parse().unwrap_or(value);
    assessment.score = round(assessment.score);
    assessment.metrics.iter_mut().for_each(|m| m.value = m.value.map(round));
    assessment.deductions.iter_mut().for_each(|d| d.points = round(d.points));
    for deduction in &mut assessment.deductions {
        if let DeductionCause::Measured { value, .. } = &mut deduction.cause {
            *value = round(*value);
        }
    }
    assessment
}

#[test]
fn a_recording_is_judged_by_the_exercise_it_carries() {
    let bundle = exercise("6-avoid-the-vessel.toml");
    let attempt = attempt(&bundle, &Skill::intermediate(), 11);
    let recording = through_a_file(&attempt, &bundle);
    let own = own_exercise(&recording).expect("attached");
    assert_eq!(own.exercise, bundle.exercise);
    let assessment = assess(&recording, &own).expect("scored");
    assert_eq!(assessment, assess(&attempt, &bundle).expect("scored"), "nothing is lost on the way through the file");
    assert_eq!(assessment.rubric.id, "avoid-the-vessel");
    insta::assert_json_snapshot!(rounded(assessment));
    let mut bare = recording;
    bare.attachments.clear();
    let missing = own_exercise(&bare).map(|_| ()).expect_err("nothing is attached");
    assert!(missing.to_string().contains("exercise.toml"), "{missing}");
}
