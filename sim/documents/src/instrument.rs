//! Instruments: questionnaires, their response scales and scoring keys.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::wording::Wording;

/// A text in each language of its instrument.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Words(BTreeMap<String, String>);

impl Words {
    /// Returns the text in a language, or in any other of its languages.
    #[must_use]
    pub fn in_language(&self, language: &str) -> &str {
        self.0.get(language).or_else(|| self.0.values().next()).map_or("", String::as_str)
    }

    /// Converts to the text of a document in the language `own`, with the other languages as
    /// translations.
    #[must_use]
    pub fn as_wording(&self, own: &str) -> Wording {
        let others = self.0.iter().filter(|(language, _)| *language != own);
        let others = others.map(|(language, text)| (language.clone(), text.clone())).collect();
        Wording::new(self.in_language(own).to_owned(), others)
    }
}

/// An instrument.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Instrument {
    /// Identifier.
    pub id: String,
    /// Title.
    pub title: Words,
    /// Language codes; the first is the fallback for users who speak none of them.
    pub languages: Vec<String>,
    /// Introduction shown before the first question.
    pub intro: Option<Words>,
    /// Expected duration, in min.
    pub duration_min: f64,
    /// Author and publication.
    pub source: String,
    /// Terms of use.
    pub licence: String,
    /// Response scales.
    #[serde(rename = "scale")]
    pub scales: Vec<Scale>,
    /// Pages of the form, in order; empty if all items are on one page.
    #[serde(rename = "section")]
    pub sections: Vec<Section>,
    /// Questions, in order.
    #[serde(rename = "item")]
    pub items: Vec<Item>,
    /// The scoring key.
    #[serde(rename = "score")]
    pub scores: Vec<ScoreKey>,
    /// Lower-case hexadecimal SHA-256 of the document's bytes.
    #[serde(skip)]
    pub sha256: String,
}

/// A response scale.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Scale {
    /// Id that items refer to.
    pub id: String,
    /// Type of the answers.
    #[serde(flatten)]
    pub kind: ScaleKind,
}

/// Type of the answers on a scale.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum ScaleKind {
    /// A point on a rating scale, counted from 1.
    Likert {
        /// Number of points.
        points: u32,
        /// A label for each point, or empty.
        #[serde(default)]
        labels: Vec<Words>,
        /// Meaning of the low end.
        first: Option<Words>,
        /// Meaning of the high end.
        last: Option<Words>,
        /// Smallest answer that counts an item as relevant, for content validity.
        relevant_from: Option<u32>,
    },
    /// A mark on a line.
    Slider {
        /// Minimum.
        min: f64,
        /// Maximum.
        max: f64,
        /// Step between answers.
        step: f64,
        /// Meaning of the low end.
        first: Option<Words>,
        /// Meaning of the high end.
        last: Option<Words>,
    },
    /// The id of one of two items.
    Pair,
    /// The id of one option.
    Choice {
        /// The options.
        #[serde(rename = "option")]
        options: Vec<ChoiceOption>,
    },
    /// The ids of several options.
    Choices {
        /// The options.
        #[serde(rename = "option")]
        options: Vec<ChoiceOption>,
    },
    /// A number.
    Number {
        /// Minimum.
        min: f64,
        /// Maximum.
        max: f64,
        /// Unit.
        unit: String,
    },
    /// A text.
    Text {
        /// Maximum length, in characters.
        max_characters: usize,
    },
}

impl ScaleKind {
    /// Returns the minimum and maximum of numeric answers.
    #[must_use]
    pub fn range(&self) -> Option<(f64, f64)> {
        match self {
            Self::Likert { points, .. } => Some((1.0, f64::from(*points))),
            Self::Slider { min, max, .. } | Self::Number { min, max, .. } => Some((*min, *max)),
            Self::Pair | Self::Choice { .. } | Self::Choices { .. } | Self::Text { .. } => None,
        }
    }

    /// Returns the options, or an empty slice.
    #[must_use]
    pub fn options(&self) -> &[ChoiceOption] {
        match self {
            Self::Choice { options } | Self::Choices { options } => options,
            _ => &[],
        }
    }

    /// Returns the keyword in documents.
    #[must_use]
    pub const fn word(&self) -> &'static str {
        match self {
            Self::Likert { .. } => "likert",
            Self::Slider { .. } => "slider",
            Self::Pair => "pair",
            Self::Choice { .. } => "choice",
            Self::Choices { .. } => "choices",
            Self::Number { .. } => "number",
            Self::Text { .. } => "text",
        }
    }
}

