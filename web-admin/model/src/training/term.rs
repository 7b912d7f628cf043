//! Terms of a school, and what the trainees of a cohort have reached in a term.

use time::{Duration, OffsetDateTime};

use crate::ids::{CohortId, TermId};
use crate::surveys::groups::LEAST;
use crate::training::progress::{Course, Progress, ScoredAttempt, StepState};
use crate::{Moment, count_u32};

/// Weeks of a term that are shown.
pub const MOST_WEEKS: u32 = 26;
/// Weeks without practice that are a pause, unless others are asked for.
pub const USUAL_PAUSE_WEEKS: u32 = 2;

/// A term.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct Term {
    /// Id.
    pub id: TermId,
    /// Name, unique in the school.
    pub name: String,
    /// First day in the school's time zone, as 2026-10-12.
    pub starts_on: String,
    /// When that day begins.
    pub starts_at: Moment,
    /// Number of cohorts that belong to it.
    pub cohorts: i64,
}

/// A cohort and its term.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct CohortTerm {
    /// Id of the cohort.
    pub cohort_id: CohortId,
    /// Its name.
    pub cohort: String,
    /// Id of the term.
    pub term_id: TermId,
    /// Its name.
    pub term: String,
    /// When it begins.
    pub starts_at: Moment,
}

impl CohortTerm {
    /// Returns the current week of the term, from 1 to [`MOST_WEEKS`]; 1 before the term.
    #[must_use]
    pub fn week(&self, now: Moment) -> u32 {
        let week = (now.to_utc() - self.starts_at.to_utc()).whole_weeks() + 1;
        count_u32(week.clamp(1, i64::from(MOST_WEEKS)))
    }

    /// Returns the cohort of a year earlier, the closest of those whose term began ten to fourteen
    /// months before.
    #[must_use]
    pub fn find_year_before<'a>(&self, others: &'a [Self]) -> Option<&'a Self> {
        let days = |other: &Self| (self.starts_at.to_utc() - other.starts_at.to_utc()).whole_days();
        let year_before = others.iter().filter(|other| (300..=430).contains(&days(other)));
        year_before.min_by_key(|other| (days(other) - 365).abs())
    }
}

/// The part of a term that is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TermSpan {
    /// When the term begins.
    pub starts_at: OffsetDateTime,
    /// Number of weeks.
    pub weeks: u32,
    /// Weeks without practice that are a pause.
    pub pause_weeks: u32,
}

/// What the trainees of a cohort have reached in a course within a span.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TermFigures {
    /// Number of trainees.
    pub trainees: usize,
    /// Mastered exercises over all trainees and exercises, 0–1, at the end of each week.
    pub shares: Vec<f64>,
    /// For each exercise, the number of attempts up to mastery of each trainee who mastered it.
    pub to_mastery: Vec<Vec<f64>>,
    /// For each trainee who paused, the mean change of the score over their pauses, in points: the
    /// first attempt after a pause less the last one before it at the same exercise.
    pub pauses: Vec<f64>,
}

impl TermFigures {
    /// Computes the figures from the attempts of each trainee, in any order.
    #[must_use]
    pub fn of<'a>(course: &Course, trainees: impl Iterator<Item = &'a [ScoredAttempt]>, span: TermSpan) -> Self {
        let mut figures = Self { to_mastery: vec![Vec::new(); course.steps.len()], ..Self::default() };
        let mut mastered_in = vec![0_usize; span.weeks as usize];
        for attempts in trainees {
            let attempts = within(attempts, span);
            figures.trainees += 1;
            figures.pauses.extend(mean_change(&attempts, span.pause_weeks));
            for (step, counts) in Progress::of(course, &attempts).steps.iter().zip(&mut figures.to_mastery) {
                let StepState::Mastered { on } = step.state else { continue };
                counts.push(step.attempts.iter().filter(|attempt| attempt.at <= on).count() as f64);
                let week = count_u32((on - span.starts_at).whole_weeks().max(0)) as usize;
                if let Some(count) = mastered_in.get_mut(week) {
                    *count += 1;
                }
            }
        }
        let all = (figures.trainees * course.steps.len()).max(1) as f64;
        let so_far = mastered_in.iter().scan(0, |sum, count| {
            *sum += count;
            Some(*sum as f64 / all)
        });
        figures.shares = so_far.collect();
        figures
    }

    /// Removes the figures of fewer than [`LEAST`] people, for a reader who may not see these.
    #[must_use]
    pub fn without_small_groups(mut self) -> Self {
        if self.trainees < LEAST {
            self.shares.clear();
        }
        for counts in self.to_mastery.iter_mut().chain([&mut self.pauses]) {
            if counts.len() < LEAST {
                counts.clear();
            }
        }
        self
    }
}

