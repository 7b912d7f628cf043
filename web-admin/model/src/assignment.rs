//! What was assigned, and how far somebody has come with it.
//!
//! Pure: attempts and the moment go in. Only scored attempts count.

use std::collections::BTreeSet;

use time::OffsetDateTime;

use super::Moment;
use super::progress::{Course, Progress, ScoredAttempt, StepState};
use crate::count_u32;
use crate::ids::{AssignmentId, SessionId};

/// What is to be trained.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AssignmentTask {
    /// An exercise, by its id: passed once since it was assigned.
    Exercise(String),
    /// A course, by its id: every exercise mastered, whenever.
    Course(String),
}

/// An assignment as it concerns one trainee.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Assigned {
    /// Its id.
    pub id: AssignmentId,
    /// What is to be trained.
    pub task: AssignmentTask,
    /// Title of the exercise or course.
    pub title: String,
    /// Since when.
    pub made_at: Moment,
    /// Until when, with their extension.
    pub due_at: Option<Moment>,
    /// Days by which it was extended for them; 0 for none.
    pub extended_days: i64,
    /// Attempts that count, from the first.
    pub attempt_limit: Option<u32>,
    /// Under an instructor's eyes.
    pub supervised: bool,
    /// The time zone in which it is due.
    pub time_zone: String,
}

/// How far somebody has come.
#[derive(Clone, Debug, PartialEq)]
pub enum AssignmentStage {
    /// It is done.
    Done {
        /// By the attempt of this moment.
        on: OffsetDateTime,
        /// After it was due.
        late: bool,
    },
    /// It can be done now.
    Open {
        /// Attempts that are left, where they are limited.
        left: Option<u32>,
    },
    /// Other exercises come first.
    Locked {
        /// Their titles.
        missing: Vec<String>,
    },
    /// No attempt is left, and none passed.
    Spent,
}

/// The attempts of one trainee, in any order.
#[derive(Clone, Copy, Debug)]
pub struct AttemptHistory<'a> {
    /// All of them.
    pub attempts: &'a [ScoredAttempt],
    /// Those at which somebody who teaches was there, as they have confirmed.
    pub supervised: &'a BTreeSet<SessionId>,
}

impl AttemptHistory<'_> {
    /// The attempts that count towards an assignment.
    fn counting(&self, assigned: &Assigned) -> Vec<ScoredAttempt> {
        let counts = |attempt: &&ScoredAttempt| !assigned.supervised || self.supervised.contains(&attempt.session);
        self.attempts.iter().filter(counts).cloned().collect()
    }

    /// The attempts at what was assigned, since it was, that only lack a confirmation.
    fn unconfirmed(&self, assigned: &Assigned, taught: &[TaughtCourse]) -> Vec<SessionId> {
        let asked = |exercise: &str| match &assigned.task {
            AssignmentTask::Exercise(id) => id == exercise,
            AssignmentTask::Course(id) => taught
                .iter()
                .any(|taught| taught.id == *id && taught.course.steps.iter().any(|step| step.exercise == exercise)),
        };
        let lacks = |attempt: &&ScoredAttempt| {
            assigned.supervised
                && !self.supervised.contains(&attempt.session)
                && Moment::from(attempt.at) >= assigned.made_at
                && asked(&attempt.exercise)
        };
        self.attempts.iter().filter(lacks).map(|attempt| attempt.session).collect()
    }
}

/// An assignment, how far somebody has come with it, and how it stands to its date.
#[derive(Clone, Debug, PartialEq)]
pub struct AssignmentStanding {
    /// What was assigned.
    pub assigned: Assigned,
    /// How far they have come.
    pub stage: AssignmentStage,
    /// It is due, and not done.
    pub overdue: bool,
    /// Attempts that do not count because nobody has confirmed that they were there.
    pub unconfirmed: Vec<SessionId>,
}

/// A course and its id.
#[derive(Clone, Debug, PartialEq)]
pub struct TaughtCourse {
    /// The course's id.
    pub id: String,
    /// Exercises and rule.
    pub course: Course,
}

impl AssignmentStanding {
    /// Judges the attempts of one trainee.
    #[must_use]
    pub fn of(assigned: Assigned, taught: &[TaughtCourse], tried: &AttemptHistory<'_>, now: Moment) -> Self {
        let stage = match &assigned.task {
            AssignmentTask::Exercise(exercise) => exercise_stage(&assigned, exercise, taught, tried, now),
            AssignmentTask::Course(course) => course_stage(&assigned, course, taught, &tried.counting(&assigned), now),
        };
        let done = matches!(stage, AssignmentStage::Done { .. });
        let overdue = !done && assigned.due_at.is_some_and(|due| due < now);
        let unconfirmed = if done { Vec::new() } else { tried.unconfirmed(&assigned, taught) };
        Self { assigned, stage, overdue, unconfirmed }
    }

