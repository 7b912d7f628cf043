//! A course of two exercises, the second after the first, mastered by one pass. Fails when an attempt from before the
//! assignment does it, when a limit is not kept, or when somebody is sent to a locked exercise.

use time::Duration;
use time::macros::datetime;

use super::*;
use crate::training::progress::{CourseStep, Mastery};

const NOW: OffsetDateTime = datetime!(2026-05-20 12:00 UTC);
const OPEN: AssignmentStage = AssignmentStage::Open { left: None, mastered: None };

fn taught() -> Vec<TaughtCourse> {
    let step = |id: &str, before: &[&str]| CourseStep {
        exercise: id.to_owned(),
        title: id.to_uppercase(),
        prerequisites: before.iter().map(|b| (*b).to_owned()).collect(),
    };
    let rule = Mastery::Passes { passes: 1, of: 1 };
    vec![TaughtCourse {
        id: "course".to_owned(),
        course: Course { steps: vec![step("a", &[]), step("b", &["a"])], rule, earlier: Vec::new() },
    }]
}

fn assigned(task: AssignmentTask, limit: Option<u32>) -> Assigned {
    Assigned {
        id: AssignmentId::nil(),
        task,
        title: String::new(),
        person_id: None,
        made_at: Moment::from(NOW - Duration::days(2)),
        since_only: true,
        due_at: Some(Moment::from(NOW - Duration::hours(1))),
        extended_days: 0,
        attempt_limit: limit,
        supervised: false,
        time_zone: "UTC".to_owned(),
    }
}

fn standing(task: AssignmentTask, limit: Option<u32>, tried: &[(&str, i64, bool)]) -> AssignmentStanding {
    judge(assigned(task, limit), tried)
}

/// Attempts so many hours ago.
fn judge(assigned: Assigned, tried: &[(&str, i64, bool)]) -> AssignmentStanding {
    let attempt = |(exercise, hours, passed): &(&str, i64, bool)| ScoredAttempt {
        session: SessionId::nil(),
        exercise: (*exercise).into(),
        at: NOW - Duration::hours(*hours),
        score: 0.0,
        passed: *passed,
        revision: None,
    };
    let attempts: Vec<_> = tried.iter().map(attempt).collect();
    let taught = taught();
    let tried = AttemptHistory::new(&taught, &attempts, Moment::from(NOW));
    AssignmentStanding::of(assigned, &tried, &BTreeSet::new())
}

fn exercise(id: &str) -> AssignmentTask {
    AssignmentTask::Exercise(id.to_owned())
}

#[test]
fn only_a_pass_since_the_assignment_does_it() {
    let before = standing(exercise("a"), None, &[("a", 72, true), ("a", 10, false)]);
    assert_eq!((before.stage, before.overdue), (OPEN, true));
    let in_time = standing(exercise("a"), None, &[("a", 5, true), ("a", 10, false)]);
    assert_eq!(in_time.stage, AssignmentStage::Done { on: NOW - Duration::hours(5), late: false });
    let late = standing(exercise("a"), None, &[("a", 0, true)]);
    assert_eq!((late.stage, late.overdue), (AssignmentStage::Done { on: NOW, late: true }, false));
}

#[test]
fn a_limit_counts_attempts_from_the_first() {
    let tried = [("a", 10, false), ("a", 9, false), ("a", 8, true)];
    assert_eq!(standing(exercise("a"), Some(2), &tried).stage, AssignmentStage::Spent);
    assert_eq!(
        standing(exercise("a"), Some(3), &tried[..2]).stage,
        AssignmentStage::Open { left: Some(1), mastered: None }
    );
    assert!(matches!(standing(exercise("a"), Some(3), &tried).stage, AssignmentStage::Done { .. }));
}

#[test]
fn under_supervision_only_confirmed_attempts_count() {
    let [old, alone, seen] = [1, 2, 3].map(SessionId::from_u128);
    let attempt = |session, hours, passed| ScoredAttempt {
        session,
        exercise: "a".into(),
        at: NOW - Duration::hours(hours),
        score: 0.0,
        passed,
        revision: None,
    };
    let attempts = [attempt(old, 90, true), attempt(alone, 10, true), attempt(seen, 5, false)];
    let judge = |task, confirmed: &[SessionId]| {
        let supervised = confirmed.iter().copied().collect();
        let asked = Assigned { supervised: true, ..assigned(task, Some(2)) };
        AssignmentStanding::of(asked, &AttemptHistory::new(&taught(), &attempts, Moment::from(NOW)), &supervised)
    };
    let nobody = judge(exercise("a"), &[]);
    assert_eq!((nobody.stage, nobody.unconfirmed.len()), (AssignmentStage::Open { left: Some(2), mastered: None }, 2));
    let one = judge(exercise("a"), &[seen]);
    assert_eq!((one.stage, one.unconfirmed), (AssignmentStage::Open { left: Some(1), mastered: None }, vec![alone]));
    let done = judge(exercise("a"), &[seen, alone]);
    assert!(matches!(done.stage, AssignmentStage::Done { late: false, .. }) && done.unconfirmed.is_empty());
    let course = judge(AssignmentTask::Course("course".to_owned()), &[]);
    assert_eq!(course.unconfirmed, [alone, seen]);
}

#[test]
fn prerequisites_come_first() {
    assert_eq!(standing(exercise("b"), None, &[]).stage, AssignmentStage::Locked { missing: vec!["A".to_owned()] });
    assert_eq!(standing(exercise("b"), None, &[("a", 90, true)]).stage, OPEN);
    assert_eq!(standing(exercise("elsewhere"), None, &[]).stage, OPEN);
}

#[test]
fn course_assignment_is_done_when_every_exercise_is_mastered() {
    let course = |since_only, tried: &[(&str, i64, bool)]| {
        let asked = Assigned { since_only, ..assigned(AssignmentTask::Course("course".to_owned()), None) };
        judge(asked, tried).stage
    };
    let share = |exercises| AssignmentStage::Open { left: None, mastered: Some(MasteredShare { exercises, of: 2 }) };
    assert_eq!(course(false, &[("a", 90, true)]), share(1));
    let both = [("a", 90, true), ("b", 4, true)];
    assert_eq!(course(false, &both), AssignmentStage::Done { on: NOW - Duration::hours(4), late: false });
    assert_eq!(course(true, &both), share(1), "the first is from before");
}

#[test]
fn earlier_pass_completes_an_assignment_and_is_never_late() {
    let asked = Assigned { since_only: false, ..assigned(exercise("a"), Some(1)) };
    let before = judge(asked.clone(), &[("a", 72, true), ("a", 10, false)]);
    assert_eq!(before.stage, AssignmentStage::Done { on: NOW - Duration::hours(72), late: false });
    assert_eq!((before.overdue, before.attempts), (false, 2));
    let failed = judge(asked, &[("a", 72, false)]);
    let open = AssignmentStage::Open { left: Some(1), mastered: None };
    assert_eq!((failed.stage, failed.overdue), (open, true), "only attempts since then use the limit up");
}

#[test]
fn what_is_due_first_comes_first_and_what_is_done_last() {
    let mut list = vec![
        standing(exercise("a"), None, &[("a", 5, true)]),
        AssignmentStanding {
            assigned: Assigned { due_at: None, ..assigned(exercise("a"), None) },
            ..standing(exercise("a"), None, &[])
        },
        standing(exercise("a"), None, &[]),
    ];
    sort(&mut list);
    let order: Vec<_> = list.iter().map(|standing| (standing.is_open(), standing.assigned.due_at.is_some())).collect();
    assert_eq!(order, [(true, true), (true, false), (false, true)]);
}
