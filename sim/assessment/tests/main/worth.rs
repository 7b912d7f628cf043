//! What must have happened before anything is earned, and what nothing is worth.
//! Fails when an exercise pays for a prick, when a requirement is not asked, or when an author is not told of a mistake.

use std::path::{Path, PathBuf};

use assessment::words::{deduction_in_words, failure_in_words};
use assessment::{Assessment, Tryout, review_rubric};
use documents::{ExerciseBundle, Patient, Required, Shape, StructureKind};
use law::operator::{Operator, Plan};
use recording::{EventKind, Recording};

use crate::support::{bundle, down, judge, limit, line, mark, record, structure};

fn shipped() -> Vec<(PathBuf, ExerciseBundle)> {
    let curricula = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula");
    let folders = std::fs::read_dir(curricula).expect("shipped").map(|folder| folder.expect("shipped").path());
    let courses = folders.filter(|folder| folder.join("course.toml").is_file());
    let files = courses.flat_map(|course| std::fs::read_dir(course).expect("shipped"));
    let is_exercise = |path: &PathBuf| path.extension().is_some_and(|e| e == "toml") && !path.ends_with("course.toml");
    let paths = files.map(|file| file.expect("shipped").path()).filter(is_exercise);
    paths.map(|path| (path.clone(), ExerciseBundle::read(&path).expect("sound"))).collect()
}

/// A stiff hand: in at 5 mm/s, a hold, a confirm, and out.
fn prick(tryout: &Tryout<'_>, depth_mm: f64) -> Recording {
    let plan = Plan { target_x_m: depth_mm * 1e-3, hold_s: 0.5, ..tryout.bundle.exercise.plan() };
    tryout.perform(&mut Operator::constant(0.005, &plan))
}

/// Which boundaries were opened, and by what.
fn pops(recording: &Recording) -> Vec<(EventKind, Option<u32>)> {
    let pops = recording.events.iter().filter(|event| event.kind.contactor().is_some());
    pops.map(|event| (event.kind, event.boundary)).collect()
}

/// Pricks of every millimetre to 10 mm beyond the target. One that has opened what the task opens, and nothing else, has done it.
fn check_pricks((path, bundle): &(PathBuf, ExerciseBundle)) {
    let tryout = Tryout::new(bundle, Patient::nominal(&bundle.scene)).expect("sound");
    let target_mm = bundle.exercise.target_depth_mm;
    let whole = prick(&tryout, target_mm);
    let best = judge(&whole, bundle);
    assert!(best.passed && best.score > 80.0, "{}: {} for the target itself", path.display(), best.score);
    let mut unconfirmed = whole.clone();
    unconfirmed.events.retain(|event| event.kind != EventKind::Confirm);
    let mut left_inside = whole.clone();
    left_inside.samples.truncate(whole.samples.len() / 2);
    for (what, careless) in [("unconfirmed", unconfirmed), ("left inside", left_inside)] {
        let judged = judge(&careless, bundle);
        assert!(judged.score <= 25.0 && !judged.passed, "{}: {} {what}", path.display(), judged.score);
    }
    for depth_mm in 1..=(target_mm + 10.0) as u32 {
        let prick = prick(&tryout, f64::from(depth_mm));
        let judged = judge(&prick, bundle);
        let is_little = judged.score <= 25.0 && !judged.passed;
        let (score, file) = (judged.score, path.display());
        assert!(is_little || pops(&prick) == pops(&whole), "{file}: {score} for a prick of {depth_mm} mm");
    }
}

#[test]
fn prick_off_task_earns_at_most_25_points_in_shipped_exercises() {
    let shipped = shipped();
    assert_eq!(shipped.len(), 17);
    std::thread::scope(|scope| {
        let checks: Vec<_> = shipped.iter().map(|exercise| scope.spawn(|| check_pricks(exercise))).collect();
        checks.into_iter().for_each(|check| check.join().expect("a prick earns little"));
    });
}

fn requiring(required: Required) -> ExerciseBundle {
    let mut bundle = bundle();
    bundle.exercise.required = Some(required);
    bundle
}

/// To 20 mm and out again in 22 s, through the muscle at 14 mm, confirmed at the bottom.
fn whole() -> Recording {
    let mut recording = record(1000.0, 22.0, |t_s| down(0.0, 0.0, 20.0 - 2.0 * (t_s - 10.5).abs()));
    mark(&mut recording, 7.5, EventKind::TipRupture, Some(2));
    mark(&mut recording, 10.5, EventKind::Confirm, None);
    recording
}

fn all() -> Required {
    Required { reached: Some("muscle".into()), within_mm: Some(3.0), confirmed: true, withdrawn: true }
}

#[track_caller]
fn earns_nothing(judged: &Assessment, why: &str) {
    assert!(judged.score.abs() < 1e-9 && !judged.passed, "{}", judged.score);
    assert!(
        judged
            .hard_fails
            .iter()
            .map(failure_in_words)
            .any(|fail| fail.starts_with("No points: ") && fail.contains(why))
    );
    assert!(judged.deductions.iter().all(|d| deduction_in_words(d).contains(": the ")), "{:?}", judged.deductions);
}

