//! The transcript: a trainee's results in all courses, as a printable page.

use askama::Template;
use askama_web::WebTemplate;
use model::training::progress::{Course, Progress, StepState};
use time::OffsetDateTime;

use crate::training::trainee::rule_in_words;
use crate::{Shell, format};

/// The page of a transcript.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/transcript.html")]
pub struct TranscriptPage {
    /// Page frame.
    pub shell: Shell,
    /// Name of the trainee and address of their page.
    pub trainee: (String, String),
    /// Name of the school.
    pub school: String,
    /// Number from the registrar's office.
    pub registrar_id: Option<String>,
    /// Courses, most recently practised first.
    pub courses: Vec<TranscriptCourse>,
    /// Time of creation.
    pub made_at: OffsetDateTime,
}

/// A course.
#[derive(Clone, Debug, PartialEq)]
pub struct TranscriptCourse {
    /// Its title.
    pub title: String,
    /// The mastery rule as text.
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
    /// When it was mastered, even if mastery has been lost since.
    pub mastered_on: Option<OffsetDateTime>,
    /// Best score, 0–100.
    pub best: Option<f64>,
    /// Number of passed attempts.
    pub passes: usize,
    /// Number of scored attempts.
    pub attempts: usize,
}

impl TranscriptCourse {
    /// Summarizes a trainee's progress in a course.
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
    //! The page must agree with the trainee's own page.

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
