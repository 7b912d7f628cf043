//! A trainee's progress on one exercise: scores, learning curve, habits and comparison with the
//! cohort.

use askama::Template;
use askama_web::WebTemplate;
use assessment::learning::{Crossing, LearningPoint, Standing};
use assessment::statistics::{Estimate, Summary};
use model::training::progress::{CurveRule, Habits, RubricHabit, ScoredAttempt, StepProgress};
use time::OffsetDateTime;

use crate::{Shell, StatusWord, charts, format, metric};

/// The page of a trainee's progress on one exercise.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/progress/learning.html")]
pub struct LearningPage {
    /// Page frame.
    pub shell: Shell,
    /// Name of the trainee and address of their page.
    pub trainee: (String, String),
    /// Whether the trainee is the visitor.
    pub own: bool,
    /// Title and address of the exercise.
    pub exercise: (String, String),
    /// Title of the course, and its mastery rule as text.
    pub course: (String, String),
    /// Status of the exercise.
    pub status: StatusWord,
    /// Scores over time.
    pub scores: String,
    /// The learning curve, where it is the course's rule.
    pub curve: Option<CurveFacts>,
    /// One by an example of a rule, which decides nothing, for those who teach.
    pub beside: Option<CurveFacts>,
    /// Attempts on different revisions are mixed.
    pub mixed: bool,
    /// Share of attempts passed.
    pub passed: Option<Estimate>,
    /// The lines that lose most points, and those that lose almost none.
    pub habits: HabitsView,
    /// Comparison with the others of the cohort, if there are enough.
    pub comparison: Option<Comparison>,
    /// Attempts, newest first.
    pub rows: Vec<CurveRow>,
}

/// A learning curve and its parameters.
#[derive(Clone, Debug)]
pub struct CurveFacts {
    /// The drawing.
    pub drawing: String,
    /// Parameters stated by the course, and the limits derived from them.
    pub rule: CurveRule,
    /// What it says now.
    pub standing: Standing,
    /// Consecutive successes still needed.
    pub needed: u32,
    /// Number of attempts so far.
    pub attempts: usize,
}

impl CurveFacts {
    /// A curve as it stands. `title` is what the drawing is called.
    #[must_use]
    pub fn new(step: &StepProgress, rule: CurveRule, title: &str) -> Option<Self> {
        let curve = step.curve.as_ref()?;
        Some(Self {
            drawing: charts::draw_learning_curve(&curve.points, &rule.rule, "own", title),
            rule,
            standing: curve.standing,
            needed: curve.successes_needed,
            attempts: curve.points.len(),
        })
    }

    /// Returns the limit on attempts for which the stated error holds, if it is exceeded.
    #[must_use]
    pub fn beyond(&self) -> Option<u32> {
        self.rule.within.filter(|within| self.attempts > *within as usize)
    }
}

/// Habits that lose points, with links to the attempts.
#[derive(Clone, Debug, Default)]
pub struct HabitsView {
    /// Number of attempts considered.
    pub attempts: usize,
    /// Habits, largest loss first.
    pub habits: Vec<HabitRow>,
    /// Names of the metrics that lose almost no points.
    pub strengths: Vec<String>,
}

/// A habit.
#[derive(Clone, Debug, PartialEq)]
pub struct HabitRow {
    /// Name of the metric.
    pub label: String,
    /// Mean points lost per attempt.
    pub points: f64,
    /// Number of attempts in which it lost points, and in which it was graded.
    pub costly: (usize, usize),
    /// Recommendation.
    pub advice: String,
    /// Address of the attempt with the largest loss.
    pub worst: String,
}

impl HabitsView {
    /// Lists habits; `pages` holds the addresses of the attempts in the same order.
    #[must_use]
    pub fn new(found: Habits, pages: &[String]) -> Self {
        let row = |line: RubricHabit| HabitRow {
            label: metric::metric_label(&line.metric),
            points: line.mean_points,
            costly: (line.costly, line.judged),
            advice: words::known(line.advice),
            worst: pages.get(line.worst).cloned().unwrap_or_default(),
        };
        Self {
            attempts: pages.len(),
            strengths: found.strengths.into_iter().map(|line| metric::metric_label(&line.metric)).collect(),
            habits: found.habits.into_iter().map(row).collect(),
        }
    }
}

