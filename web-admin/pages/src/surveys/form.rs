//! The form of an instrument: questions as fields, in the language of the respondent.

use askama::Template;
use askama_web::WebTemplate;
use assessment::questionnaire::{Answer, Refused};
use axum::response::{IntoResponse, Response};
use documents::Instrument;
use documents::instrument::{Item, ScaleKind, Words};
use model::surveys::Identity;
use model::surveys::given::{GivenAnswers, name_of_field, name_of_leaving};
use words::Language;

use super::previewing::FormPreview;
use crate::{assets, format};

/// Units that instruments state in English, and that are said in every language.
const UNITS: [&str; 6] = [
    sentence!("years"),
    sentence!("months"),
    sentence!("weeks"),
    sentence!("days"),
    sentence!("hours"),
    sentence!("minutes"),
];

/// A unit in the reader's language, where the pages have it.
fn say_unit(unit: &str) -> String {
    let known = UNITS.into_iter().find(|known| *known == unit);
    known.map_or_else(|| unit.to_owned(), |known| words::say(known).to_owned())
}

/// Most places of a row of marks; a finer scale is a field for a number.
const MOST_MARKS: f64 = 21.0;

/// The page before the first question: information about the survey, and consent.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "surveys/consent.html")]
pub struct ConsentPage {
    /// Information about the survey.
    pub terms: Terms,
    /// Address to which the form is submitted.
    pub action: String,
    /// Hidden fields: name and value.
    pub hidden: Vec<(&'static str, String)>,
    /// Languages: code and address.
    pub languages: Vec<(String, String)>,
    /// Whether the form was refused because the box was not ticked.
    pub refused: bool,
    /// Whether answers have already been begun or submitted, so that no consent is needed.
    pub begun: bool,
}

/// Information shown before the first question.
#[derive(Clone, Debug)]
pub struct Terms {
    /// Code of the language.
    pub language: String,
    /// Title of the survey.
    pub title: String,
    /// Introduction of the instrument.
    pub intro: String,
    /// Duration, in min.
    pub duration_min: f64,
    /// Number of questions.
    pub questions: usize,
    /// Whether answers can be traced to the respondent.
    pub identity: Identity,
    /// Whether it is asked after an attempt.
    pub after_attempt: bool,
    /// Who asks.
    pub asker: SurveyAsker,
}

/// Who asks a survey, and who answers for what is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SurveyAsker {
    /// The school for which it is asked.
    pub school: String,
    /// Name and address of whoever asks; absent where a course does, and the school's administrators own the survey.
    pub contact: Option<SurveyContact>,
    /// Who answers for the data, whom to ask and how long answers are kept, in the school's words; empty where it has not said.
    pub data_notice: String,
}

/// Whoever asks a survey.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SurveyContact {
    /// Their name.
    pub name: String,
    /// Their address.
    pub email: String,
}

/// Information shown at a station before the first question, one paragraph per line.
#[derive(Debug, Template)]
#[template(path = "surveys/station.txt")]
struct StationTerms<'a> {
    terms: &'a Terms,
    /// Whether the respondent is a guest of a study, who has no page at the school.
    guest: bool,
}

impl SurveyAsker {
    /// Who asks, for whom, and at which address, in words.
    fn say(&self) -> String {
        match &self.contact {
            Some(SurveyContact { name, email }) => {
                tr!("{name}, {email}, for {school}", name = name, email = email, school = self.school)
            }
            None => tr!("the administrators of {school}", school = self.school),
        }
    }
}

impl Terms {
    /// Returns the paragraphs shown at a station before the first question. A guest of a study has
    /// no page at the school on which to answer later.
    #[must_use]
    pub fn at_a_station(&self, guest: bool) -> Vec<String> {
        // Rendering this template into a `String` cannot fail.
        let language = Language::named(&self.language).unwrap_or(Language::ENGLISH);
        let text = words::within(language, || StationTerms { terms: self, guest }.render()).unwrap_or_default();
        text.lines().map(str::trim).filter(|line| !line.is_empty()).map(str::to_owned).collect()
    }
}

