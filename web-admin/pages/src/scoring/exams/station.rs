//! The station of a candidate: begin, the examiner's form, and the result.

use askama::Template;
use askama_web::WebTemplate;

use super::{AnsweredItem, ScoreWords, SittingClock};
use crate::surveys::form::{FormQuestion, QuestionField};
use crate::{Shell, assets, format};

/// The page of a candidate's station.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "scoring/exams/station.html")]
pub struct StationPage {
    /// Page frame.
    pub shell: Shell,
    /// Address of the page.
    pub href: String,
    /// Title and address of the exam.
    pub exam: (String, String),
    /// Name of the candidate.
    pub name: String,
    /// Title of the exercise.
    pub exercise: String,
    /// Title of the instrument.
    pub instrument: String,
    /// Time limit, in min.
    pub limit_min: u32,
    /// Whether the visitor may begin the sitting.
    pub may_begin: bool,
    /// Times of the sitting; `None` if it has not begun.
    pub clock: Option<SittingClock>,
    /// Name of the examiner.
    pub examiner: String,
    /// Questions of the form; empty unless the visitor is the examiner and the form is open.
    pub questions: Vec<FormQuestion>,
    /// The examiner's scores, once the sitting is finished and if the visitor may see them.
    pub scores: Vec<ScoreWords>,
    /// The examiner's answers, likewise.
    pub answers: Vec<AnsweredItem>,
    /// Address of the attempt, likewise.
    pub attempt: Option<String>,
    /// Whether the visitor is the second rater, who sees nothing of the sitting.
    pub is_second_rater: bool,
}

impl StationPage {
    /// Returns the number of answers that were refused.
    #[must_use]
    pub fn refused(&self) -> usize {
        self.questions.iter().filter(|question| question.refusal.is_some()).count()
    }

    fn saving_script(&self) -> String {
        assets::asset_address("survey.js")
    }
}

#[cfg(test)]
mod tests {
    use assessment::questionnaire::Answer;
    use model::Role;

    use super::super::samples::{checklist, clock};
    use super::super::{list_answers, list_scores};
    use super::*;
    use crate::samples;
    use crate::surveys::form::GivenField;

    fn station() -> StationPage {
        StationPage {
            shell: samples::shell(Role::Instructor),
            href: "/exams/1/candidates/1".to_owned(),
            exam: ("Epidural station".to_owned(), "/exams/1".to_owned()),
            name: "Ada <Okafor>".to_owned(),
            exercise: "Stop in the fat".to_owned(),
            instrument: "Checklist of a puncture".to_owned(),
            limit_min: 10,
            may_begin: true,
            clock: None,
            examiner: String::new(),
            questions: Vec::new(),
            scores: Vec::new(),
            answers: Vec::new(),
            attempt: None,
            is_second_rater: false,
        }
    }

    #[test]
    fn station_leads_from_begin_through_the_form_to_the_result() {
        let html = samples::keep_page("station-begin", &station());
        assert!(html.contains("/exams/1/candidates/1/begin") && html.contains("10 min"), "{html}");
        let instrument = checklist();
        let question = |item| FormQuestion::new(&instrument, item, "en", &GivenField::default());
        let running = StationPage {
            clock: Some(clock(200, None)),
            examiner: "Dr Osei".to_owned(),
            questions: instrument.items.iter().map(question).collect(),
            ..station()
        };
        let html = samples::keep_page("station", &running);
        for wanted in ["6 min 40", "name=\"q.entry\"", "value=\"finish\"", "Not done"] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
        let answers = vec![Some(Answer::Number(1.0)); 10];
        let finished = StationPage {
            clock: Some(clock(2000, Some(690))),
            questions: Vec::new(),
            scores: list_scores(&instrument, &answers),
            answers: list_answers(&instrument, &answers),
            attempt: Some("/sessions/1".to_owned()),
            ..running
        };
        let html = samples::keep_page("station-finished", &finished);
        assert!(html.contains("Finished late") && html.contains(">10<") && !html.contains("name=\"do\""), "{html}");
        let blind = StationPage { is_second_rater: true, clock: None, may_begin: false, ..station() };
        assert!(samples::keep_page("station-blind", &blind).contains("You are the second rater"));
    }
}
