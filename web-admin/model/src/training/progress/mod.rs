//! A trainee's progress in a course, and the next exercise.
//!
//! Pure functions of the attempts. Only scored attempts count.

mod habits;
#[cfg(test)]
mod tests;

use std::sync::Arc;

pub use assessment::learning::{CurveRule, Mastery};
use assessment::learning::{LearningCurve, Reached};
pub use habits::{Habits, RubricHabit};
use time::OffsetDateTime;

use crate::ids::{RevisionId, SessionId};

/// A scored attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoredAttempt {
    /// Id of the session.
    pub session: SessionId,
    /// Id of the exercise, shared between the attempts at it.
    pub exercise: Arc<str>,
    /// Start time.
    pub at: OffsetDateTime,
    /// Effective score, 0–100.
    pub score: f64,
    /// Passed, by the effective grade.
    pub passed: bool,
    /// Revision of the exercise, if the school published it.
    pub revision: Option<RevisionId>,
}

/// An exercise of a course.
#[derive(Clone, Debug, PartialEq)]
pub struct CourseStep {
    /// Id of the exercise.
    pub exercise: String,
    /// Title shown to people.
    pub title: String,
    /// Ids of the exercises that must be mastered first.
    pub prerequisites: Vec<String>,
}

/// A course: exercises in order, and the mastery rule.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// Exercises, in order.
    pub steps: Vec<CourseStep>,
    /// Mastery rule.
    pub rule: Mastery,
    /// Its earlier revisions, the newest first: whoever mastered one while it was taught has mastered the course.
    pub earlier: Vec<EarlierCourse>,
}

/// A revision of a course that is not taught any more.
#[derive(Clone, Debug, PartialEq)]
pub struct EarlierCourse {
    /// Exercises in order.
    pub steps: Vec<CourseStep>,
    /// Mastery rule.
    pub rule: Mastery,
    /// SHA-256 of the document.
    pub sha256: String,
    /// When another revision replaced it.
    pub until: OffsetDateTime,
}

/// State of an exercise.
#[derive(Clone, Debug, PartialEq)]
pub enum StepState {
    /// The rule is met.
    Mastered {
        /// Time of the attempt that met it.
        on: OffsetDateTime,
    },
    /// The learning curve declared competence and has withdrawn it. Exercises opened by it stay
    /// open.
    Regressing {
        /// Time of the attempt that showed competence.
        on: OffsetDateTime,
        /// Time of the attempt that lost it.
        since: OffsetDateTime,
    },
    /// It can be practised and is not mastered yet.
    Open {
        /// Number of passes among the attempts considered by the rule.
        passes: u32,
    },
    /// Other exercises must be mastered first.
    Locked {
        /// Titles of these exercises.
        missing: Vec<String>,
    },
}

/// An exercise with a trainee's attempts at it.
#[derive(Clone, Debug, PartialEq)]
pub struct StepProgress {
    /// State.
    pub state: StepState,
    /// Scored attempts, in order of time.
    pub attempts: Vec<ScoredAttempt>,
    /// Learning curve over the attempts, if the rule uses one.
    pub curve: Option<LearningCurve>,
}

impl StepProgress {
    /// Returns whether each attempt passed, in order of time.
    #[must_use]
    pub fn passed(&self) -> Vec<bool> {
        passed(&self.attempts)
    }

    /// Returns the number of passed attempts.
    #[must_use]
    pub fn passes(&self) -> usize {
        self.attempts.iter().filter(|a| a.passed).count()
    }

    /// Returns the best score, 0–100.
    #[must_use]
    pub fn best(&self) -> Option<f64> {
        self.attempts.iter().map(|a| a.score).max_by(f64::total_cmp)
    }

    /// Returns whether the rule is met and the learning curve has not withdrawn it.
    #[must_use]
    pub fn mastered(&self) -> bool {
        matches!(self.state, StepState::Mastered { .. })
    }

    /// Returns whether the attempts were made with different revisions of the exercise, so that one
    /// curve mixes two tasks.
    #[must_use]
    pub fn mixes_revisions(&self) -> bool {
        self.attempts.windows(2).any(|pair| pair[0].revision != pair[1].revision)
    }
}

/// A trainee's progress in a course.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// One entry per step of the course, in order.
    pub steps: Vec<StepProgress>,
    /// Index of the next step. `None` if all exercises are mastered or none is open.
    pub next: Option<usize>,
    /// Time of the latest attempt at any exercise of the course.
    pub last_at: Option<OffsetDateTime>,
    /// The earlier revision that was mastered while it was taught, unless the current one is mastered too.
    pub earlier: Option<EarlierMastery>,
}

/// The mastery of an earlier revision of a course.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EarlierMastery {
    /// Which of the course's earlier revisions.
    pub revision: usize,
    /// Since when each of its exercises is mastered, in its order.
    pub exercises: Vec<OffsetDateTime>,
}