/// A page of the form.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "surveys/form.html")]
pub struct FormPage {
    /// Code of the language.
    pub language: String,
    /// Title of the survey.
    pub title: String,
    /// Heading and text of the page.
    pub heading: Option<(String, String)>,
    /// Number of this page, from 1, and number of pages.
    pub step: (usize, usize),
    /// Answers are sent from this page.
    pub is_last: bool,
    /// Place of this page in the instrument.
    pub page: usize,
    /// Questions on this page.
    pub questions: Vec<FormQuestion>,
    /// Address to which the form is submitted.
    pub action: String,
    /// Set if the author previews the page; nothing can be submitted then.
    pub preview: Option<FormPreview>,
}

/// The final page: answers were submitted, or withdrawn.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "surveys/end.html")]
pub struct EndPage {
    /// Code of the language.
    pub language: String,
    /// Title of the survey.
    pub title: String,
    /// Result of the submission or withdrawal.
    pub end: SurveyEnd,
    /// Whether answers can be traced to the respondent.
    pub identity: Identity,
    /// Address that withdraws the answers.
    pub action: String,
}

/// Result of a submission or withdrawal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurveyEnd {
    /// The answers were submitted.
    Sent,
    /// The answers were withdrawn and deleted.
    Withdrawn,
    /// Nothing was submitted, and answers begun were deleted.
    Discarded,
}

/// A question as displayed.
#[derive(Clone, Debug, PartialEq)]
pub struct FormQuestion {
    /// Name of the field.
    pub name: String,
    /// Short name.
    pub short: Option<String>,
    /// Text of the question.
    pub text: String,
    /// Input of the answer.
    pub field: QuestionField,
    /// Why the answer was refused.
    pub refusal: Option<String>,
    /// Name of the checkbox that skips the question on purpose, if that is offered, and whether it
    /// is ticked.
    pub leaving: Option<(String, bool)>,
}

/// Input of an answer.
#[derive(Clone, Debug, PartialEq)]
pub enum QuestionField {
    /// A row of points between two ends.
    Row {
        /// CSS class for the number of points.
        class: &'static str,
        /// The points.
        points: Vec<AnswerChoice>,
        /// Labels of the ends.
        ends: Option<(String, String)>,
    },
    /// A list to choose one from.
    One(Vec<AnswerChoice>),
    /// A list to choose several from.
    Several(Vec<AnswerChoice>),
    /// A number.
    Number {
        /// Current input.
        value: String,
        /// Description of the allowed values.
        allowed: String,
    },
    /// A text.
    Text {
        /// Current input.
        value: String,
        /// Maximum length, in characters.
        most: usize,
    },
}

/// An option of an answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AnswerChoice {
    /// Value sent by the form.
    pub value: String,
    /// Label shown to the reader.
    pub label: String,
    /// Whether it is selected.
    pub checked: bool,
}

/// Renders a page of the form in the language of its questions, or in English if the pages are not
/// translated into it.
pub fn respond_in_language(language: &str, page: impl IntoResponse) -> Response {
    speak_language(language, || page.into_response())
}

/// Runs a closure in the language of a form's questions, or in English if the pages are not
/// translated into it.
pub fn speak_language<T>(language: &str, say: impl FnOnce() -> T) -> T {
    words::within(Language::named(language).unwrap_or(Language::ENGLISH), say)
}

impl FormPage {
    /// Returns the number of refused answers.
    #[must_use]
    pub fn refused(&self) -> usize {
        self.questions.iter().filter(|question| question.refusal.is_some()).count()
    }

    /// The address of the script that saves while one answers.
    #[must_use]
    pub fn script(&self) -> String {
        assets::asset_address("survey.js")
    }
}

/// Refused answers: index of the item, the input and the reason.
#[derive(Clone, Debug, Default)]
pub struct Refusals(Vec<(usize, String, String)>);

impl Refusals {
    /// Creates refusals for items that were left blank by mistake.
    #[must_use]
    pub fn of_blanks(items: &[usize]) -> Self {
        let why = tr!("No answer. Choose one, or tick the box to skip the question.");
        Self(items.iter().map(|at| (*at, String::new(), why.to_owned())).collect())
    }