    /// There is something left to do.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        matches!(self.stage, AssignmentStage::Open { .. } | AssignmentStage::Locked { .. })
    }
}

fn late(on: OffsetDateTime, assigned: &Assigned) -> bool {
    assigned.due_at.is_some_and(|due| due < Moment::from(on))
}

fn exercise_stage(
    assigned: &Assigned,
    exercise: &str,
    taught: &[TaughtCourse],
    tried: &AttemptHistory<'_>,
    now: Moment,
) -> AssignmentStage {
    let counting = tried.counting(assigned);
    let mut since: Vec<&ScoredAttempt> =
        counting.iter().filter(|a| *a.exercise == *exercise && Moment::from(a.at) >= assigned.made_at).collect();
    since.sort_by_key(|attempt| attempt.at);
    let limit = assigned.attempt_limit.map_or(usize::MAX, |limit| limit as usize);
    if let Some(passed) = since.iter().take(limit).find(|attempt| attempt.passed) {
        return AssignmentStage::Done { on: passed.at, late: late(passed.at, assigned) };
    }
    if since.len() >= limit {
        return AssignmentStage::Spent;
    }
    match missing(exercise, taught, tried.attempts, now) {
        missing if missing.is_empty() => {
            let used = count_u32(since.len());
            AssignmentStage::Open { left: assigned.attempt_limit.map(|limit| limit.saturating_sub(used)) }
        }
        missing => AssignmentStage::Locked { missing },
    }
}

/// What must be mastered before an exercise; nothing where one course that has it opens it, or none has it.
fn missing(exercise: &str, taught: &[TaughtCourse], attempts: &[ScoredAttempt], now: Moment) -> Vec<String> {
    let mut first = Vec::new();
    for taught in taught {
        let Some(step) = taught.course.steps.iter().position(|step| step.exercise == exercise) else { continue };
        match &Progress::of(&taught.course, attempts, now.to_utc()).steps[step].state {
            StepState::Locked { missing } if first.is_empty() => first.clone_from(missing),
            StepState::Locked { .. } => {}
            _ => return Vec::new(),
        }
    }
    first
}

fn course_stage(
    assigned: &Assigned,
    course: &str,
    taught: &[TaughtCourse],
    attempts: &[ScoredAttempt],
    now: Moment,
) -> AssignmentStage {
    let Some(taught) = taught.iter().find(|taught| taught.id == course) else {
        return AssignmentStage::Open { left: None };
    };
    let progress = Progress::of(&taught.course, attempts, now.to_utc());
    let mastered = progress.steps.iter().map(|step| match step.state {
        StepState::Mastered { on } | StepState::Regressing { on, .. } => Some(on),
        StepState::Open { .. } | StepState::Locked { .. } => None,
    });
    match mastered.collect::<Option<Vec<_>>>().and_then(|moments| moments.into_iter().max()) {
        Some(on) => AssignmentStage::Done { on, late: late(on, assigned) },
        None => AssignmentStage::Open { left: None },
    }
}

/// Sorts what is to be done before what is done, and by date, those without one last.
pub fn sort(standings: &mut [AssignmentStanding]) {
    standings.sort_by_key(|standing| {
        let due = standing.assigned.due_at;
        (!standing.is_open(), due.is_none(), due, standing.assigned.made_at)
    });
}

#[cfg(test)]
mod tests {
    //! A course of two exercises, the second after the first, mastered by one pass. Fails when an attempt from before the
    //! assignment does it, when a limit is not kept, or when somebody is sent to a locked exercise.

    use time::Duration;
    use time::macros::datetime;

    use super::*;
    use crate::progress::{CourseStep, Mastery};

    const NOW: OffsetDateTime = datetime!(2026-05-20 12:00 UTC);

    fn taught() -> Vec<TaughtCourse> {
        let step = |id: &str, before: &[&str]| CourseStep {
            exercise: id.to_owned(),
            title: id.to_uppercase(),
            prerequisites: before.iter().map(|b| (*b).to_owned()).collect(),
        };
        let rule = Mastery::Passes { passes: 1, of: 1 };
        vec![TaughtCourse {
            id: "course".to_owned(),
            course: Course { steps: vec![step("a", &[]), step("b", &["a"])], rule },
        }]
    }

