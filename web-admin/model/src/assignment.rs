//! Assignments and a trainee's progress in them.
//!
//! Pure functions of the attempts and the current time. Only scored attempts count.

use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::sync::OnceLock;

use time::OffsetDateTime;

use super::Moment;
use super::progress::{Course, Progress, ScoredAttempt, StepState};
use crate::ids::{AssignmentId, PersonId, SessionId};
use crate::{count_u32, due};

/// The task of an assignment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AssignmentTask {
    /// An exercise, by its id: to be passed once.
    Exercise(String),
    /// A course, by its id: all exercises to be mastered.
    Course(String),
}

impl AssignmentTask {
    /// Returns whether an exercise belongs to the task.
    fn asks_for(&self, exercise: &str, taught: &[TaughtCourse]) -> bool {
        match self {
            Self::Exercise(id) => id == exercise,
            Self::Course(id) => taught
                .iter()
                .any(|taught| taught.id == *id && taught.course.steps.iter().any(|step| step.exercise == exercise)),
        }
    }
}

/// An assignment, as it applies to one trainee.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Assigned {
    /// Id.
    pub id: AssignmentId,
    /// Exercise or course to train.
    pub task: AssignmentTask,
    /// Title of the exercise or course.
    pub title: String,
    /// The trainee of an individual assignment; `None` for a cohort's assignment.
    pub person_id: Option<PersonId>,
    /// Time at which it was made.
    pub made_at: Moment,
    /// Only attempts made after the assignment count; otherwise earlier passes and mastery count,
    /// too.
    pub since_only: bool,
    /// Due date, including the trainee's extension.
    pub due_at: Option<Moment>,
    /// Length of the trainee's extension, in days; 0 without one.
    pub extended_days: i64,
    /// Maximum number of attempts that count, from the first.
    pub attempt_limit: Option<u32>,
    /// Attempts must be supervised by an instructor.
    pub supervised: bool,
    /// Time zone of the due date.
    pub time_zone: String,
}

/// Progress of a trainee in an assignment.
#[derive(Clone, Debug, PartialEq)]
pub enum AssignmentStage {
    /// The assignment is done.
    Done {
        /// Time of the attempt that completed it.
        on: OffsetDateTime,
        /// It was completed after the due date.
        late: bool,
    },
    /// The assignment can be done now.
    Open {
        /// Number of remaining attempts, if they are limited.
        left: Option<u32>,
        /// For a course: number of mastered exercises.
        mastered: Option<MasteredShare>,
    },
    /// Other exercises must be mastered first.
    Locked {
        /// Titles of these exercises.
        missing: Vec<String>,
    },
    /// All attempts were used, and none passed.
    Spent,
}

/// Number of mastered exercises of a course.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MasteredShare {
    /// Number of mastered exercises.
    pub exercises: usize,
    /// Total number of exercises.
    pub of: usize,
}

/// Attempts with a confirmed supervision.
pub type SupervisedSessions = BTreeSet<SessionId>;

/// The attempts of one trainee and the trainee's progress in each course of the school, which is
/// computed on first use.
#[derive(Debug)]
pub struct AttemptHistory<'a> {
    taught: &'a [TaughtCourse],
    attempts: &'a [ScoredAttempt],
    now: Moment,
    judged: Vec<OnceLock<Progress>>,
}

impl<'a> AttemptHistory<'a> {
    /// Makes the history from a trainee's attempts, in any order.
    #[must_use]
    pub fn new(taught: &'a [TaughtCourse], attempts: &'a [ScoredAttempt], now: Moment) -> Self {
        Self { taught, attempts, now, judged: taught.iter().map(|_| OnceLock::new()).collect() }
    }

    /// Returns the progress in a course, by its index among the taught courses.
    #[must_use]
    pub fn in_course(&self, course: usize) -> &Progress {
        self.judged[course].get_or_init(|| Progress::of(&self.taught[course].course, self.attempts, self.now.to_utc()))
    }

    /// Returns the course with the latest attempt, or the first course if there are no attempts.
    /// `None` if no course is taught.
    #[must_use]
    pub fn main_course(&self) -> Option<usize> {
        (0..self.taught.len()).min_by_key(|course| Reverse(self.in_course(*course).last_at))
    }

    /// Returns the titles of the exercises to be mastered before an exercise. Empty if the exercise
    /// is open in at least one course, or belongs to none.
    #[must_use]
    pub fn missing_before(&self, exercise: &str) -> Vec<String> {
        let mut first = Vec::new();
        for (course, taught) in self.taught.iter().enumerate() {
            let Some(step) = taught.course.steps.iter().position(|step| step.exercise == exercise) else { continue };
            match &self.in_course(course).steps[step].state {
                StepState::Locked { missing } if first.is_empty() => first.clone_from(missing),
                StepState::Locked { .. } => {}
                _ => return Vec::new(),
            }
        }
        first
    }

