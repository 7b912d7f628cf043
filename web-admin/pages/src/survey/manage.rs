//! Surveys as a list, and one of them for those who asked.

use askama::Template;
use askama_web::WebTemplate;
use model::limits::LETTERS_AN_HOUR;
use model::mail::LetterDelivery;
use model::survey::Identity;
use serde::Deserialize;
use time::OffsetDateTime;

use super::identity_words;
use crate::form::{FilledForm, read_ticked_box, read_trimmed_text};
use crate::{Shell, StatusWord, format};

/// `/surveys`: what is asked of a trainee, or what the school asks.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "survey/list.html")]
pub struct SurveysPage {
    /// Frame.
    pub shell: Shell,
    /// Surveys that the visitor may answer.
    pub asked: Vec<OwnSurveyRow>,
    /// Surveys of the school, for those who teach.
    pub surveys: Option<Vec<SurveyRow>>,
}

/// A survey that somebody is asked to answer.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnSurveyRow {
    /// Its title.
    pub title: String,
    /// Where it is answered.
    pub href: String,
    /// How long it takes, in min.
    pub duration_min: f64,
    /// It was answered.
    pub answered: bool,
    /// Until when.
    pub closes_at: Option<OffsetDateTime>,
}

/// A survey in the school's list.
#[derive(Clone, Debug, PartialEq)]
pub struct SurveyRow {
    /// Its title.
    pub title: String,
    /// Its page.
    pub href: String,
    /// The instrument's title.
    pub instrument: String,
    /// It can be answered now.
    pub open: bool,
    /// The answers were made by a program.
    pub generated: bool,
    /// When it was made.
    pub created_at: OffsetDateTime,
}

/// A survey, for those who asked.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "survey/manage.html")]
pub struct ManagePage {
    /// Frame.
    pub shell: Shell,
    /// Title.
    pub title: String,
    /// Its address.
    pub href: String,
    /// The instrument's title, and its page.
    pub instrument: (String, String),
    /// Whether answers lead to who gave them.
    pub identity: Identity,
    /// What else is known: name and value.
    pub facts: Vec<(&'static str, String)>,
    /// It can be answered now.
    pub open: bool,
    /// The visitor may make links, close and open.
    pub owner: bool,
    /// The list of those who get links.
    pub labels: FilledForm<String>,
    /// Letters with links that may still go out now.
    pub letters_left: usize,
    /// How letters with links went.
    pub letters: Vec<LetterDelivery>,
    /// Letters that were just queued, and people who had been written to before.
    pub mailed: Option<(usize, usize)>,
}

/// Links, shown this once.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "survey/links.html")]
pub struct SurveyLinksPage {
    /// Frame.
    pub shell: Shell,
    /// The survey's title.
    pub title: String,
    /// The survey's page.
    pub href: String,
    /// Whom each is for, and its address.
    pub links: Vec<(String, String)>,
}

/// The form of a new survey.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "survey/new.html")]
pub struct NewSurveyPage {
    /// Frame.
    pub shell: Shell,
    /// Id, title and whether it is chosen, of each instrument.
    pub instruments: Vec<(String, String, bool)>,
    /// Id, name and whether it is chosen, of each cohort.
    pub cohorts: Vec<(String, String, bool)>,
    /// What is typed.
    pub form: FilledForm<NewSurveyForm>,
}

/// The fields of a new survey.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct NewSurveyForm {
    /// The instrument's id.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub instrument: String,
    /// Title.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub title: String,
    /// The word for the identity.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub identity: String,
    /// Asked after each attempt.
    #[serde(deserialize_with = "read_ticked_box")]
    pub after_attempts: bool,
    /// Hours after an attempt.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub fresh: String,
    /// Ids of cohorts.
    #[serde(rename = "cohort")]
    pub cohorts: Vec<String>,
    /// First day.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub opens: String,
    /// Last day.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub closes: String,
}

impl ManagePage {
    /// What leads from an answer to a person.
    #[must_use]
    pub fn identity_words(&self) -> &'static str {
        identity_words(self.identity)
    }
}

impl SurveyLinksPage {
    /// All links, one a line, to be copied.
    #[must_use]
    pub fn lines(&self) -> String {
        self.links.iter().map(|(label, href)| format!("{label}\t{href}")).collect::<Vec<_>>().join("\n")
    }
}
