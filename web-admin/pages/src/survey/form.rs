//! The form of an instrument: questions as fields, in the language of whoever answers.

use askama::Template;
use askama_web::WebTemplate;
use assessment::questionnaire::{Answer, Refused};
use axum::response::{IntoResponse, Response};
use documents::Instrument;
use documents::instrument::{Item, ScaleKind, Words};
use model::survey::Identity;
use model::survey::given::{GivenAnswers, name_of_field, name_of_leaving};
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

/// Before the first question: what is asked, what becomes of it, and whether one agrees.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "survey/consent.html")]
pub struct ConsentPage {
    /// What everybody is told.
    pub terms: Terms,
    /// Where the form is sent.
    pub action: String,
    /// Fields that go along unseen.
    pub hidden: Vec<(&'static str, String)>,
    /// Codes and addresses of the languages.
    pub languages: Vec<(String, String)>,
    /// The box was not ticked.
    pub refused: bool,
    /// Answers were begun or sent already: nothing is to be agreed to again.
    pub begun: bool,
}

/// What somebody is told before the first question.
#[derive(Clone, Debug)]
pub struct Terms {
    /// Code of the language.
    pub language: String,
    /// The survey's title.
    pub title: String,
    /// What the instrument says of itself.
    pub intro: String,
    /// How long it takes, in min.
    pub duration_min: f64,
    /// How many questions there are.
    pub questions: usize,
    /// Whether answers lead to who gave them.
    pub identity: Identity,
    /// It is asked after an attempt.
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

/// What somebody is told at a station before the first question: a paragraph a line.
#[derive(Debug, Template)]
#[template(path = "survey/station.txt")]
struct StationTerms<'a> {
    terms: &'a Terms,
    /// A guest of a study has no page at the school.
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
    /// What somebody is told at a station before the first question, paragraph by paragraph. A guest of a study has no page at the
    /// school, where their answers could wait.
    #[must_use]
    pub fn at_a_station(&self, guest: bool) -> Vec<String> {
        // Rendering into a String fails for no data we can hold.
        let language = Language::named(&self.language).unwrap_or(Language::ENGLISH);
        let text = words::within(language, || StationTerms { terms: self, guest }.render()).unwrap_or_default();
        text.lines().map(str::trim).filter(|line| !line.is_empty()).map(str::to_owned).collect()
    }
}

/// A page of the form.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "survey/form.html")]
pub struct FormPage {
    /// Code of the language.
    pub language: String,
    /// The survey's title.
    pub title: String,
    /// The page's heading and text.
    pub heading: Option<(String, String)>,
    /// Number of this page, and how many there are.
    pub step: (usize, usize),
    /// Answers are sent from this page.
    pub is_last: bool,
    /// Place of this page in the instrument.
    pub page: usize,
    /// Its questions.
    pub questions: Vec<FormQuestion>,
    /// Where the form is sent.
    pub action: String,
    /// Its author looks at it, and nobody answers.
    pub preview: Option<FormPreview>,
}

/// The end: answers were sent, or taken back.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "survey/end.html")]
pub struct EndPage {
    /// Code of the language.
    pub language: String,
    /// The survey's title.
    pub title: String,
    /// What became of the answers.
    pub end: SurveyEnd,
    /// Whether answers lead to who gave them.
    pub identity: Identity,
    /// Where taking back is asked for.
    pub action: String,
}

/// What became of answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurveyEnd {
    /// They were sent.
    Sent,
    /// They were taken back, and are gone.
    Withdrawn,
    /// Nothing was sent, and nothing is left of what was begun.
    Discarded,
}

/// A question as it is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct FormQuestion {
    /// Name of its field.
    pub name: String,
    /// Its short name.
    pub short: Option<String>,
    /// The question.
    pub text: String,
    /// How it is answered.
    pub field: QuestionField,
    /// What is wrong with what was typed.
    pub refusal: Option<String>,
    /// Name of the box by which it is left without an answer on purpose, where that is offered, and whether it is ticked.
    pub leaving: Option<(String, bool)>,
}

/// How a question is answered.
#[derive(Clone, Debug, PartialEq)]
pub enum QuestionField {
    /// A row of points between two ends.
    Row {
        /// Class for so many points.
        class: &'static str,
        /// The points.
        points: Vec<AnswerChoice>,
        /// What the ends mean.
        ends: Option<(String, String)>,
    },
    /// A list to choose one from.
    One(Vec<AnswerChoice>),
    /// A list to choose several from.
    Several(Vec<AnswerChoice>),
    /// A number.
    Number {
        /// What was typed.
        value: String,
        /// What is allowed, in words.
        allowed: String,
    },
    /// A text.
    Text {
        /// What was typed.
        value: String,
        /// How long it may be, in characters.
        most: usize,
    },
}

/// Something to choose.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AnswerChoice {
    /// What is sent.
    pub value: String,
    /// What is read.
    pub label: String,
    /// It is chosen.
    pub checked: bool,
}

/// Shows a page of the form in the language that its questions are asked in, or in English where the pages have not that
/// one.
pub fn respond_in_language(language: &str, page: impl IntoResponse) -> Response {
    speak_language(language, || page.into_response())
}

/// Says what belongs on a page of the form in the language of its questions.
pub fn speak_language<T>(language: &str, say: impl FnOnce() -> T) -> T {
    words::within(Language::named(language).unwrap_or(Language::ENGLISH), say)
}

impl FormPage {
    /// How many questions were refused.
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

/// Answers that were refused: the item's place, what was typed and the reason.
#[derive(Clone, Debug, Default)]
pub struct Refusals(Vec<(usize, String, String)>);

impl Refusals {
    /// Items that were left without an answer by oversight.
    #[must_use]
    pub fn of_blanks(items: &[usize]) -> Self {
        let why = tr!("No answer. Choose one, or tick that you leave it out.");
        Self(items.iter().map(|at| (*at, String::new(), why.to_owned())).collect())
    }

    /// In the language that is spoken here, from the fields of a form and what was refused of them, by the item's place.
    #[must_use]
    pub fn new(instrument: &Instrument, given: &GivenAnswers, refused: &[(usize, Refused)]) -> Self {
        let typed = |at: usize| {
            let texts = given.texts_for(&instrument.items[at]);
            texts.first().map_or_else(String::new, |text| (*text).to_owned())
        };
        Self(refused.iter().map(|(at, why)| (*at, typed(*at), words::phrase(&why.phrase()))).collect())
    }

    /// What was typed at an item's place and refused, and why.
    #[must_use]
    pub fn at(&self, item: usize) -> Option<(String, String)> {
        self.0.iter().find(|(at, ..)| *at == item).map(|(_, typed, why)| (typed.clone(), why.clone()))
    }
}

/// What was typed for an item, where it was refused; else the answer so far.
#[derive(Clone, Debug, Default)]
pub struct GivenField<'a> {
    /// The answer so far.
    pub answer: Option<&'a Answer>,
    /// What was typed and refused, and why.
    pub refused: Option<(String, String)>,
    /// It may be left without an answer on purpose: whether it is.
    pub left_out: Option<bool>,
}

impl FormQuestion {
    /// A question of an instrument.
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
        QuestionField::Row { class, points: marks.into_iter().map(point).collect(), ends }
    }

    /// Points with a label each read as a list.
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

/// An answer as it is typed.
fn field_as_written(answer: &Answer) -> String {
    match answer {
        Answer::Number(number) => number.to_string(),
        Answer::Text(text) => text.clone(),
        Answer::Several(ids) => ids.join(" "),
    }
}
