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
        match find_best(&at_it) {
            Some(best) => Self::Graded(best.clone()),
            None => tried.unconfirmed(assigned, supervised).pop().map_or(Self::None, Self::Unconfirmed),
        }
    }

    /// Computes the grade of an exercise that is not assigned, from the attempts of one trainee.
    #[must_use]
    pub fn of_practice(attempts: &[ScoredAttempt], exercise: &str) -> Self {
        let mut at_it: Vec<_> = attempts.iter().filter(|attempt| &*attempt.exercise == exercise).collect();
        at_it.sort_by_key(|attempt| (attempt.at, attempt.session));
        find_best(&at_it).map_or(Self::None, |best| Self::Graded(best.clone()))
    }
}

/// Returns the attempt with the best score, the first of several, from attempts by time.
fn find_best<'a>(attempts: &[&'a ScoredAttempt]) -> Option<&'a ScoredAttempt> {
    // The last of equal maxima is returned, so they are compared from the end.
    attempts.iter().rev().copied().max_by(|a, b| a.score.total_cmp(&b.score))
}

#[cfg(test)]
mod tests {
    //! Checks which attempt is the grade of a trainee.

    use time::{Duration, OffsetDateTime};

    use super::*;

    const START: OffsetDateTime = OffsetDateTime::UNIX_EPOCH;

    fn attempt(number: u128, exercise: &str, score: f64) -> ScoredAttempt {
        let at = START + Duration::hours(number as i64);
        let session = SessionId::from_u128(number);
        ScoredAttempt { session, exercise: exercise.into(), at, score, passed: score > 60.0, revision: None }
    }

    #[test]
    fn practice_is_graded_by_the_first_best_attempt() {
        let attempts = [attempt(4, "a", 80.0), attempt(1, "a", 40.0), attempt(3, "a", 80.0), attempt(2, "b", 99.0)];
        let expected = AssignmentOutcome::Graded(attempts[2].clone());
        assert_eq!(AssignmentOutcome::of_practice(&attempts, "a"), expected);
        assert_eq!(AssignmentOutcome::of_practice(&attempts, "c"), AssignmentOutcome::None);
    }
}