    /// Returns the attempts that count towards an assignment.
    fn counting(&self, assigned: &Assigned, supervised: &SupervisedSessions) -> Cow<'_, [ScoredAttempt]> {
        if !assigned.supervised && !assigned.since_only {
            return Cow::Borrowed(self.attempts);
        }
        let counts = |attempt: &&ScoredAttempt| {
            (!assigned.supervised || supervised.contains(&attempt.session))
                && (!assigned.since_only || Moment::from(attempt.at) >= assigned.made_at)
        };
        Cow::Owned(self.attempts.iter().filter(counts).cloned().collect())
    }

    /// Returns the attempts at an assignment's exercises since it was made that do not count only
    /// because their supervision is not confirmed.
    fn unconfirmed(&self, assigned: &Assigned, supervised: &SupervisedSessions) -> Vec<SessionId> {
        let lacks = |attempt: &&ScoredAttempt| {
            assigned.supervised
                && !supervised.contains(&attempt.session)
                && Moment::from(attempt.at) >= assigned.made_at
                && assigned.task.asks_for(&attempt.exercise, self.taught)
        };
        self.attempts.iter().filter(lacks).map(|attempt| attempt.session).collect()
    }
}

/// An assignment with a trainee's progress.
#[derive(Clone, Debug, PartialEq)]
pub struct AssignmentStanding {
    /// The assignment.
    pub assigned: Assigned,
    /// Progress.
    pub stage: AssignmentStage,
    /// It is past the due date and not done.
    pub overdue: bool,
    /// Number of attempts that count, including those after it was done.
    pub attempts: usize,
    /// Best score among them, 0–100; `None` for a course.
    pub best: Option<f64>,
    /// Attempts that do not count because their supervision is not confirmed.
    pub unconfirmed: Vec<SessionId>,
}

/// A course with its id.
#[derive(Clone, Debug, PartialEq)]
pub struct TaughtCourse {
    /// Id of the course.
    pub id: String,
    /// Steps and mastery rule.
    pub course: Course,
}

impl AssignmentStanding {
    /// Computes the progress from the attempts of one trainee.
    #[must_use]
    pub fn of(assigned: Assigned, tried: &AttemptHistory<'_>, supervised: &SupervisedSessions) -> Self {
        let counting = tried.counting(&assigned, supervised);
        let stage = match &assigned.task {
            AssignmentTask::Exercise(exercise) => {
                exercise_stage(&assigned, exercise, &counting, || tried.missing_before(exercise))
            }
            AssignmentTask::Course(course) => match tried.taught.iter().position(|taught| taught.id == *course) {
                Some(course) => {
                    let progress = match &counting {
                        Cow::Borrowed(_) => Cow::Borrowed(tried.in_course(course)),
                        Cow::Owned(some) => {
                            Cow::Owned(Progress::of(&tried.taught[course].course, some, tried.now.to_utc()))
                        }
                    };
                    course_stage(&assigned, &progress)
                }
                None => AssignmentStage::Open { left: None, mastered: None },
            },
        };
        let at_it = || counting.iter().filter(|attempt| assigned.task.asks_for(&attempt.exercise, tried.taught));
        let attempts = at_it().count();
        let best = match &assigned.task {
            AssignmentTask::Exercise(_) => at_it().map(|attempt| attempt.score).reduce(f64::max),
            AssignmentTask::Course(_) => None,
        };
        let done = matches!(stage, AssignmentStage::Done { .. });
        let overdue = !done && assigned.due_at.is_some_and(|due| due::is_past(due, tried.now));
        let unconfirmed = if done { Vec::new() } else { tried.unconfirmed(&assigned, supervised) };
        Self { assigned, stage, overdue, attempts, best, unconfirmed }
    }

    /// Returns whether the trainee can still complete it.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        matches!(self.stage, AssignmentStage::Open { .. } | AssignmentStage::Locked { .. })
    }
}

fn late(on: OffsetDateTime, assigned: &Assigned) -> bool {
    assigned.due_at.is_some_and(|due| due::is_past(due, Moment::from(on)))
}

