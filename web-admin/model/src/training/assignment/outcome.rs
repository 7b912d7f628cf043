//! The grade of an assignment: that of its best attempt.

use super::{Assigned, AttemptHistory, SupervisedSessions};
use crate::Moment;
use crate::ids::SessionId;
use crate::training::progress::ScoredAttempt;

/// The grade of a trainee in an assignment of an exercise.
#[derive(Clone, Debug, PartialEq)]
pub enum AssignmentOutcome {
    /// No attempt counts.
    None,
    /// An attempt would count if its supervision were confirmed.
    Unconfirmed(SessionId),
    /// The attempt with the best score, the first of several.
    Graded(ScoredAttempt),
}

impl AssignmentOutcome {
    /// Computes the grade from the attempts of one trainee. Of the attempts since the assignment was
    /// made, those beyond the limit do not count.
    #[must_use]
    pub fn of(assigned: &Assigned, tried: &AttemptHistory<'_>, supervised: &SupervisedSessions) -> Self {
        let counting = tried.counting(assigned, supervised);
        let mut at_it: Vec<_> =
            counting.iter().filter(|attempt| assigned.task.asks_for(&attempt.exercise, tried.taught)).collect();
        at_it.sort_by_key(|attempt| (attempt.at, attempt.session));
        let is_before = |attempt: &&ScoredAttempt| Moment::from(attempt.at) < assigned.made_at;
        let limit = assigned.attempt_limit.map_or(usize::MAX, |limit| limit as usize);
        at_it.truncate(at_it.partition_point(is_before).saturating_add(limit));
        // The last of equal maxima is returned, so they are compared from the end.
        let best = at_it.into_iter().rev().max_by(|a, b| a.score.total_cmp(&b.score));
        match best {
            Some(best) => Self::Graded(best.clone()),
            None => tried.unconfirmed(assigned, supervised).pop().map_or(Self::None, Self::Unconfirmed),
        }
    }
}
