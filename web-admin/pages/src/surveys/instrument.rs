//! Instruments: the list, one with its preview, and the editor.

use askama::Template;
use askama_web::WebTemplate;
use documents::Instrument;
use model::authoring::draft::DraftVerdict;
use time::OffsetDateTime;

use super::form::{FormQuestion, GivenField, QuestionField};
use crate::form::{FilledForm, SelectOption};
use crate::format::name_facts;
use crate::{Shell, format};

/// All instruments of the school.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "surveys/instruments.html")]
pub struct InstrumentsPage {
    /// Page frame.
    pub shell: Shell,
    /// Title, address, id and publication date of each.
    pub instruments: Vec<(String, String, String, OffsetDateTime)>,
}

/// An instrument with its preview and source.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "surveys/instrument.html")]
pub struct InstrumentPage {
    /// Page frame.
    pub shell: Shell,
    /// Address of the page.
    pub href: String,
    /// Preview.
    pub preview: InstrumentPreview,
    /// Whether it has just been published.
    pub published: bool,
    /// Courses that can ask it after attempts.
    pub courses: Vec<SelectOption>,
}

/// The editor of an instrument's document as text.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "surveys/edit.html")]
pub struct EditPage {
    /// Page frame.
    pub shell: Shell,
    /// Heading of the page.
    pub heading: &'static str,
    /// Address to which the form is submitted.
    pub action: String,
    /// The form with the document, TOML or JSON, and its problems, one per line.
    pub form: FilledForm<String, Vec<String>>,
    /// Preview, if there are no problems.
    pub preview: Option<InstrumentPreview>,
}

/// Preview of an instrument as respondents see it.
#[derive(Clone, Debug)]
pub struct InstrumentPreview {
    /// Title.
    pub title: String,
    /// Id.
    pub id: String,
    /// Names of the languages, each in that language.
    pub languages: String,
    /// Duration, in min.
    pub duration_min: f64,
    /// Authors and publication.
    pub source: String,
    /// Licence terms.
    pub licence: String,
    /// Heading and questions of each page.
    pub pages: Vec<(String, Vec<FormQuestion>)>,
    /// Title and rule of each score.
    pub scores: Vec<(String, String)>,
}

impl InstrumentPreview {
    /// Builds a preview in the reader's language if the instrument has it, else in its own.
    #[must_use]
    pub fn new(instrument: &Instrument) -> Self {
        let language = instrument.language_for(words::current().code());
        let question =
            |at: &usize| FormQuestion::new(instrument, &instrument.items[*at], language, &GivenField::default());
        let page = |(section, items): (Option<&documents::instrument::Section>, Vec<usize>)| {
            let heading = section.map_or_else(String::new, |section| section.title.in_language(language).to_owned());
            (heading, items.iter().map(question).collect())
        };
        Self {
            title: instrument.title.in_language(language).to_owned(),
            id: instrument.id.clone(),
            languages: instrument.languages.iter().map(|code| words::own_name(code)).collect::<Vec<_>>().join(", "),
            duration_min: instrument.duration_min,
            source: instrument.source.clone(),
            licence: instrument.licence.clone(),
            pages: instrument.pages().into_iter().map(page).collect(),
            scores: instrument
                .scores
                .iter()
                .map(|key| (key.title.in_language(language).to_owned(), say_scoring_rule(key)))
                .collect(),
        }
    }
}

/// Returns the verdict on an instrument that can be published.
#[must_use]
pub fn verdict_of_instrument(instrument: &Instrument) -> DraftVerdict {
    let language = instrument.language_for(words::current().code());
    let preview = InstrumentPreview::new(instrument);
    let mut facts = name_facts(vec![
        (tr!("Title"), instrument.title.in_language(language).to_owned()),
        (tr!("Languages"), preview.languages),
        (tr!("Questions"), instrument.items.len().to_string()),
        (tr!("Pages"), instrument.pages().len().to_string()),
        (tr!("Duration"), format::format_stated(instrument.duration_min, "min")),
    ]);
    let scored =
        instrument.scores.iter().map(|key| (key.title.in_language(language).to_owned(), say_scoring_rule(key)));
    facts.extend(scored);
    DraftVerdict { facts, ..DraftVerdict::default() }
}

/// Describes a scoring key as arithmetic.
fn say_scoring_rule(key: &documents::instrument::ScoreKey) -> String {
    use documents::instrument::{Combine, Missing};
    let items = key.items.len();
    let mut words = match key.combine {
        Combine::Sum => trn!("sum of {n} item", "sum of {n} items", items),
        Combine::Mean => trn!("mean of {n} item", "mean of {n} items", items),
        Combine::PairWeighted => {
            trn!("mean, weighted by the pairs, of {n} item", "mean, weighted by the pairs, of {n} items", items)
        }
    };
    if !key.reversed.is_empty() {
        words += &format!(", {}", tr!("{count} reversed", count = key.reversed.len()));
    }
    if key.shift != 0.0 {
        words += &format!(", {}", tr!("each {shift}", shift = format!("{:+}", key.shift)));
    }
    if (key.factor - 1.0).abs() > 0.0 {
        words += &format!(", × {}", key.factor);
    }
    if key.offset != 0.0 {
        words += &format!(", {:+}", key.offset);
    }
    match (key.missing, key.least_answered) {
        (Missing::MeanOfAnswered, Some(least)) => {
            words + "; " + &tr!("at least {least} must be answered", least = least)
        }
        _ => words + "; " + tr!("no score where one is missing"),
    }
}