fn exercise_stage(
    assigned: &Assigned,
    exercise: &str,
    counting: &[ScoredAttempt],
    missing: impl FnOnce() -> Vec<String>,
) -> AssignmentStage {
    let mut at_it: Vec<&ScoredAttempt> = counting.iter().filter(|attempt| *attempt.exercise == *exercise).collect();
    at_it.sort_by_key(|attempt| attempt.at);
    let (before, since) = at_it.split_at(at_it.partition_point(|attempt| Moment::from(attempt.at) < assigned.made_at));
    let limit = assigned.attempt_limit.map_or(usize::MAX, |limit| limit as usize);
    // The first pass decides: an exercise passed before the assignment is never late.
    if let Some(passed) = before.iter().chain(since.iter().take(limit)).find(|attempt| attempt.passed) {
        return AssignmentStage::Done { on: passed.at, late: late(passed.at, assigned) };
    }
    if since.len() >= limit {
        return AssignmentStage::Spent;
    }
    match missing() {
        missing if missing.is_empty() => {
            let used = count_u32(since.len());
            let left = assigned.attempt_limit.map(|limit| limit.saturating_sub(used));
            AssignmentStage::Open { left, mastered: None }
        }
        missing => AssignmentStage::Locked { missing },
    }
}

fn course_stage(assigned: &Assigned, progress: &Progress) -> AssignmentStage {
    let mastered = progress.steps.iter().map(|step| match step.state {
        StepState::Mastered { on } | StepState::Regressing { on, .. } => Some(on),
        StepState::Open { .. } | StepState::Locked { .. } => None,
    });
    let (of, mastered) = (progress.steps.len(), mastered.flatten().collect::<Vec<_>>());
    match mastered.iter().max() {
        Some(on) if mastered.len() == of => AssignmentStage::Done { on: *on, late: late(*on, assigned) },
        _ => {
            let mastered = MasteredShare { exercises: mastered.len(), of };
            AssignmentStage::Open { left: None, mastered: Some(mastered) }
        }
    }
}

/// Counts of the trainees of an assignment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AssignmentTally {
    /// Trainees who completed it.
    pub done: usize,
    /// Trainees who have not completed it by their due date.
    pub late: usize,
    /// All trainees.
    pub of: usize,
}

impl AssignmentTally {
    /// Counts the trainees of an assignment.
    #[must_use]
    pub fn of<'a>(standings: impl Iterator<Item = &'a AssignmentStanding>) -> Self {
        standings.fold(Self::default(), |tally, standing| Self {
            done: tally.done + usize::from(matches!(standing.stage, AssignmentStage::Done { .. })),
            late: tally.late + usize::from(standing.overdue),
            of: tally.of + 1,
        })
    }
}

/// Sorts open assignments before the others, and each by due date, those without one last.
pub fn sort(standings: &mut [AssignmentStanding]) {
    standings.sort_by_key(|standing| {
        let due = standing.assigned.due_at;
        (!standing.is_open(), due.is_none(), due, standing.assigned.made_at)
    });
}

#[cfg(test)]
mod tests {
    //! A course with two exercises, of which the second requires the first; one pass is mastery.
    //! The tests check that attempts before the assignment do not count, that limits are kept, and
    //! that locked exercises are reported as locked.

    use time::Duration;
    use time::macros::datetime;

    use super::*;
    use crate::progress::{CourseStep, Mastery};

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
            course: Course { steps: vec![step("a", &[]), step("b", &["a"])], rule },
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

    /// Judges attempts given by exercise, age in hours, and pass.
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
        assert_eq!(
            (nobody.stage, nobody.unconfirmed.len()),
            (AssignmentStage::Open { left: Some(2), mastered: None }, 2)
        );
        let one = judge(exercise("a"), &[seen]);
        assert_eq!(
            (one.stage, one.unconfirmed),
            (AssignmentStage::Open { left: Some(1), mastered: None }, vec![alone])
        );
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
    fn a_course_is_done_when_all_of_it_is_mastered_and_says_how_much_is() {
        let course = |since_only, tried: &[(&str, i64, bool)]| {
            let asked = Assigned { since_only, ..assigned(AssignmentTask::Course("course".to_owned()), None) };
            judge(asked, tried).stage
        };
        let share =
            |exercises| AssignmentStage::Open { left: None, mastered: Some(MasteredShare { exercises, of: 2 }) };
        assert_eq!(course(false, &[("a", 90, true)]), share(1));
        let both = [("a", 90, true), ("b", 4, true)];
        assert_eq!(course(false, &both), AssignmentStage::Done { on: NOW - Duration::hours(4), late: false });
        assert_eq!(course(true, &both), share(1), "the first is from before");
    }

    #[test]
    fn what_was_passed_before_is_done_and_never_late_where_it_counts() {
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
        let order: Vec<_> =
            list.iter().map(|standing| (standing.is_open(), standing.assigned.due_at.is_some())).collect();
        assert_eq!(order, [(true, true), (true, false), (false, true)]);
    }
}