    /// Creates refusals in the current language, from the fields of a form and the refused answers
    /// by index of the item.
    #[must_use]
    pub fn new(instrument: &Instrument, given: &GivenAnswers, refused: &[(usize, Refused)]) -> Self {
        let typed = |at: usize| {
            let texts = given.texts_for(&instrument.items[at]);
            texts.first().map_or_else(String::new, |text| (*text).to_owned())
        };
        Self(refused.iter().map(|(at, why)| (*at, typed(*at), words::phrase(&why.phrase()))).collect())
    }

    /// Returns the input that was refused for an item, and the reason.
    #[must_use]
    pub fn at(&self, item: usize) -> Option<(String, String)> {
        self.0.iter().find(|(at, ..)| *at == item).map(|(_, typed, why)| (typed.clone(), why.clone()))
    }
}

/// State of an answer: the input if it was refused, else the answer so far.
#[derive(Clone, Debug, Default)]
pub struct GivenField<'a> {
    /// Answer so far.
    pub answer: Option<&'a Answer>,
    /// Input that was refused, and the reason.
    pub refused: Option<(String, String)>,
    /// `None` if the question cannot be skipped, else whether it is skipped.
    pub left_out: Option<bool>,
}

impl FormQuestion {
    /// Creates a question of an instrument.
    #[must_use]
    pub fn new(instrument: &Instrument, item: &Item, language: &str, given: &GivenField<'_>) -> Self {
        let read = |words: &Words| words.in_language(language).to_owned();
        let field = instrument.scale(item).map(|scale| AskedText { instrument, item, language }.field(scale, given));
        Self {
            name: name_of_field(item),
            short: item.name.as_ref().map(read),
            text: read(&item.text),
            field: field.unwrap_or(QuestionField::Several(Vec::new())),
            refusal: given.refused.as_ref().map(|(_, why)| why.clone()),
            leaving: given.left_out.map(|ticked| (name_of_leaving(item), ticked)),
        }
    }
}

impl FormQuestion {
    /// Returns the answer in words: of a point at an end of a row, the meaning of that end. Empty
    /// without an answer.
    #[must_use]
    pub fn say_answer(&self) -> String {
        let chosen = |choices: &[AnswerChoice]| {
            let labels: Vec<&str> =
                choices.iter().filter(|choice| choice.checked).map(|choice| choice.label.as_str()).collect();
            labels.join(", ")
        };
        match &self.field {
            QuestionField::Row { points, ends: Some((first, last)), .. } => {
                match points.iter().position(|point| point.checked) {
                    Some(0) if !first.is_empty() => first.clone(),
                    Some(at) if at + 1 == points.len() && !last.is_empty() => last.clone(),
                    _ => chosen(points),
                }
            }
            QuestionField::Row { points, .. } => chosen(points),
            QuestionField::One(choices) | QuestionField::Several(choices) => chosen(choices),
            QuestionField::Number { value, .. } | QuestionField::Text { value, .. } => value.clone(),
        }
    }
}

struct AskedText<'a> {
    instrument: &'a Instrument,
    item: &'a Item,
    language: &'a str,
}

