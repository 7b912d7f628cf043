//! A cohort's progress: status per trainee and exercise, trainees who are stuck or regress, and
//! difficult exercises.

use askama::Template;
use askama_web::WebTemplate;
use assessment::statistics::Estimate;
use model::training::progress::{StepProgress, StepState};
use model::training::risk::RUN;
use time::Date;

use super::ScoredRow;
use crate::{Shell, StatusWord, charts, format};

/// The page of a cohort's progress.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/progress/cohort.html")]
pub struct CohortProgressPage {
    /// Page frame.
    pub shell: Shell,
    /// Name and address of the cohort.
    pub cohort: (String, String),
    /// One heat map per course that a trainee has begun.
    pub courses: Vec<CourseHeat>,
    /// Trainees who are stuck, decline or regress.
    pub worries: Vec<Worry>,
    /// Attempts passed and failed per day, over the last four weeks.
    pub days: Vec<(Date, usize, usize)>,
    /// The selected day, and its attempts in order of time.
    pub day: Option<(Date, Vec<ScoredRow>)>,
}

/// Heat map of a course: one row per trainee, one column per exercise.
#[derive(Clone, Debug)]
pub struct CourseHeat {
    /// Title.
    pub title: String,
    /// Columns.
    pub exercises: Vec<Hardness>,
    /// Trainees by name.
    pub rows: Vec<HeatRow>,
}

/// Difficulty of an exercise for this cohort.
#[derive(Clone, Debug, PartialEq)]
pub struct Hardness {
    /// Its title.
    pub title: String,
    /// Address of its metrics in this cohort.
    pub href: String,
    /// Number of trainees who tried it.
    pub tried: usize,
    /// Number of trainees who have mastered it.
    pub mastered: usize,
    /// Share of attempts passed.
    pub passed: Option<Estimate>,
    /// Whether it has the lowest share of passes in the course.
    pub hardest: bool,
}

/// A trainee's row.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatRow {
    /// Name.
    pub name: String,
    /// Address of the trainee's page.
    pub href: String,
    /// One cell per exercise.
    pub cells: Vec<HeatCell>,
}

/// A trainee's progress on an exercise.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatCell {
    /// Address of the attempts behind it.
    pub href: String,
    /// Number of scored attempts.
    pub attempts: usize,
    /// Number of passed attempts.
    pub passes: usize,
    /// Best score, 0–100.
    pub best: Option<f64>,
    /// Mean of the latest scores, 0–100.
    pub mean: Option<f64>,
    /// Status of the exercise.
    pub status: StatusWord,
    /// CSS class of the background.
    pub tone: &'static str,
}

/// A concern about a trainee.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Worry {
    /// Name.
    pub name: String,
    /// Address of the attempts behind it.
    pub href: String,
    /// Kind and reason.
    pub concern: (&'static str, String),
}

/// Builds a cell of the heat map. The status names the tone, so that colour is not the only cue.
#[must_use]
pub fn make_heat_cell(href: String, step: &StepProgress, pass_mark: f64) -> HeatCell {
    let last = &step.attempts[step.attempts.len().saturating_sub(RUN)..];
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
    /// Draws the attempts per day.
    #[must_use]
    pub fn drawing(&self) -> String {
        charts::draw_attempts_by_day(&self.days)
    }

    /// Returns whether the day is the selected one.
    fn is_open(&self, date: &Date) -> bool {
        self.day.as_ref().is_some_and(|(day, _)| day == date)
    }

    /// Returns the number of attempts on the days shown.
    #[must_use]
    pub fn attempts(&self) -> usize {
        self.days.iter().map(|(_, passed, failed)| passed + failed).sum()
    }
}

#[cfg(test)]
mod tests {
    //! Every figure must link to its attempts, and colour must not be the only cue.

    use crate::samples;
    use crate::training::progress::samples as made;

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