/// Comparison with the best scores of others in a cohort.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Name of the cohort.
    pub cohort: String,
    /// The trainee's best score, 0–100.
    pub own: f64,
    /// Distribution of the best scores of the others, 0–100.
    pub others: Summary,
}

impl Comparison {
    /// Draws the score within the distribution of the others.
    #[must_use]
    pub fn drawing(&self) -> String {
        charts::draw_score_among_others(self.own, &self.others)
    }
}

/// Result of the curve after an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveFinding {
    /// No limit crossed.
    Nothing,
    /// Competent.
    Competent,
    /// Still competent: the CUSUM reached its lower limit.
    StillCompetent,
    /// Too many failures, after competence.
    Lost,
    /// Too many failures, before any competence.
    TooMany,
}

/// An attempt with its value on the curve.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveRow {
    /// Number of the attempt, from 1.
    pub number: usize,
    /// Address of the attempt's page.
    pub href: String,
    /// Start of the attempt.
    pub at: OffsetDateTime,
    /// Score, 0–100.
    pub score: f64,
    /// Whether it was passed.
    pub passed: bool,
    /// Sum after the attempt.
    pub value: Option<f64>,
    /// Whether the LC-CUSUM applied; otherwise the CUSUM.
    pub learning: bool,
    /// Result of the curve.
    pub said: CurveFinding,
}

impl CurveRow {
    /// Returns the attempts of a step, newest first.
    #[must_use]
    pub fn all(step: &StepProgress) -> Vec<Self> {
        let points = step.curve.as_ref().map_or(&[][..], |curve| &curve.points);
        let row = |(i, attempt): (usize, &ScoredAttempt)| Self {
            number: i + 1,
            href: format!("/sessions/{}", attempt.session),
            at: attempt.at,
            score: attempt.score,
            passed: attempt.passed,
            value: points.get(i).map(|p| p.value),
            learning: points.get(i).is_some_and(|p| p.learning),
            said: find_in_curve(points, i),
        };
        step.attempts.iter().enumerate().map(row).rev().collect()
    }
}

fn find_in_curve(points: &[LearningPoint], at: usize) -> CurveFinding {
    let before = at.checked_sub(1).and_then(|i| points.get(i)).map_or(Standing::NotYet, |p| p.standing);
    match (points.get(at).and_then(|p| p.crossed), before) {
        (None, _) => CurveFinding::Nothing,
        (Some(Crossing::Acceptable), Standing::Competent) => CurveFinding::StillCompetent,
        (Some(Crossing::Acceptable), _) => CurveFinding::Competent,
        (Some(Crossing::Unacceptable), Standing::Competent) => CurveFinding::Lost,
        (Some(Crossing::Unacceptable), _) => CurveFinding::TooMany,
    }
}

#[cfg(test)]
mod tests {
    //! The page must show the state of the curve, its parameters, and when its stated error no
    //! longer holds.

    use super::*;
    use crate::samples;
    use crate::training::progress::samples as made;

    #[test]
    fn a_curve_says_state_parameters_and_what_is_needed() {
        let html = samples::keep_page("learning", &made::learning_page(9));
        for words in ["more consecutive successes", "LC-CUSUM", "revisions", "Overshoot", "/sessions/0", "attempts.csv"]
        {
            assert!(html.contains(words), "{words}: {html}");
        }
        assert!(!html.contains("no longer holds"));
    }

    #[test]
    fn unused_curve_is_folded_for_teachers_and_absent_for_trainees() {
        let page = made::learning_beside_passes(9);
        let html = samples::keep_page("learning-beside", &page);
        for words in ["3 passes", "not used for mastery in this course", "an example", "<details>"] {
            assert!(html.contains(words), "{words}: {html}");
        }
        assert!(!html.contains("<th scope=\"col\">The curve"), "no column of what decides nothing: {html}");
        let own = samples::keep_page("learning-own", &LearningPage { beside: None, own: true, ..page });
        assert!(!own.contains("LC-CUSUM") && !own.contains("statistical"), "{own}");
        assert!(!samples::keep_page("learning", &made::learning_page(9)).contains("not used for mastery"));
    }

    #[test]
    fn beyond_its_attempts_the_stated_error_no_longer_holds() {
        assert!(samples::keep_page("learning-beyond", &made::learning_page(60)).contains("no longer holds"));
    }

    #[test]
    fn without_an_attempt_the_page_says_what_to_do() {
        assert!(samples::keep_page("learning-empty", &made::learning_page(0)).contains("No scored attempt yet"));
    }
}
