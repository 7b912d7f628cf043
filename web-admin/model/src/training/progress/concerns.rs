//! Reasons to help a trainee.

use time::{Duration, OffsetDateTime};

use super::{Course, Progress, ScoredAttempt, StepState};

/// Number of consecutive fails on the current exercise that indicates a need for help.
pub const STUCK_FAILS: usize = 3;
/// Number of days without an attempt that indicates a need for help.
pub const INACTIVE_DAYS: i64 = 14;
/// Drop of the mean score between two runs of [`DECLINE_RUN`] attempts that indicates a need for
/// help, in points.
pub const DECLINE_POINTS: f64 = 10.0;
/// Number of attempts in each of the two runs whose means are compared.
pub const DECLINE_RUN: usize = 3;

/// Reason why a trainee may need help.
#[derive(Clone, Debug, PartialEq)]
pub enum Concern {
    /// Consecutive fails on the current exercise.
    Stuck {
        /// Title of the exercise.
        title: String,
        /// Number of fails.
        fails: usize,
        /// Last score, 0–100.
        last_score: f64,
    },
    /// Declining scores on the latest exercise.
    Declining {
        /// Title of the exercise.
        title: String,
        /// Mean of the earlier run, 0–100.
        from: f64,
        /// Mean of the later run, 0–100.
        to: f64,
    },
    /// Too many fails on an exercise since competence was shown.
    Regressing {
        /// Title of the exercise.
        title: String,
        /// Time of the attempt by which competence was lost.
        since: OffsetDateTime,
    },
    /// No attempt for a long time.
    Inactive {
        /// Whole days since the last attempt.
        days: i64,
    },
    /// No attempt at all, and something is due.
    NotStarted {
        /// Title of what is due first.
        title: String,
    },
}

impl Concern {
    /// Returns the title of the exercise concerned, if there is one.
    #[must_use]
    pub fn exercise(&self) -> Option<&str> {
        match self {
            Self::Stuck { title, .. } | Self::Declining { title, .. } | Self::Regressing { title, .. } => Some(title),
            Self::Inactive { .. } | Self::NotStarted { .. } => None,
        }
    }
}

pub(super) fn concerns(course: &Course, progress: &Progress, now: OffsetDateTime) -> Vec<Concern> {
    let Some(last_at) = progress.last_at else { return Vec::new() };
    let mut concerns = Vec::new();
    concerns.extend(stuck(course, progress));
    concerns.extend(regressing(course, progress));
    concerns.extend(declining(course, progress));
    let idle = now - last_at;
    if idle > Duration::days(INACTIVE_DAYS) && !progress.complete() {
        concerns.push(Concern::Inactive { days: idle.whole_days() });
    }
    concerns
}

fn stuck(course: &Course, progress: &Progress) -> Option<Concern> {
    let step = &progress.steps[progress.next?];
    let fails = step.straight_fails();
    let last_score = step.attempts.last()?.score;
    let title = course.steps[progress.next?].title.clone();
    (fails >= STUCK_FAILS).then_some(Concern::Stuck { title, fails, last_score })
}

/// Compares only attempts at the same exercise: lower initial scores on a harder one are not a
/// decline.
fn declining(course: &Course, progress: &Progress) -> Option<Concern> {
    let latest = (0..progress.steps.len()).max_by_key(|&i| progress.steps[i].attempts.last().map(|a| a.at))?;
    let attempts = &progress.steps[latest].attempts;
    let later = attempts.len().checked_sub(DECLINE_RUN)?;
    let earlier = later.checked_sub(DECLINE_RUN)?;
    let (from, to) = (mean(&attempts[earlier..later]), mean(&attempts[later..]));
    let title = course.steps[latest].title.clone();
    (from - to >= DECLINE_POINTS).then_some(Concern::Declining { title, from, to })
}

fn mean(attempts: &[ScoredAttempt]) -> f64 {
    attempts.iter().map(|a| a.score).sum::<f64>() / attempts.len().max(1) as f64
}

fn regressing<'a>(course: &'a Course, progress: &'a Progress) -> impl Iterator<Item = Concern> + 'a {
    course.steps.iter().zip(&progress.steps).filter_map(|(step, done)| match done.state {
        StepState::Regressing { since, .. } => Some(Concern::Regressing { title: step.title.clone(), since }),
        _ => None,
    })
}
