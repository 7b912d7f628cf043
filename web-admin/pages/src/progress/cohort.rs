//! A cohort's progress: who stands where on each exercise, who is stuck or regresses, and what is hard.

use askama::Template;
use askama_web::WebTemplate;
use assessment::statistics::Estimate;
use model::progress::{DECLINE_RUN, StepProgress, StepState};
use time::Date;

use super::ScoredRow;
use crate::{Shell, StatusWord, charts, format};

/// The page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "progress/cohort.html")]
pub struct CohortProgressPage {
    /// Frame.
    pub shell: Shell,
    /// The cohort's name and page.
    pub cohort: (String, String),
    /// One map a course that somebody has begun.
    pub courses: Vec<CourseHeat>,
    /// Who is stuck, declines or regresses.
    pub worries: Vec<Worry>,
    /// Attempts passed and failed by day, the last four weeks.
    pub days: Vec<(Date, usize, usize)>,
    /// A day that is looked into, and its attempts in order of time.
    pub day: Option<(Date, Vec<ScoredRow>)>,
}

/// A course: trainees down, exercises across.
#[derive(Clone, Debug)]
pub struct CourseHeat {
    /// Title.
    pub title: String,
    /// Exercises across.
    pub exercises: Vec<Hardness>,
    /// Trainees by name.
    pub rows: Vec<HeatRow>,
}

/// How hard an exercise is to this cohort.
#[derive(Clone, Debug, PartialEq)]
pub struct Hardness {
    /// Its title.
    pub title: String,
    /// The page of its metrics in this cohort.
    pub href: String,
    /// Trainees who tried it.
    pub tried: usize,
    /// Trainees who have mastered it.
    pub mastered: usize,
    /// Share of attempts passed.
    pub passed: Option<Estimate>,
    /// Fewer attempts pass here than anywhere else in the course.
    pub hardest: bool,
}

/// A trainee's row.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatRow {
    /// Name.
    pub name: String,
    /// Page.
    pub href: String,
    /// One cell an exercise.
    pub cells: Vec<HeatCell>,
}

/// A trainee on an exercise.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatCell {
    /// What it is made of.
    pub href: String,
    /// Scored attempts.
    pub attempts: usize,
    /// Attempts passed.
    pub passes: usize,
    /// Best score, 0–100.
    pub best: Option<f64>,
    /// Mean of the last scores, 0–100.
    pub mean: Option<f64>,
    /// How it stands.
    pub status: StatusWord,
    /// The class of its ground.
    pub tone: &'static str,
}

/// A reason to look at somebody.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Worry {
    /// Name.
    pub name: String,
    /// The page of what it is made of.
    pub href: String,
    /// Kind and reason.
    pub concern: (&'static str, String),
}

/// A cell from a step. The tone has its word in the status, so that no colour speaks alone.
#[must_use]
pub fn make_heat_cell(href: String, step: &StepProgress, pass_mark: f64) -> HeatCell {
    let last = &step.attempts[step.attempts.len().saturating_sub(DECLINE_RUN)..];
    let mean = (!last.is_empty()).then(|| last.iter().map(|a| a.score).sum::<f64>() / last.len() as f64);
    let status = match (&step.state, mean) {
        (StepState::Mastered { .. }, _) => StatusWord::Mastered,
        (StepState::Regressing { .. }, _) => StatusWord::Regressing,
        (StepState::Locked { .. }, None) => StatusWord::Locked,
        _ => StatusWord::Open,
    };
    let tone = match (status, mean) {
        (StatusWord::Mastered, _) => "heat-mastered",
        (StatusWord::Regressing, _) => "heat-low",
        (_, None) => "heat-none",
        (_, Some(mean)) if mean >= pass_mark => "heat-high",
        (_, Some(mean)) if mean >= pass_mark / 2.0 => "heat-middle",
        _ => "heat-low",
    };
    HeatCell { href, attempts: step.attempts.len(), passes: step.passes(), best: step.best(), mean, status, tone }
}

impl CohortProgressPage {
    /// The days as a drawing.
    #[must_use]
    pub fn drawing(&self) -> String {
        charts::draw_attempts_by_day(&self.days)
    }

    /// The day is the one that is looked into.
    fn is_open(&self, date: &Date) -> bool {
        self.day.as_ref().is_some_and(|(day, _)| day == date)
    }

    /// Attempts in the days shown.
    #[must_use]
    pub fn attempts(&self) -> usize {
        self.days.iter().map(|(_, passed, failed)| passed + failed).sum()
    }
}

#[cfg(test)]
mod tests {
    //! Every figure leads to what it is made of, and no colour speaks alone.

    use crate::progress::samples as made;
    use crate::samples;

    #[test]
    fn a_cohort_sees_its_map_its_worries_and_what_is_hard() {
        let html = samples::keep_page("cohort-progress", &made::cohort_progress_page());
        for words in ["Hardest", "heat-low", "Mastered", "/trainees/1/exercises/", "Stuck", "progress.csv", "By day"] {
            assert!(html.contains(words), "{words}: {html}");
        }
        for words in ["progress?day=2026-", "Attempts on ", "/sessions/7", "aria-current"] {
            assert!(html.contains(words), "{words}: {html}");
        }
    }
}
