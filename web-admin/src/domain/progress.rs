//! Where a trainee stands in a course, what comes next, and whether help is needed and why.
//!
//! Pure: attempts and the moment go in, words come out. Only scored attempts count.

use scene::MasteryRule;
use time::{Duration, OffsetDateTime};

/// Straight fails on the current exercise that call for help.
pub const STUCK_FAILS: usize = 3;
/// Days without an attempt that call for help.
pub const INACTIVE_DAYS: i64 = 14;
/// Drop of the mean score between two runs of [`DECLINE_RUN`] attempts that calls for help, in points.
pub const DECLINE_POINTS: f64 = 10.0;
/// Attempts in each of the two runs whose means are compared.
pub const DECLINE_RUN: usize = 3;

/// One scored attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct Attempt {
    /// The session's id, for a link.
    pub session: String,
    /// The exercise's id in its document.
    pub exercise: String,
    /// When it started.
    pub at: OffsetDateTime,
    /// 0–100.
    pub score: f64,
    /// Passed.
    pub passed: bool,
}

/// One exercise of a course.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The exercise's id in its document.
    pub exercise: String,
    /// Title shown to people.
    pub title: String,
    /// Ids of the exercises to master first.
    pub prerequisites: Vec<String>,
}

/// A course: exercises in order and the rule by which one counts as mastered.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// Exercises in order.
    pub steps: Vec<Step>,
    /// Mastery rule.
    pub rule: MasteryRule,
}

/// How far an exercise has come.
#[derive(Clone, Debug, PartialEq)]
pub enum StepState {
    /// The rule was met.
    Mastered {
        /// By the attempt of this moment.
        on: OffsetDateTime,
    },
    /// May be practised; not mastered yet.
    Open {
        /// Passes among the attempts that the rule looks at.
        passes: u32,
    },
    /// Another exercise comes first.
    Locked {
        /// Titles of the exercises still to master.
        missing: Vec<String>,
    },
    /// The rule is a learning curve, and those are not computed yet.
    Unjudged,
}

/// An exercise with what a trainee has done on it.
#[derive(Clone, Debug, PartialEq)]
pub struct StepProgress {
    /// How far it has come.
    pub state: StepState,
    /// Scored attempts in order of time.
    pub attempts: Vec<Attempt>,
}

impl StepProgress {
    /// Attempts passed.
    #[must_use]
    pub fn passes(&self) -> usize {
        self.attempts.iter().filter(|a| a.passed).count()
    }

    /// The best score so far, 0–100.
    #[must_use]
    pub fn best(&self) -> Option<f64> {
        self.attempts.iter().map(|a| a.score).max_by(f64::total_cmp)
    }

    /// Fails since the last pass.
    #[must_use]
    pub fn straight_fails(&self) -> usize {
        self.attempts.iter().rev().take_while(|a| !a.passed).count()
    }
}

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
    /// No attempt for long.
    Inactive {
        /// Whole days since the last attempt.
        days: i64,
    },
    /// No attempt at all.
    NotStarted,
}

impl Concern {
    /// The kind in a word or two.
    #[must_use]
    pub fn label(&self) -> &'static str {
        match self {
            Self::Stuck { .. } => "Stuck",
            Self::Declining { .. } => "Declining",
            Self::Inactive { .. } => "Inactive",
            Self::NotStarted => "Not started",
        }
    }

    /// The reason in words.
    #[must_use]
    pub fn reason(&self) -> String {
        match self {
            Self::Stuck { title, fails, last_score } => {
                format!("{fails} fails in a row on “{title}”, the last with {last_score:.0} points")
            }
            Self::Declining { title, from, to } => format!(
                "on “{title}” the mean of the last {DECLINE_RUN} attempts is {to:.0}, of the {DECLINE_RUN} before {from:.0}"
            ),
            Self::Inactive { days } => format!("no attempt for {days} days"),
            Self::NotStarted => "no scored attempt yet".to_owned(),
        }
    }
}

/// Where a trainee stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// One entry per step of the course, in its order.
    pub steps: Vec<StepProgress>,
    /// What to do next: an index into the steps. Absent when everything is mastered or nothing is open.
    pub next: Option<usize>,
    /// Reasons for help, the most pressing first.
    pub concerns: Vec<Concern>,
    /// The latest attempt on any exercise of the course.
    pub last_at: Option<OffsetDateTime>,
}

impl Progress {
    /// Judges attempts, in any order, at a moment.
    #[must_use]
    pub fn of(course: &Course, attempts: &[Attempt], now: OffsetDateTime) -> Self {
        let mut steps: Vec<StepProgress> =
            course.steps.iter().map(|step| tried(step, attempts, &course.rule)).collect();
        lock(course, &mut steps);
        let next = next(&steps);
        let last_at = steps.iter().filter_map(|s| s.attempts.last()).map(|a| a.at).max();
        let mut progress = Self { steps, next, concerns: Vec::new(), last_at };
        progress.concerns = concerns(course, &progress, now);
        progress
    }