impl AskedText<'_> {
    fn read(&self, words: &Words) -> String {
        words.in_language(self.language).to_owned()
    }

    fn ends(&self, first: Option<&Words>, last: Option<&Words>) -> Option<(String, String)> {
        (first.is_some() || last.is_some()).then(|| {
            (first.map_or_else(String::new, |w| self.read(w)), last.map_or_else(String::new, |w| self.read(w)))
        })
    }

    fn field(&self, scale: &ScaleKind, given: &GivenField<'_>) -> QuestionField {
        let typed =
            || given.refused.as_ref().map(|(typed, _)| typed.clone()).or_else(|| given.answer.map(field_as_written));
        match scale {
            ScaleKind::Likert { points, labels, first, last, .. } => {
                let marks = (1..=*points).map(f64::from).collect();
                let row = self.row(marks, self.ends(first.as_ref(), last.as_ref()), given);
                if labels.is_empty() { row } else { self.labelled(row, labels) }
            }
            ScaleKind::Slider { min, max, step, first, last } if (max - min) / step < MOST_MARKS => {
                let marks = (0..).map(|n| min + f64::from(n) * step).take_while(|mark| *mark <= max + step * 1e-6);
                self.row(marks.collect(), self.ends(first.as_ref(), last.as_ref()), given)
            }
            ScaleKind::Slider { min, max, .. } => {
                QuestionField::Number { value: typed().unwrap_or_default(), allowed: format!("{min} – {max}") }
            }
            ScaleKind::Number { min, max, unit } => QuestionField::Number {
                value: typed().unwrap_or_default(),
                allowed: format!("{min} – {max} {}", say_unit(unit)),
            },
            ScaleKind::Pair => {
                let named =
                    |id: &String| self.instrument.item(id).map(|(_, item)| (id.clone(), self.read(item.short())));
                field_of_one(self.item.pair.iter().filter_map(named), given)
            }
            ScaleKind::Choice { options } => {
                field_of_one(options.iter().map(|option| (option.id.clone(), self.read(&option.text))), given)
            }
            ScaleKind::Choices { options } => {
                let chosen = |id: &String| matches!(given.answer, Some(Answer::Several(ids)) if ids.contains(id));
                let choice = |option: &documents::instrument::ChoiceOption| AnswerChoice {
                    value: option.id.clone(),
                    label: self.read(&option.text),
                    checked: chosen(&option.id),
                };
                QuestionField::Several(options.iter().map(choice).collect())
            }
            ScaleKind::Text { max_characters } => {
                QuestionField::Text { value: typed().unwrap_or_default(), most: *max_characters }
            }
        }
    }

    fn row(&self, marks: Vec<f64>, ends: Option<(String, String)>, given: &GivenField<'_>) -> QuestionField {
        let chosen = given.answer.and_then(Answer::number);
        let point = |mark: f64| AnswerChoice {
            value: mark.to_string(),
            label: format::format_stated(mark, ""),
            checked: chosen.is_some_and(|chosen| (chosen - mark).abs() < 1e-9),
        };
        let class = if marks.len() > 11 { "marks" } else { "points" };
        let points: Vec<AnswerChoice> = marks.into_iter().map(point).collect();
        match (ends, <[AnswerChoice; 2]>::try_from(points)) {
            // Two points are nothing but their ends, as in a checklist.
            (Some((low, high)), Ok([first, last])) if !low.is_empty() && !high.is_empty() => {
                let named = [AnswerChoice { label: low, ..first }, AnswerChoice { label: high, ..last }];
                QuestionField::One(named.into())
            }
            (ends, Ok(two)) => QuestionField::Row { class, points: two.into(), ends },
            (ends, Err(points)) => QuestionField::Row { class, points, ends },
        }
    }

    /// Turns points that have labels of their own into a list.
    fn labelled(&self, row: QuestionField, labels: &[Words]) -> QuestionField {
        let QuestionField::Row { points, .. } = row else { return row };
        let options = points.into_iter().zip(labels);
        let named = options
            .map(|(point, label)| AnswerChoice { label: format!("{} – {}", point.label, self.read(label)), ..point });
        QuestionField::One(named.collect())
    }
}

fn field_of_one(options: impl Iterator<Item = (String, String)>, given: &GivenField<'_>) -> QuestionField {
    let chosen = |id: &str| matches!(given.answer, Some(Answer::Text(text)) if text == id);
    let choice = |(value, label): (String, String)| AnswerChoice { checked: chosen(&value), value, label };
    QuestionField::One(options.map(choice).collect())
}

/// Returns an answer as the user would enter it.
fn field_as_written(answer: &Answer) -> String {
    match answer {
        Answer::Number(number) => number.to_string(),
        Answer::Text(text) => text.clone(),
        Answer::Several(ids) => ids.join(" "),
    }
}