impl Progress {
    /// Computes the progress from attempts in any order.
    #[must_use]
    pub fn of(course: &Course, attempts: &[ScoredAttempt]) -> Self {
        // Attempts at one exercise are mostly adjacent, so that whole runs can be skipped at once.
        let runs: Vec<&[ScoredAttempt]> = attempts.chunk_by(|a, b| a.exercise == b.exercise).collect();
        let mut steps: Vec<StepProgress> = course.steps.iter().map(|step| tried(step, &runs, &course.rule)).collect();
        lock(course, &mut steps);
        let next = next(&steps);
        let last_at = steps.iter().filter_map(|s| s.attempts.last()).map(|a| a.at).max();
        let mut progress = Self { steps, next, last_at, earlier: None };
        if !progress.masters_all() {
            progress.earlier = find_earlier_mastery(course, &runs);
        }
        progress
    }

    /// Returns the number of mastered exercises.
    #[must_use]
    pub fn mastered(&self) -> usize {
        self.steps.iter().filter(|s| s.mastered()).count()
    }

    /// Returns the number of scored attempts at the course's exercises.
    #[must_use]
    pub fn attempts(&self) -> usize {
        self.steps.iter().map(|s| s.attempts.len()).sum()
    }

    /// The course is mastered: every exercise of it, or of an earlier revision while that one was taught.
    #[must_use]
    pub fn complete(&self) -> bool {
        self.earlier.is_some() || self.masters_all()
    }

    /// Since when the course is mastered.
    #[must_use]
    pub fn completed_on(&self) -> Option<OffsetDateTime> {
        let on = |step: &StepProgress| match step.state {
            StepState::Mastered { on } => Some(on),
            _ => None,
        };
        match &self.earlier {
            Some(earlier) => earlier.exercises.iter().max().copied(),
            None => self.masters_all().then(|| self.steps.iter().filter_map(on).max())?,
        }
    }

    /// The revision of the course to which the mastery refers, and its mastery, if it is an earlier one.
    #[must_use]
    pub fn earlier_in<'own, 'course>(
        &'own self,
        course: &'course Course,
    ) -> Option<(&'course EarlierCourse, &'own EarlierMastery)> {
        let mastery = self.earlier.as_ref()?;
        Some((&course.earlier[mastery.revision], mastery))
    }

    fn masters_all(&self) -> bool {
        !self.steps.is_empty() && self.mastered() == self.steps.len()
    }
}

/// The newest of the earlier revisions of which every exercise was mastered before it was replaced, and still is.
fn find_earlier_mastery(course: &Course, runs: &[&[ScoredAttempt]]) -> Option<EarlierMastery> {
    let judged = |earlier: &EarlierCourse| {
        let on = |step: &CourseStep| match tried(step, runs, &earlier.rule).state {
            StepState::Mastered { on } if on < earlier.until => Some(on),
            _ => None,
        };
        earlier.steps.iter().map(on).collect::<Option<Vec<_>>>().filter(|exercises| !exercises.is_empty())
    };
    let mut found = course.earlier.iter().enumerate();
    found.find_map(|(revision, earlier)| Some(EarlierMastery { revision, exercises: judged(earlier)? }))
}

/// A step with its attempts, judged as if nothing had to come before it.
fn tried(step: &CourseStep, runs: &[&[ScoredAttempt]], rule: &Mastery) -> StepProgress {
    let at_it = |run: &&&[ScoredAttempt]| run.first().is_some_and(|attempt| *attempt.exercise == step.exercise);
    let mut attempts: Vec<ScoredAttempt> = runs.iter().filter(at_it).copied().flatten().cloned().collect();
    attempts.sort_by_key(|a| a.at);
    let (reached, curve) = rule.judge(&passed(&attempts));
    let at = |attempt: usize| attempts[attempt].at;
    let state = match reached {
        Reached::Mastered { by } => StepState::Mastered { on: at(by) },
        Reached::Regressing { by, since } => StepState::Regressing { on: at(by), since: at(since) },
        Reached::Open { passes } => StepState::Open { passes },
    };
    StepProgress { state, attempts, curve }
}

fn passed(attempts: &[ScoredAttempt]) -> Vec<bool> {
    attempts.iter().map(|attempt| attempt.passed).collect()
}

/// Locks open steps with unmastered prerequisites. A prerequisite outside the course is ignored,
/// because it cannot be mastered in this course.
fn lock(course: &Course, steps: &mut [StepProgress]) {
    let unmet: Vec<(&str, &str)> = course
        .steps
        .iter()
        .zip(steps.iter())
        .filter(|(_, progress)| matches!(progress.state, StepState::Open { .. }))
        .map(|(step, _)| (step.exercise.as_str(), step.title.as_str()))
        .collect();
    for (step, progress) in course.steps.iter().zip(steps) {
        let asked = |id: &str| step.prerequisites.iter().any(|p| p == id);
        let missing: Vec<String> = unmet.iter().filter(|(id, _)| asked(id)).map(|(_, t)| (*t).to_owned()).collect();
        if matches!(progress.state, StepState::Open { .. }) && !missing.is_empty() {
            progress.state = StepState::Locked { missing };
        }
    }
}

/// Returns the first step that is regressing, or else the first that is open.
fn next(steps: &[StepProgress]) -> Option<usize> {
    let first = |wanted: fn(&StepState) -> bool| steps.iter().position(|s| wanted(&s.state));
    first(|s| matches!(s, StepState::Regressing { .. })).or_else(|| first(|s| matches!(s, StepState::Open { .. })))
}