/// Returns the attempts within a span, in order of time.
fn within(attempts: &[ScoredAttempt], span: TermSpan) -> Vec<ScoredAttempt> {
    let end = span.starts_at + Duration::weeks(i64::from(span.weeks));
    let mut found: Vec<_> = attempts.iter().filter(|of| of.at >= span.starts_at && of.at < end).cloned().collect();
    found.sort_by_key(|attempt| (attempt.at, attempt.session));
    found
}

/// Returns the mean change of the score over the pauses between attempts in order of time.
fn mean_change(attempts: &[ScoredAttempt], pause_weeks: u32) -> Option<f64> {
    let pause = Duration::weeks(i64::from(pause_weeks));
    let mut changes = Vec::new();
    for (place, pair) in attempts.windows(2).enumerate() {
        if pair[1].at - pair[0].at < pause {
            continue;
        }
        let before = attempts[..=place].iter().rev().find(|attempt| attempt.exercise == pair[1].exercise);
        changes.extend(before.map(|before| pair[1].score - before.score));
    }
    (!changes.is_empty()).then(|| changes.iter().sum::<f64>() / changes.len() as f64)
}

#[cfg(test)]
mod tests {
    //! Two trainees in a course of two exercises, mastered by one pass. Fails when an attempt before or after the span counts, or when a
    //! pause is measured across exercises.

    use time::macros::datetime;

    use super::*;
    use crate::ids::SessionId;
    use crate::training::progress::{CourseStep, Mastery};

    const START: OffsetDateTime = datetime!(2026-10-12 00:00 UTC);

    fn course() -> Course {
        let step =
            |id: &str| CourseStep { exercise: id.to_owned(), title: id.to_uppercase(), prerequisites: Vec::new() };
        let rule = Mastery::Passes { passes: 1, of: 1 };
        Course { steps: vec![step("a"), step("b")], rule, earlier: Vec::new() }
    }

    fn attempt(day: i64, exercise: &str, score: f64) -> ScoredAttempt {
        let at = START + Duration::days(day);
        let session = SessionId::from_u128(u128::from(day.unsigned_abs()));
        ScoredAttempt { session, exercise: exercise.into(), at, score, passed: score >= 60.0, revision: None }
    }

    fn figures(trainees: &[Vec<ScoredAttempt>], weeks: u32) -> TermFigures {
        let span = TermSpan { starts_at: START, weeks, pause_weeks: 2 };
        TermFigures::of(&course(), trainees.iter().map(Vec::as_slice), span)
    }

    #[test]
    fn mastery_counts_from_the_week_in_which_it_is_reached() {
        let first = vec![attempt(-3, "a", 90.0), attempt(1, "a", 40.0), attempt(8, "a", 70.0), attempt(20, "b", 70.0)];
        let second = vec![attempt(2, "b", 80.0)];
        let trainees = [first, second];
        let three = figures(&trainees, 3);
        assert_eq!((three.trainees, three.shares), (2, vec![0.25, 0.5, 0.75]));
        assert_eq!(three.to_mastery, [vec![2.0], vec![1.0, 1.0]]);
        assert_eq!(figures(&trainees, 1).shares, [0.25], "what came later is not known in the first week");
    }

    #[test]
    fn a_pause_compares_attempts_at_the_same_exercise() {
        let lost = vec![attempt(0, "a", 80.0), attempt(1, "b", 50.0), attempt(15, "a", 65.0), attempt(16, "b", 10.0)];
        let never = vec![attempt(0, "a", 80.0), attempt(13, "a", 10.0)];
        let other = vec![attempt(0, "a", 80.0), attempt(20, "b", 10.0)];
        assert_eq!(figures(&[lost, never, other], 4).pauses, [-15.0]);
    }

    #[test]
    fn figures_of_fewer_than_five_are_hidden() {
        let trainee = || vec![attempt(0, "a", 80.0)];
        let few = figures(&vec![trainee(); 4], 2).without_small_groups();
        assert_eq!((few.shares, few.to_mastery), (Vec::new(), vec![Vec::new(), Vec::new()]));
        let five = figures(&vec![trainee(); 5], 2).without_small_groups();
        assert_eq!((five.shares.len(), five.to_mastery[0].len()), (2, 5));
    }

    #[test]
    fn the_year_before_is_the_closest_to_a_year() {
        let term = |n: u128, days: i64| CohortTerm {
            cohort_id: CohortId::from_u128(n),
            cohort: String::new(),
            term_id: TermId::nil(),
            term: String::new(),
            starts_at: Moment::from(START - Duration::days(days)),
        };
        let now = term(1, 0);
        let others = [term(2, 180), term(3, 371), term(4, 420), term(5, 730)];
        assert_eq!(now.find_year_before(&others).map(|of| of.cohort_id), Some(CohortId::from_u128(3)));
        assert_eq!(now.find_year_before(&others[..1]), None);
        assert_eq!((now.week(Moment::from(START)), now.week(Moment::from(START + Duration::days(7)))), (1, 2));
        assert_eq!((now.week(Moment::from(START - Duration::days(9)))), 1);
    }
}
