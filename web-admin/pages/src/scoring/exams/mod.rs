//! Exams: their list with the form of a new one, an exam, the station of a candidate, and a
//! trainee's own results.

mod exam;
mod station;

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use assessment::questionnaire::{Answer, score_response};
use documents::Instrument;
use documents::instrument::{Item, ScoreKey};
pub use exam::{CandidateRow, ExamCounts, ExamPage, SecondRatings};
use model::Moment;
use model::scoring::exam::{LONGEST_LIMIT_MIN, SittingStage, SittingTimes};
use serde::Deserialize;
pub use station::StationPage;
use time::OffsetDateTime;

use crate::form::{FilledForm, SelectOption, read_trimmed_text};
use crate::surveys::form::{FormQuestion, GivenField};
use crate::{Shell, StatusWord, format};

/// The exams of a teacher's cohorts.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "scoring/exams/list.html")]
pub struct ExamsPage {
    /// Page frame.
    pub shell: Shell,
    /// Exams, latest first.
    pub rows: Vec<ExamRow>,
    /// The form of a new exam.
    pub form: FilledForm<ExamForm>,
    /// Options of the form.
    pub options: ExamOptions,
}

/// An exam in the list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExamRow {
    /// Address of its page.
    pub href: String,
    /// Title.
    pub title: String,
    /// Name of the cohort.
    pub cohort: String,
    /// Title of the exercise.
    pub exercise: String,
    /// Time limit, in min.
    pub limit_min: u32,
    /// Number of finished sittings, and of those begun.
    pub finished: (u32, u32),
    /// Time of creation.
    pub made_at: OffsetDateTime,
    /// Whether it is closed.
    pub is_closed: bool,
}

/// Input of the form of a new exam.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct ExamForm {
    /// Title.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub title: String,
    /// Id of the cohort.
    pub cohort: String,
    /// Id of the exercise.
    pub exercise: String,
    /// Id of the instrument.
    pub instrument: String,
    /// Time limit, in min.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub limit: String,
    /// Id of the second rater; empty for none.
    pub second: String,
}

/// Options of the form of a new exam.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExamOptions {
    /// Cohorts.
    pub cohorts: Vec<SelectOption>,
    /// Exercises, by course.
    pub exercises: Vec<SelectOption>,
    /// Instruments with a score and without free text.
    pub instruments: Vec<SelectOption>,
    /// Instructors of the school.
    pub raters: Vec<SelectOption>,
}

impl ExamsPage {
    const MOST_MINUTES: u32 = LONGEST_LIMIT_MIN;
}

/// A trainee's own results.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "scoring/exams/own.html")]
pub struct OwnExamsPage {
    /// Page frame.
    pub shell: Shell,
    /// Results, latest first.
    pub results: Vec<OwnResult>,
}

/// A trainee's result of a closed exam.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnResult {
    /// Title of the exam.
    pub title: String,
    /// Times of the sitting.
    pub clock: SittingClock,
    /// The examiner's scores.
    pub scores: Vec<ScoreWords>,
    /// The examiner's answers.
    pub answers: Vec<AnsweredItem>,
    /// Address of the attempt.
    pub attempt: Option<String>,
}

/// Formats a score as an instrument states it: a whole number without decimals.
fn say_score(score: impl Borrow<f64>) -> String {
    format::format_stated(score, "")
}

/// A score in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScoreWords {
    /// Title of the score.
    pub title: String,
    /// Value; empty if it cannot be computed.
    pub value: String,
}

/// An answered item of an instrument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AnsweredItem {
    /// Question.
    pub question: String,
    /// Answer in words; empty if it was skipped.
    pub answer: String,
}

/// Returns the scores of answers.
#[must_use]
pub fn list_scores(instrument: &Instrument, answers: &[Option<Answer>]) -> Vec<ScoreWords> {
    let words = |key: &ScoreKey| ScoreWords {
        title: key.title.in_language(words::current().code()).to_owned(),
        value: score_response(instrument, key, answers).map(say_score).unwrap_or_default(),
    };
    instrument.scores.iter().map(words).collect()
}

/// Returns the items of an instrument with their answers.
#[must_use]
pub fn list_answers(instrument: &Instrument, answers: &[Option<Answer>]) -> Vec<AnsweredItem> {
    let language = instrument.language_for(words::current().code());
    let answered = |(at, item): (usize, &Item)| {
        let given = GivenField { answer: answers.get(at).and_then(Option::as_ref), ..GivenField::default() };
        let question = FormQuestion::new(instrument, item, language, &given);
        AnsweredItem { answer: question.say_answer(), question: question.text }
    };
    instrument.items.iter().enumerate().map(answered).collect()
}

/// The times of a sitting, for display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SittingClock {
    /// Stage.
    pub stage: SittingStage,
    /// Begin.
    pub begun_at: OffsetDateTime,
    /// End of the time limit.
    pub ends_at: OffsetDateTime,
    /// When the form was finished.
    pub finished_at: Option<OffsetDateTime>,
    /// Time left, in s.
    pub left_s: f64,
    /// Time by which the limit is exceeded, in s.
    pub late_s: f64,
    /// Time from begin to finish, or so far, in s.
    pub taken_s: f64,
}

