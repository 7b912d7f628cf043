//! A course with three exercises, each requiring the previous one; mastery takes 2 passes out of 3.
//! The tests check that locked exercises are not suggested, and that reasons for help are reported
//! exactly when they apply.

use documents::MasteryRule;
use time::Duration;
use time::macros::datetime;

use super::*;
use crate::ids::{RevisionId, SessionId};

const NOW: OffsetDateTime = datetime!(2026-05-20 12:00 UTC);

fn course() -> Course {
    let step = |id: &str, before: &[&str]| CourseStep {
        exercise: id.to_owned(),
        title: id.to_uppercase(),
        prerequisites: before.iter().map(|b| (*b).to_owned()).collect(),
    };
    Course {
        steps: vec![step("a", &[]), step("b", &["a"]), step("c", &["b"])],
        rule: Mastery::Passes { passes: 2, of: 3 },
        earlier: Vec::new(),
    }
}

/// Attempts one hour apart, the last one hour ago; a score of 60 passes.
fn attempts(tried: &[(&str, f64)]) -> Vec<ScoredAttempt> {
    let hours = |i: usize| i64::try_from(tried.len() - i).expect("few");
    let attempt = |(i, (exercise, score)): (usize, &(&str, f64))| ScoredAttempt {
        session: SessionId::from_u128(i as u128),
        exercise: (*exercise).into(),
        at: NOW - Duration::hours(hours(i)),
        score: *score,
        passed: *score >= 60.0,
        revision: None,
    };
    tried.iter().enumerate().map(attempt).collect()
}

fn progress(tried: &[(&str, f64)]) -> Progress {
    Progress::of(&course(), &attempts(tried))
}

#[test]
fn newcomer_has_the_first_exercise_next() {
    let progress = progress(&[]);
    assert_eq!(progress.next, Some(0));
    assert_eq!(progress.steps[1].state, StepState::Locked { missing: vec!["A".to_owned()] });
}

#[test]
fn mastery_opens_the_next_exercise_and_only_that() {
    let progress = progress(&[("a", 70.0), ("a", 30.0), ("a", 80.0)]);
    assert_eq!(progress.mastered(), 1);
    assert_eq!(progress.next, Some(1));
    assert_eq!(progress.steps[1].state, StepState::Open { passes: 0 });
    assert!(matches!(progress.steps[2].state, StepState::Locked { .. }));
}

#[test]
fn passes_too_far_apart_do_not_count_together() {
    let progress = progress(&[("a", 70.0), ("a", 30.0), ("a", 30.0), ("a", 80.0)]);
    assert_eq!(progress.mastered(), 0);
    assert_eq!(progress.steps[0].state, StepState::Open { passes: 1 });
}

#[test]
fn mastery_once_reached_stays() {
    let progress = progress(&[("a", 70.0), ("a", 80.0), ("a", 10.0), ("a", 10.0), ("a", 10.0)]);
    assert_eq!(progress.mastered(), 1);
}

/// A fail rate of 10 % is acceptable and 40 % is not: five consecutive successes are not enough,
/// eleven are.
fn by_curve(within: Option<u32>) -> Course {
    let rule = MasteryRule::Cusum { within, p0: 0.1, p1: 0.4, alpha: 0.1, beta: 0.1 };
    Course { rule: Mastery::from_rule(&rule).expect("the rule has lines"), ..course() }
}

#[test]
fn a_learning_curve_declares_watches_and_withdraws() {
    for within in [None, Some(30)] {
        let course = by_curve(within);
        let judged = |tried: &[(&str, f64)]| Progress::of(&course, &attempts(tried));
        let begun = judged(&[("a", 90.0); 2]);
        let needed = begun.steps[0].curve.as_ref().expect("a curve").successes_needed;
        assert!((2..12).contains(&needed) && begun.mastered() == 0, "{needed} more");
        let done = vec![("a", 90.0); 2 + needed as usize];
        assert_eq!((judged(&done).mastered(), judged(&done).next), (1, Some(1)), "{within:?}");
        let lost = judged(&[&done[..], &[("a", 10.0); 4]].concat());
        assert!(matches!(lost.steps[0].state, StepState::Regressing { .. }), "{:?}", lost.steps[0].state);
        assert_eq!((lost.mastered(), lost.next), (0, Some(0)), "practised again");
        assert!(matches!(lost.steps[1].state, StepState::Open { .. }), "what was opened stays open");
    }
}