    /// How many exercises are mastered.
    #[must_use]
    pub fn mastered(&self) -> usize {
        self.steps.iter().filter(|s| matches!(s.state, StepState::Mastered { .. })).count()
    }

    /// Scored attempts on the course's exercises.
    #[must_use]
    pub fn attempts(&self) -> usize {
        self.steps.iter().map(|s| s.attempts.len()).sum()
    }

    /// Every exercise is mastered.
    #[must_use]
    pub fn complete(&self) -> bool {
        !self.steps.is_empty() && self.mastered() == self.steps.len()
    }
}

/// A step with its attempts, judged as if nothing had to come before it.
fn tried(step: &Step, attempts: &[Attempt], rule: &MasteryRule) -> StepProgress {
    let mut attempts: Vec<Attempt> = attempts.iter().filter(|a| a.exercise == step.exercise).cloned().collect();
    attempts.sort_by_key(|a| a.at);
    let state = match *rule {
        MasteryRule::Passes { passes, of } => by_passes(&attempts, passes, of),
        MasteryRule::Cusum { .. } => StepState::Unjudged,
    };
    StepProgress { state, attempts }
}

/// Mastered by the first attempt that completes `passes` among `of` in a row. Once reached it stays: what comes after
/// shows as a decline, and an exercise that opened another is not closed again under a trainee's hands.
fn by_passes(attempts: &[Attempt], passes: u32, of: u32) -> StepState {
    let count = |run: &[Attempt]| u32::try_from(run.iter().filter(|a| a.passed).count()).unwrap_or(u32::MAX);
    let of = usize::try_from(of).unwrap_or(usize::MAX);
    for end in 1..=attempts.len() {
        if count(&attempts[end.saturating_sub(of)..end]) >= passes {
            return StepState::Mastered { on: attempts[end - 1].at };
        }
    }
    StepState::Open { passes: count(&attempts[attempts.len().saturating_sub(of)..]) }
}