/// An option.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct ChoiceOption {
    /// Stored value.
    pub id: String,
    /// Displayed text.
    pub text: Words,
}

/// A page of the form.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Section {
    /// Id that items refer to.
    pub id: String,
    /// Its heading.
    pub title: Words,
    /// Introduction shown before its questions.
    pub text: Option<Words>,
    /// Condition for showing the page.
    pub when: Option<Condition>,
}

/// A condition on an earlier answer.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Condition {
    /// The item.
    pub item: String,
    /// The answers that fulfil the condition: ids of options, or points.
    pub is: Vec<String>,
}

/// A question.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Item {
    /// Id in answers, scores and exports.
    pub id: String,
    /// Id of its section, if there are sections.
    pub section: Option<String>,
    /// A short name.
    pub name: Option<Words>,
    /// The question.
    pub text: Words,
    /// Id of the response scale.
    pub scale: String,
    /// The two items of which one is chosen.
    pub pair: Vec<String>,
    /// Condition for asking the question.
    pub when: Option<Condition>,
}

impl Item {
    /// Returns the short name, or the question without one.
    #[must_use]
    pub fn short(&self) -> &Words {
        self.name.as_ref().unwrap_or(&self.text)
    }
}

/// A score, as data.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct ScoreKey {
    /// Id in results and exports.
    pub id: String,
    /// Title.
    pub title: Words,
    /// The items that count.
    pub items: Vec<String>,
    /// Items that are reversed: minimum + maximum − answer.
    pub reversed: Vec<String>,
    /// Offset added to each item, before the items are combined.
    pub shift: f64,
    /// How the items are combined.
    pub combine: Combine,
    /// The pairs that determine the items' weights.
    pub pairs: Vec<String>,
    /// Factor by which the combination is multiplied.
    pub factor: f64,
    /// Offset added to the result.
    pub offset: f64,
    /// Treatment of an item without an answer.
    pub missing: Missing,
    /// Minimum number of answered items, if items without an answer are allowed.
    pub least_answered: Option<usize>,
    /// The favourable direction, if there is one.
    pub better: Option<Better>,
}

/// How the items of a score are combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Combine {
    /// Sum.
    Sum,
    /// Mean.
    Mean,
    /// Mean, each item weighted by how often the pairs choose it.
    PairWeighted,
}

/// Effect of an unanswered item on a score.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Missing {
    /// The score is missing.
    NoScore,
    /// The item is replaced by the mean of the answered items.
    MeanOfAnswered,
}

/// The favourable direction of a score.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Better {
    /// Higher is better.
    Higher,
    /// Lower is better.
    Lower,
}

impl Instrument {
    /// Returns the response scale of an item.
    #[must_use]
    pub fn scale(&self, item: &Item) -> Option<&ScaleKind> {
        self.scales.iter().find(|scale| scale.id == item.scale).map(|scale| &scale.kind)
    }

    /// Returns an item and its index.
    #[must_use]
    pub fn item(&self, id: &str) -> Option<(usize, &Item)> {
        self.items.iter().enumerate().find(|(_, item)| item.id == id)
    }

    /// Returns the pages, each with the indices of its items; a single page without sections.
    #[must_use]
    pub fn pages(&self) -> Vec<(Option<&Section>, Vec<usize>)> {
        if self.sections.is_empty() {
            return vec![(None, (0..self.items.len()).collect())];
        }
        let of = |section: &Section| {
            let within = |item: &Item| item.section.as_ref() == Some(&section.id);
            self.items.iter().enumerate().filter(|(_, item)| within(item)).map(|(at, _)| at).collect()
        };
        self.sections.iter().map(|section| (Some(section), of(section))).collect()
    }

    /// Returns the best language for `wanted`, a list in the form of an `Accept-Language` header.
    #[must_use]
    pub fn language_for(&self, wanted: &str) -> &str {
        let codes = wanted.split(',').map(|one| one.split([';', '-']).next().unwrap_or_default().trim());
        let known = codes.filter_map(|code| self.languages.iter().find(|language| *language == code)).next();
        known.or(self.languages.first()).map_or("en", String::as_str)
    }
}