#[test]
fn a_change_of_revision_within_an_exercise_is_seen() {
    let mut tried = attempts(&[("a", 70.0), ("a", 70.0), ("b", 70.0)]);
    let mixes = |tried: &[ScoredAttempt]| Progress::of(&course(), tried).steps[0].mixes_revisions();
    tried[2].revision = Some(RevisionId::from_u128(2));
    assert!(!mixes(&tried));
    tried[1].revision = Some(RevisionId::from_u128(1));
    assert!(mixes(&tried));
}

#[test]
fn attempts_on_other_courses_change_nothing() {
    assert_eq!(progress(&[("elsewhere", 90.0)]).last_at, None);
}

/// The same cases apply to the simulator's progress without a school.
#[test]
fn mastery_agrees_with_the_simulator_without_a_school() {
    let cases = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/mastery/cases.json");
    let cases: Vec<serde_json::Value> = serde_json::from_slice(&std::fs::read(cases).unwrap()).unwrap();
    assert!(cases.len() > 10);
    for case in cases {
        let (rule, number) = (&case["rule"], |key: &str| case["rule"][key].as_f64());
        let count = |key: &str| rule[key].as_u64().and_then(|count| u32::try_from(count).ok());
        let rule = match (count("passes"), count("of")) {
            (Some(passes), Some(of)) => MasteryRule::Passes { passes, of },
            _ => {
                let [p0, p1, alpha, beta] = ["p0", "p1", "alpha", "beta"].map(|key| number(key).unwrap());
                MasteryRule::Cusum { within: count("within"), p0, p1, alpha, beta }
            }
        };
        let course = Course { rule: Mastery::from_rule(&rule).unwrap(), ..course() };
        let tried: Vec<_> =
            case["attempts"].as_str().unwrap().chars().map(|c| ("a", if c == 'P' { 90.0 } else { 10.0 })).collect();
        let [first, next, _] = &Progress::of(&course, &attempts(&tried)).steps[..] else { panic!("three steps") };
        assert_eq!(first.mastered(), case["mastered"] == true, "{case}: {:?}", first.state);
        let locked = matches!(next.state, StepState::Locked { .. });
        assert_eq!(!locked, case["opens"] == true, "{case}: {:?}", next.state);
    }
}

/// The course, of which only the first two exercises were asked for until so many hours ago.
fn extended(hours: i64) -> Course {
    let course = course();
    let before = EarlierCourse {
        steps: course.steps[..2].to_vec(),
        rule: course.rule,
        sha256: "before".to_owned(),
        until: NOW - Duration::hours(hours),
    };
    Course { earlier: vec![before], ..course }
}

#[test]
fn mastery_belongs_to_the_course_revision_taught_at_that_time() {
    let tried = attempts(&[("a", 70.0), ("a", 70.0), ("b", 70.0), ("b", 70.0), ("a", 20.0)]);
    let kept = Progress::of(&extended(1), &tried);
    assert!(kept.complete() && kept.mastered() == 2 && kept.next == Some(2), "{kept:?}");
    assert_eq!(kept.completed_on(), Some(tried[3].at));
    let late = Progress::of(&extended(2), &tried);
    assert!(!late.complete() && late.earlier.is_none(), "the last pass came after the course was extended");
    let part = Progress::of(&extended(1), &tried[..3]);
    assert!(!part.complete(), "under way: goes on with the course as it is now");
    let all = attempts(&[("a", 70.0), ("a", 70.0), ("b", 70.0), ("b", 70.0), ("c", 70.0), ("c", 70.0)]);
    let all = Progress::of(&extended(2), &all);
    assert!(all.complete() && all.earlier.is_none(), "the current revision comes first");
}