/// Locks open steps whose prerequisites are not mastered. One that is not in the course cannot be met and cannot be
/// practised here either, so it does not lock.
fn lock(course: &Course, steps: &mut [StepProgress]) {
    let unmet: Vec<(&str, &str)> = course
        .steps
        .iter()
        .zip(steps.iter())
        .filter(|(_, progress)| !matches!(progress.state, StepState::Mastered { .. }))
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

/// The first open step; where nothing is judged, the one tried last, or the first.
fn next(steps: &[StepProgress]) -> Option<usize> {
    let open = steps.iter().position(|s| matches!(s.state, StepState::Open { .. }));
    let unjudged = || {
        let tried = (0..steps.len()).filter(|&i| steps[i].state == StepState::Unjudged);
        tried.max_by_key(|&i| (steps[i].attempts.last().map(|a| a.at), std::cmp::Reverse(i)))
    };
    open.or_else(unjudged)
}

fn concerns(course: &Course, progress: &Progress, now: OffsetDateTime) -> Vec<Concern> {
    let Some(last_at) = progress.last_at else { return vec![Concern::NotStarted] };
    let mut concerns = Vec::new();
    concerns.extend(stuck(course, progress));
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

fn mean(attempts: &[Attempt]) -> f64 {
    let count = u32::try_from(attempts.len()).unwrap_or(u32::MAX);
    attempts.iter().map(|a| a.score).sum::<f64>() / f64::from(count.max(1))
}

#[cfg(test)]
mod tests {
    //! A course of three exercises, each after the one before, mastered by 2 passes of 3. Fails when somebody is sent
    //! to a locked exercise, or when an instructor is called for no reason, or not called for a good one.

    use super::*;
    use time::macros::datetime;

    const NOW: OffsetDateTime = datetime!(2026-05-20 12:00 UTC);

    fn course() -> Course {
        let step = |id: &str, before: &[&str]| Step {
            exercise: id.to_owned(),
            title: id.to_uppercase(),
            prerequisites: before.iter().map(|b| (*b).to_owned()).collect(),
        };
        Course {
            steps: vec![step("a", &[]), step("b", &["a"]), step("c", &["b"])],
            rule: MasteryRule::Passes { passes: 2, of: 3 },
        }
    }

    /// Attempts one hour apart, the last one hour ago; a score of 60 passes.
    fn attempts(tried: &[(&str, f64)]) -> Vec<Attempt> {
        let hours = |i: usize| i64::try_from(tried.len() - i).expect("few");
        let attempt = |(i, (exercise, score)): (usize, &(&str, f64))| Attempt {
            session: i.to_string(),
            exercise: (*exercise).to_owned(),
            at: NOW - Duration::hours(hours(i)),
            score: *score,
            passed: *score >= 60.0,
        };
        tried.iter().enumerate().map(attempt).collect()
    }

    fn progress(tried: &[(&str, f64)]) -> Progress {
        Progress::of(&course(), &attempts(tried), NOW)
    }

    #[test]
    fn a_newcomer_starts_with_the_first_exercise_and_has_not_started() {
        let progress = progress(&[]);
        assert_eq!(progress.next, Some(0));
        assert_eq!(progress.concerns, [Concern::NotStarted]);
        assert_eq!(progress.steps[1].state, StepState::Locked { missing: vec!["A".to_owned()] });
    }

    #[test]
    fn mastery_opens_the_next_exercise_and_only_that() {
        let progress = progress(&[("a", 70.0), ("a", 30.0), ("a", 80.0)]);
        assert_eq!(progress.mastered(), 1);
        assert_eq!(progress.next, Some(1));
        assert_eq!(progress.steps[1].state, StepState::Open { passes: 0 });
        assert!(matches!(progress.steps[2].state, StepState::Locked { .. }));
    }

    #[test]
    fn passes_too_far_apart_do_not_count_together() {
        let progress = progress(&[("a", 70.0), ("a", 30.0), ("a", 30.0), ("a", 80.0)]);
        assert_eq!(progress.mastered(), 0);
        assert_eq!(progress.steps[0].state, StepState::Open { passes: 1 });
    }

    #[test]
    fn mastery_once_reached_stays() {
        let progress = progress(&[("a", 70.0), ("a", 80.0), ("a", 10.0), ("a", 10.0), ("a", 10.0)]);
        assert_eq!(progress.mastered(), 1);
    }

    #[test]
    fn three_straight_fails_on_the_current_exercise_are_stuck_and_two_are_not() {
        let fails = [("a", 70.0), ("a", 70.0), ("b", 20.0), ("b", 30.0)];
        assert!(progress(&fails).concerns.is_empty());
        let stuck = progress(&[&fails[..], &[("b", 41.0)]].concat()).concerns;
        assert_eq!(stuck, [Concern::Stuck { title: "B".to_owned(), fails: 3, last_score: 41.0 }]);
        assert_eq!(stuck[0].reason(), "3 fails in a row on “B”, the last with 41 points");
    }

    #[test]
    fn fourteen_days_of_silence_are_borne_and_fifteen_are_not() {
        let old = |days| {
            let mut attempts = attempts(&[("a", 70.0)]);
            attempts[0].at = NOW - Duration::days(days);
            Progress::of(&course(), &attempts, NOW).concerns
        };
        assert!(old(14).is_empty());
        assert_eq!(old(15), [Concern::Inactive { days: 15 }]);
    }

    #[test]
    fn who_has_finished_may_rest() {
        let mut attempts = attempts(&[("a", 70.0), ("a", 70.0), ("b", 70.0), ("b", 70.0), ("c", 70.0), ("c", 70.0)]);
        attempts.iter_mut().for_each(|a| a.at -= Duration::days(100));
        let progress = Progress::of(&course(), &attempts, NOW);
        assert!(progress.complete() && progress.next.is_none() && progress.concerns.is_empty());
    }

    #[test]
    fn a_fall_within_one_exercise_is_a_decline_and_a_harder_exercise_is_not() {
        let fall = progress(&[("a", 90.0), ("a", 90.0), ("a", 90.0), ("a", 70.0), ("a", 75.0), ("a", 80.0)]);
        assert_eq!(fall.concerns, [Concern::Declining { title: "A".to_owned(), from: 90.0, to: 75.0 }]);
        let harder = progress(&[("a", 90.0), ("a", 90.0), ("a", 90.0), ("b", 61.0), ("b", 59.0), ("b", 61.0)]);
        assert!(harder.concerns.is_empty());
    }

    #[test]
    fn a_learning_curve_is_not_guessed() {
        let rule = MasteryRule::Cusum { learning: true, p0: 0.1, p1: 0.2, alpha: 0.1, beta: 0.1 };
        let course = Course { rule, ..course() };
        let progress = Progress::of(&course, &attempts(&[("b", 90.0); 30]), NOW);
        assert!(progress.steps.iter().all(|s| s.state == StepState::Unjudged));
        assert_eq!((progress.mastered(), progress.next), (0, Some(1)));
    }

    #[test]
    fn attempts_on_other_courses_change_nothing() {
        assert_eq!(progress(&[("elsewhere", 90.0)]).concerns, [Concern::NotStarted]);
    }
}