#[test]
fn what_is_required_and_did_not_happen_leaves_nothing() {
    let bundle = requiring(all());
    let best = judge(&whole(), &bundle);
    assert!((best.score - 100.0).abs() < 1e-6 && best.passed && best.hard_fails.is_empty(), "{best:?}");

    let mut unconfirmed = whole();
    unconfirmed.events.retain(|event| event.kind != EventKind::Confirm);
    earns_nothing(&judge(&unconfirmed, &bundle), "the position was not confirmed");
    let mut in_the_air = unconfirmed;
    mark(&mut in_the_air, 0.1, EventKind::Confirm, None);
    earns_nothing(&judge(&in_the_air, &bundle), "the position was not confirmed");

    let mut left_inside = whole();
    left_inside.samples.retain(|sample| sample.t_s < 16.5);
    earns_nothing(&judge(&left_inside, &bundle), "the needle was not withdrawn");

    let mut unopened = whole();
    unopened.events.retain(|event| event.boundary != Some(2));
    earns_nothing(&judge(&unopened, &bundle), "did not reach the required layer");

    let mut early = whole();
    early.events.retain(|event| event.kind != EventKind::Confirm);
    mark(&mut early, 8.9, EventKind::Confirm, None);
    earns_nothing(&judge(&early, &bundle), "too far from the target");
}

#[test]
fn each_requirement_is_asked_alone_and_only_where_it_is_stated() {
    let mut careless = whole();
    careless.events.retain(|event| event.kind == EventKind::Contact);
    careless.samples.retain(|sample| sample.t_s < 16.5);
    let judged = judge(&careless, &requiring(Required::default()));
    assert!(judged.hard_fails.is_empty() && judged.score > 99.0, "{judged:?}");
    for alone in [
        Required { reached: Some("muscle".into()), ..Required::default() },
        Required { confirmed: true, ..Required::default() },
        Required { withdrawn: true, ..Required::default() },
    ] {
        assert_eq!(judge(&careless, &requiring(alone)).hard_fails.len(), 1);
    }
    assert_eq!(judge(&careless, &requiring(all())).hard_fails.len(), 3);
}

#[test]
fn what_is_required_can_be_judged_from_stored_metrics() {
    let bundle = requiring(all());
    let judged = judge(&whole(), &bundle);
    assert!(assessment::suffices(&bundle.exercise, &judged.metrics));
    let again = assessment::judge(judged.metrics.clone(), &bundle.exercise, &judged.simulator_version);
    assert_eq!(again.expect("judged"), judged);
    for id in ["confirmed", "withdrawn", "reached.muscle", "depth_error_mm"] {
        let lacking: Vec<_> = judged.metrics.iter().filter(|metric| metric.id != id).cloned().collect();
        assert!(!assessment::suffices(&bundle.exercise, &lacking), "{id} was never measured");
    }
}

#[test]
fn an_untouched_needle_is_told_that_and_nothing_else() {
    let judged = judge(&record(1000.0, 2.0, |_| down(0.0, 0.0, -3.0)), &requiring(all()));
    assert!(judged.score.abs() < 1e-9 && judged.hard_fails.is_empty(), "{judged:?}");
    assert!(deduction_in_words(&judged.deductions[0]).contains("never reached the skin"));
}

#[test]
fn an_author_is_told_of_lines_that_reward_the_worse_value() {
    let mut bundle = bundle();
    let sphere = Shape::Sphere { radius_m: 1e-3 };
    bundle.scene.structures = vec![
        structure("artery", StructureKind::Vessel, sphere.clone(), [0.0, 0.0, -5.0]),
        structure("goal", StructureKind::Target, sphere, [0.0, 0.0, -20.0]),
    ];
    let right = [
        line("peak_force_n", 2.0, 6.0, 1.0),
        line("depth_error_mm", 0.5, 4.0, 1.0),
        line("structure_clearance_mm.artery", 2.0, 0.0, 1.0),
        line("structure_clearance_mm.goal", 0.0, 2.0, 1.0),
        line("confirmed", 1.0, 0.0, 1.0),
    ];
    bundle.exercise.rubric = right.to_vec();
    bundle.exercise.hard_fails = vec![limit("peak_force_n", 10.0, "Too hard.")];
    assert_eq!(review_rubric(&bundle), []);
    for (i, line) in bundle.exercise.rubric.iter_mut().enumerate() {
        (line.full, line.zero) = (right[i].zero, right[i].full);
    }
    bundle.exercise.hard_fails.push(limit("structure_clearance_mm.artery", 5.0, "Too near."));
    let fields: Vec<String> = review_rubric(&bundle).into_iter().map(|remark| remark.field).collect();
    assert_eq!(
        fields,
        [
            "rubric[0].full",
            "rubric[1].full",
            "rubric[2].full",
            "rubric[3].full",
            "rubric[4].full",
            "hard_fail[1].above"
        ]
    );
}

#[test]
fn an_author_is_told_of_metrics_that_no_rubric_should_ask_for() {
    let mut bundle = bundle();
    bundle.exercise.rubric = vec![line("stop_time_s", 0.3, 2.0, 1.0)];
    let [remark] = &review_rubric(&bundle)[..] else { panic!("one line, one remark") };
    assert_eq!(remark.field, "rubric[0].metric");
    assert!(remark.allowed.to_string().contains("version 2"), "{}", remark.allowed);
}