impl SittingClock {
    /// Creates the display of times at a moment.
    #[must_use]
    pub fn new(times: &SittingTimes, now: Moment) -> Self {
        Self {
            stage: times.stage(now),
            begun_at: times.begun_at.to_utc(),
            ends_at: times.ends_at().to_utc(),
            finished_at: times.finished_at.map(Moment::to_utc),
            left_s: times.left_s(now),
            late_s: times.late_s(now),
            taken_s: times.finished_at.unwrap_or(now).duration_since(times.begun_at).as_secs_f64(),
        }
    }

    /// Returns the badge of its stage.
    #[must_use]
    pub fn badge(&self) -> String {
        match self.stage {
            SittingStage::Running => StatusWord::Current.badge_saying(tr!("Running")),
            SittingStage::Overdue => StatusWord::Help.badge_saying(tr!("Time is over")),
            SittingStage::Finished => StatusWord::Passed.badge_saying(tr!("Finished")),
            SittingStage::FinishedLate => StatusWord::Help.badge_saying(tr!("Finished late")),
        }
    }

    /// Returns the times in words.
    #[must_use]
    pub fn words(&self) -> String {
        let ends_at = format::format_clock(self.ends_at);
        match self.stage {
            SittingStage::Running => {
                tr!("until {time}, {left} left", time = ends_at, left = format_minutes(self.left_s))
            }
            SittingStage::Overdue => tr!("ended at {time}; the form is not finished", time = ends_at),
            SittingStage::Finished => tr!("after {taken}", taken = format_minutes(self.taken_s)),
            SittingStage::FinishedLate => tr!(
                "after {taken}, {late} late",
                taken = format_minutes(self.taken_s),
                late = format_minutes(self.late_s)
            ),
        }
    }
}

/// Formats a duration of a station in whole seconds: 45 s, or 2 min 5 s.
fn format_minutes(seconds: f64) -> String {
    let whole = seconds.round();
    if whole < 60.0 { format!("{whole:.0}\u{a0}s") } else { format::format_span(whole) }
}

#[cfg(test)]
mod samples {
    use model::Moment;
    use model::scoring::exam::SittingTimes;

    use super::SittingClock;
    use crate::samples;

    /// Returns the clock of a sitting of ten minutes that began `ago_s` before now.
    pub(super) fn clock(ago_s: i64, taken_s: Option<i64>) -> SittingClock {
        let now = Moment::from(samples::NOW);
        let begun_at = now.plus_s(-ago_s);
        let finished_at = taken_s.map(|taken| begun_at.plus_s(taken));
        SittingClock::new(&SittingTimes { begun_at, finished_at, limit_min: 10 }, now)
    }

    pub(super) fn checklist() -> documents::Instrument {
        let document = include_bytes!("../../../../../curricula/instruments/puncture-checklist.toml");
        documents::Instrument::from_bytes("sample", document).expect("a shipped instrument")
    }
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::samples::{checklist, clock};
    use super::*;
    use crate::samples as pages;

    fn option(value: &str, chosen: bool) -> SelectOption {
        SelectOption { value: value.to_owned(), label: value.to_owned(), chosen }
    }

    #[test]
    fn exams_are_listed_and_a_refused_form_keeps_its_input() {
        let row = ExamRow {
            href: "/exams/1".to_owned(),
            title: "Station <3>".to_owned(),
            cohort: "Year 4".to_owned(),
            exercise: "Stop in the fat".to_owned(),
            limit_min: 10,
            finished: (3, 4),
            made_at: pages::NOW,
            is_closed: false,
        };
        let typed = ExamForm { title: "Station \"3\"".to_owned(), limit: "500".to_owned(), ..ExamForm::default() };
        let options = ExamOptions {
            cohorts: vec![option("year-4", true)],
            exercises: vec![option("stop", false)],
            instruments: vec![option("puncture-checklist", true)],
            raters: vec![option("dr-osei", false)],
        };
        let form = FilledForm::refused(typed, "time limit: “500”; allowed: 1 to 120 minutes".to_owned());
        let page = ExamsPage { shell: pages::shell(Role::Instructor), rows: vec![row], form, options };
        let html = pages::keep_page("exams", &page);
        for wanted in ["Station &#60;3&#62;", "3 of 4", "Station &#34;3&#34;", "role=\"alert\"", "max=\"120\""] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
    }

    #[test]
    fn own_result_shows_score_time_and_every_answer() {
        let instrument = checklist();
        let mut answers = vec![Some(Answer::Number(1.0)); 10];
        answers[3] = Some(Answer::Number(0.0));
        let result = OwnResult {
            title: "Station 3".to_owned(),
            clock: clock(3000, Some(690)),
            scores: list_scores(&instrument, &answers),
            answers: list_answers(&instrument, &answers),
            attempt: Some("/sessions/1".to_owned()),
        };
        let page = OwnExamsPage { shell: pages::shell(Role::Trainee), results: vec![result] };
        let html = pages::keep_page("exams-own", &page);
        for wanted in ["Steps done (0–10)", ">9<", "Finished late", "11 min 30", "Not done"] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
        assert_eq!(html.matches(">Done<").count(), 9, "{html}");
        answers[0] = None;
        assert_eq!(list_scores(&instrument, &answers)[0].value, "", "a skipped item leaves no score");
        let empty = OwnExamsPage { shell: pages::shell(Role::Trainee), results: Vec::new() };
        assert!(pages::keep_page("exams-own-none", &empty).contains("No results yet"));
    }
}
