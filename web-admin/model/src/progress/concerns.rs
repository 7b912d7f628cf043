//! Reasons to help somebody.

use time::{Duration, OffsetDateTime};

use super::{Course, Progress, ScoredAttempt, StepState};

/// Straight fails on the current exercise that call for help.
pub const STUCK_FAILS: usize = 3;
/// Days without an attempt that call for help.
pub const INACTIVE_DAYS: i64 = 14;
/// Drop of the mean score between two runs of [`DECLINE_RUN`] attempts that calls for help, in points.
pub const DECLINE_POINTS: f64 = 10.0;
/// Attempts in each of the two runs whose means are compared.
pub const DECLINE_RUN: usize = 3;

/// Why somebody may need help.
#[derive(Clone, Debug, PartialEq)]
pub enum Concern {
    /// Straight fails on the current exercise.
    Stuck {
        /// The exercise's title.
        title: String,
        /// How many.
        fails: usize,
        /// The last score, 0–100.
        last_score: f64,
    },
    /// Scores on the latest exercise fall.
    Declining {
        /// The exercise's title.
        title: String,
        /// Mean of the earlier run, 0–100.
        from: f64,
        /// Mean of the later run, 0–100.
        to: f64,
    },
    /// Competence was shown on an exercise, and too many attempts have failed since.
    Regressing {
        /// The exercise's title.
        title: String,
        /// Since the attempt of this moment.
        since: OffsetDateTime,
    },
    /// No attempt for long.
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
    /// Title of the exercise that it is about, if it is about one.
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

/// Compares only attempts on one exercise: a harder one begins with lower scores, and that is no decline.
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