    fn assigned(task: AssignmentTask, limit: Option<u32>) -> Assigned {
        Assigned {
            id: AssignmentId::nil(),
            task,
            title: String::new(),
            made_at: Moment::from(NOW - Duration::days(2)),
            due_at: Some(Moment::from(NOW - Duration::hours(1))),
            extended_days: 0,
            attempt_limit: limit,
            supervised: false,
            time_zone: "UTC".to_owned(),
        }
    }

    /// Attempts so many hours ago.
    fn standing(task: AssignmentTask, limit: Option<u32>, tried: &[(&str, i64, bool)]) -> AssignmentStanding {
        let attempt = |(exercise, hours, passed): &(&str, i64, bool)| ScoredAttempt {
            session: SessionId::nil(),
            exercise: (*exercise).into(),
            at: NOW - Duration::hours(*hours),
            score: 0.0,
            passed: *passed,
            revision: None,
        };
        let attempts: Vec<_> = tried.iter().map(attempt).collect();
        let tried = AttemptHistory { attempts: &attempts, supervised: &BTreeSet::new() };
        AssignmentStanding::of(assigned(task, limit), &taught(), &tried, Moment::from(NOW))
    }

    fn exercise(id: &str) -> AssignmentTask {
        AssignmentTask::Exercise(id.to_owned())
    }

    #[test]
    fn only_a_pass_since_the_assignment_does_it() {
        let before = standing(exercise("a"), None, &[("a", 72, true), ("a", 10, false)]);
        assert_eq!((before.stage, before.overdue), (AssignmentStage::Open { left: None }, true));
        let in_time = standing(exercise("a"), None, &[("a", 5, true), ("a", 10, false)]);
        assert_eq!(in_time.stage, AssignmentStage::Done { on: NOW - Duration::hours(5), late: false });
        let late = standing(exercise("a"), None, &[("a", 0, true)]);
        assert_eq!((late.stage, late.overdue), (AssignmentStage::Done { on: NOW, late: true }, false));
    }

    #[test]
    fn a_limit_counts_attempts_from_the_first() {
        let tried = [("a", 10, false), ("a", 9, false), ("a", 8, true)];
        assert_eq!(standing(exercise("a"), Some(2), &tried).stage, AssignmentStage::Spent);
        assert_eq!(standing(exercise("a"), Some(3), &tried[..2]).stage, AssignmentStage::Open { left: Some(1) });
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
            AssignmentStanding::of(
                asked,
                &taught(),
                &AttemptHistory { attempts: &attempts, supervised: &supervised },
                Moment::from(NOW),
            )
        };
        let nobody = judge(exercise("a"), &[]);
        assert_eq!((nobody.stage, nobody.unconfirmed.len()), (AssignmentStage::Open { left: Some(2) }, 2));
        let one = judge(exercise("a"), &[seen]);
        assert_eq!((one.stage, one.unconfirmed), (AssignmentStage::Open { left: Some(1) }, vec![alone]));
        let done = judge(exercise("a"), &[seen, alone]);
        assert!(matches!(done.stage, AssignmentStage::Done { late: false, .. }) && done.unconfirmed.is_empty());
        let course = judge(AssignmentTask::Course("course".to_owned()), &[]);
        assert_eq!(course.unconfirmed, [alone, seen]);
    }

    #[test]
    fn prerequisites_come_first() {
        assert_eq!(standing(exercise("b"), None, &[]).stage, AssignmentStage::Locked { missing: vec!["A".to_owned()] });
        assert_eq!(standing(exercise("b"), None, &[("a", 90, true)]).stage, AssignmentStage::Open { left: None });
        assert_eq!(standing(exercise("elsewhere"), None, &[]).stage, AssignmentStage::Open { left: None });
    }

    #[test]
    fn a_course_is_done_when_all_of_it_is_mastered() {
        let course = || AssignmentTask::Course("course".to_owned());
        assert_eq!(standing(course(), None, &[("a", 90, true)]).stage, AssignmentStage::Open { left: None });
        let done = standing(course(), None, &[("a", 90, true), ("b", 4, true)]).stage;
        assert_eq!(done, AssignmentStage::Done { on: NOW - Duration::hours(4), late: false });
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
        let order: Vec<_> =
            list.iter().map(|standing| (standing.is_open(), standing.assigned.due_at.is_some())).collect();
        assert_eq!(order, [(true, true), (true, false), (false, true)]);
    }
}
