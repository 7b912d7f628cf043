//! A transcript: what somebody has done in every course, on a page to print.

use askama::Template;
use askama_web::WebTemplate;
use model::progress::{Course, Progress, StepState};
use time::OffsetDateTime;

use super::trainee::rule_in_words;
use super::{Shell, format};

/// The page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "transcript.html")]
pub struct TranscriptPage {
    /// Frame.
    pub shell: Shell,
    /// The trainee's name and page.
    pub trainee: (String, String),
    /// The school.
    pub school: String,
    /// What the registrar knows them by.
    pub registrar_id: Option<String>,
    /// Courses, the one tried last first.
    pub courses: Vec<TranscriptCourse>,
    /// When it was made.
    pub made_at: OffsetDateTime,
}

/// A course.
#[derive(Clone, Debug, PartialEq)]
pub struct TranscriptCourse {
    /// Its title.
    pub title: String,
    /// When an exercise of it is mastered.
    pub rule: String,
    /// Since when it is mastered.
    pub mastered_on: Option<OffsetDateTime>,
    /// Its exercises.
    pub lines: Vec<TranscriptLine>,
}

/// An exercise.
#[derive(Clone, Debug, PartialEq)]
pub struct TranscriptLine {
    /// Its title.
    pub title: String,
    /// Since when it is mastered.
    pub mastered_on: Option<OffsetDateTime>,
    /// The best score, 0–100.
    pub best: Option<f64>,
    /// Attempts passed.
    pub passes: usize,
    /// Scored attempts.
    pub attempts: usize,
}

impl TranscriptCourse {
    /// What a trainee's progress in a course comes to.
    #[must_use]
    pub fn new(title: &str, course: &Course, progress: &Progress) -> Self {
        let lines = course.steps.iter().zip(&progress.steps).map(|(step, done)| TranscriptLine {
            title: step.title.clone(),
            mastered_on: match done.state {
                StepState::Mastered { on } | StepState::Regressing { on, .. } => Some(on),
                StepState::Open { .. } | StepState::Locked { .. } => None,
            },
            best: done.attempts.iter().map(|attempt| attempt.score).reduce(f64::max),
            passes: done.attempts.iter().filter(|attempt| attempt.passed).count(),
            attempts: done.attempts.len(),
        });
        Self {
            title: title.to_owned(),
            rule: rule_in_words(&course.rule),
            mastered_on: progress.completed_on(),
            lines: lines.collect(),
        }
    }

    fn mastered(&self) -> usize {
        self.lines.iter().filter(|line| line.mastered_on.is_some()).count()
    }
}

#[cfg(test)]
mod tests {
    //! Fails when the page says more, or less, than the trainee's own page does.

    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn every_exercise_has_its_state_and_its_best() {
        let (course, progress) = (samples::course(), samples::progress());
        let told = TranscriptCourse::new("Lower back", &course, &progress);
        assert_eq!(told.lines.len(), course.steps.len());
        assert_eq!(told.mastered(), progress.mastered());
        let page = TranscriptPage {
            shell: samples::shell(Role::Trainee),
            trainee: ("Ada <Okafor>".to_owned(), "/".to_owned()),
            school: "Nordklinik".to_owned(),
            registrar_id: Some("4711".to_owned()),
            courses: vec![told],
            made_at: samples::NOW,
        };
        let html = samples::keep_page("transcript", &page);
        for wanted in ["Ada &#60;Okafor&#62;", "4711", "Nordklinik", "Lower back", "An exercise is mastered"] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
    }
}
