//! What was assigned, and how far somebody has come with it.
//!
//! Pure: attempts and the moment go in. Only scored attempts count.

#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::sync::OnceLock;

use time::OffsetDateTime;

use super::Moment;
use super::progress::{Concern, Course, Progress, ScoredAttempt, StepState};
use crate::ids::{AssignmentId, PersonId, SessionId};
use crate::{count_u32, due};

/// What is due within as many seconds is due soon.
pub const SOON_S: i64 = 7 * 86_400;
/// An assignment without a date is due as many seconds after it was made.
const UNDATED_S: i64 = 14 * 86_400;

/// What is to be trained.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AssignmentTask {
    /// An exercise, by its id: passed once.
    Exercise(String),
    /// A course, by its id: every exercise mastered.
    Course(String),
}

impl AssignmentTask {
    /// Whether an exercise belongs to it.
    fn asks_for(&self, exercise: &str, taught: &[TaughtCourse]) -> bool {
        match self {
            Self::Exercise(id) => id == exercise,
            Self::Course(id) => taught
                .iter()
                .any(|taught| taught.id == *id && taught.course.steps.iter().any(|step| step.exercise == exercise)),
        }
    }
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
    /// The trainee to whom alone it is assigned; none where it is a cohort's.
    pub person_id: Option<PersonId>,
    /// Since when.
    pub made_at: Moment,
    /// Only attempts since then count; otherwise what was passed or mastered before is done already.
    pub since_only: bool,
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
        /// Of a course, how much of it is mastered.
        mastered: Option<MasteredShare>,
    },
    /// Other exercises come first.
    Locked {
        /// Their titles.
        missing: Vec<String>,
    },
    /// No attempt is left, and none passed.
    Spent,
}

/// How much of a course is mastered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MasteredShare {
    /// Exercises that are.
    pub exercises: usize,
    /// All of its exercises.
    pub of: usize,
}

/// Attempts at which somebody who teaches was there, as they have confirmed.
pub type SupervisedSessions = BTreeSet<SessionId>;

/// The attempts of one trainee, and by them their progress in each course of the school, judged when it is first asked for.
#[derive(Debug)]
pub struct AttemptHistory<'a> {
    taught: &'a [TaughtCourse],
    attempts: &'a [ScoredAttempt],
    now: Moment,
    judged: Vec<OnceLock<Progress>>,
}

impl<'a> AttemptHistory<'a> {
    /// The attempts of a trainee, in any order.
    #[must_use]
    pub fn new(taught: &'a [TaughtCourse], attempts: &'a [ScoredAttempt], now: Moment) -> Self {
        Self { taught, attempts, now, judged: taught.iter().map(|_| OnceLock::new()).collect() }
    }

    /// Progress in a course, by its index among those taught.
    #[must_use]
    pub fn in_course(&self, course: usize) -> &Progress {
        self.judged[course].get_or_init(|| Progress::of(&self.taught[course].course, self.attempts, self.now.to_utc()))
    }

    /// The course tried last, the first of them where none was; none where none is taught.
    #[must_use]
    pub fn main_course(&self) -> Option<usize> {
        (0..self.taught.len()).min_by_key(|course| Reverse(self.in_course(*course).last_at))
    }

    /// What a trainee must master before an exercise; nothing where one course that has it opens it, or none has it.
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

    /// The attempts that count towards an assignment.
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

    /// The attempts at what was assigned, since it was, that only lack a confirmation.
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

/// An assignment, how far somebody has come with it, and how it stands to its date.
#[derive(Clone, Debug, PartialEq)]
pub struct AssignmentStanding {
    /// What was assigned.
    pub assigned: Assigned,
    /// How far they have come.
    pub stage: AssignmentStage,
    /// It is due, and not done.
    pub overdue: bool,
    /// Attempts at it that count, those after it was done among them.
    pub attempts: usize,
    /// The best score among them, 0–100; none of a course.
    pub best: Option<f64>,
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

    /// There is something left to do, and its time has come: it is due within a week or late, or has no date and was made two weeks ago.
    #[must_use]
    pub fn is_pressing(&self, now: Moment) -> bool {
        let Assigned { due_at, made_at, .. } = self.assigned;
        self.is_open() && due_at.map_or(made_at.plus_s(UNDATED_S) <= now, |due| due <= now.plus_s(SOON_S))
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
    // The first that did it: what was passed before is done before it could be late.
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

/// The worry about somebody without an attempt; none where nothing presses.
#[must_use]
pub fn find_not_started<'a>(
    mut standings: impl Iterator<Item = &'a AssignmentStanding>,
    now: Moment,
) -> Option<Concern> {
    let due = standings.find(|standing| standing.is_pressing(now))?;
    Some(Concern::NotStarted { title: due.assigned.title.clone() })
}

/// How those stand to whom something was assigned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AssignmentTally {
    /// Who have done it.
    pub done: usize,
    /// Who have not, after it was due for them.
    pub late: usize,
    /// All of them.
    pub of: usize,
}

impl AssignmentTally {
    /// Counts.
    #[must_use]
    pub fn of<'a>(standings: impl Iterator<Item = &'a AssignmentStanding>) -> Self {
        standings.fold(Self::default(), |tally, standing| Self {
            done: tally.done + usize::from(matches!(standing.stage, AssignmentStage::Done { .. })),
            late: tally.late + usize::from(standing.overdue),
            of: tally.of + 1,
        })
    }
}

/// Sorts what is to be done before what is done, and by date, those without one last.
pub fn sort(standings: &mut [AssignmentStanding]) {
    standings.sort_by_key(|standing| {
        let due = standing.assigned.due_at;
        (!standing.is_open(), due.is_none(), due, standing.assigned.made_at)
    });
}
