//! Assignments and a trainee's progress in them.
//!
//! Pure functions of the attempts and the current time. Only scored attempts count.

mod outcome;
#[cfg(test)]
mod tests;

pub use outcome::AssignmentOutcome;

use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::sync::OnceLock;

use time::OffsetDateTime;

use crate::ids::{AssignmentId, PersonId, SessionId};
use crate::training::due;
use crate::training::progress::{Course, Progress, ScoredAttempt, StepState};
use crate::{Moment, count_u32};

/// What is due within as many seconds is due soon.
pub const SOON_S: i64 = 7 * 86_400;

/// What is to be trained.
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
        self.judged[course].get_or_init(|| Progress::of(&self.taught[course].course, self.attempts))
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
                        Cow::Owned(some) => Cow::Owned(Progress::of(&tried.taught[course].course, some)),
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

    /// There is something left to do.
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
    if let (Some(_), Some(on)) = (&progress.earlier, progress.completed_on()) {
        return AssignmentStage::Done { on, late: late(on, assigned) };
    }
    match mastered.iter().max() {
        Some(on) if mastered.len() == of => AssignmentStage::Done { on: *on, late: late(*on, assigned) },
        _ => {
            let mastered = MasteredShare { exercises: mastered.len(), of };
            AssignmentStage::Open { left: None, mastered: Some(mastered) }
        }
    }
}

/// How those stand to whom something was assigned.
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
