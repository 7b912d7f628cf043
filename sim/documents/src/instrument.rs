//! Instruments: questionnaires, how they are answered, and how the answers are scored.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::wording::Wording;

/// A text in each language of its instrument.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Words(BTreeMap<String, String>);

impl Words {
    /// The text in a language; where there is none, in any other.
    #[must_use]
    pub fn in_language(&self, language: &str) -> &str {
        self.0.get(language).or_else(|| self.0.values().next()).map_or("", String::as_str)
    }

    /// The text of a document whose own language is `own`, with what it is in the others.
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
    /// Codes of its languages; the first is for whoever speaks none of them.
    pub languages: Vec<String>,
    /// What to know before the first question.
    pub intro: Option<Words>,
    /// How long it takes, in min.
    pub duration_min: f64,
    /// Who made it, and where it was published.
    pub source: String,
    /// Under which terms it may be used.
    pub licence: String,
    /// Ways of answering.
    #[serde(rename = "scale")]
    pub scales: Vec<Scale>,
    /// Pages of the form, in order; none where all items stand on one.
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

/// A way of answering.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Scale {
    /// Name for items.
    pub id: String,
    /// What an answer is.
    #[serde(flatten)]
    pub kind: ScaleKind,
}

/// What an answer is.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum ScaleKind {
    /// A point of a row, from 1 on.
    Likert {
        /// How many points.
        points: u32,
        /// A label for each point, where there are any.
        #[serde(default)]
        labels: Vec<Words>,
        /// What the low end means.
        first: Option<Words>,
        /// What the high end means.
        last: Option<Words>,
        /// From which answer on an item counts as relevant: content validity.
        relevant_from: Option<u32>,
    },
    /// A mark on a line.
    Slider {
        /// Least answer.
        min: f64,
        /// Largest answer.
        max: f64,
        /// Distance between two answers.
        step: f64,
        /// What the low end means.
        first: Option<Words>,
        /// What the high end means.
        last: Option<Words>,
    },
    /// One of two items: its id.
    Pair,
    /// One option: its id.
    Choice {
        /// What to choose from.
        #[serde(rename = "option")]
        options: Vec<ChoiceOption>,
    },
    /// Several options: their ids.
    Choices {
        /// What to choose from.
        #[serde(rename = "option")]
        options: Vec<ChoiceOption>,
    },
    /// A number.
    Number {
        /// Least answer.
        min: f64,
        /// Largest answer.
        max: f64,
        /// Its unit.
        unit: String,
    },
    /// A text.
    Text {
        /// How long it may be, in characters.
        max_characters: usize,
    },
}

impl ScaleKind {
    /// Least and largest answer, where answers are numbers.
    #[must_use]
    pub fn range(&self) -> Option<(f64, f64)> {
        match self {
            Self::Likert { points, .. } => Some((1.0, f64::from(*points))),
            Self::Slider { min, max, .. } | Self::Number { min, max, .. } => Some((*min, *max)),
            Self::Pair | Self::Choice { .. } | Self::Choices { .. } | Self::Text { .. } => None,
        }
    }

    /// What to choose from, where there are options.
    #[must_use]
    pub fn options(&self) -> &[ChoiceOption] {
        match self {
            Self::Choice { options } | Self::Choices { options } => options,
            _ => &[],
        }
    }

    /// The word for it in documents.
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

/// Something to choose.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct ChoiceOption {
    /// What is stored.
    pub id: String,
    /// What is read.
    pub text: Words,
}

/// A page of the form.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Section {
    /// Name for items.
    pub id: String,
    /// Its heading.
    pub title: Words,
    /// What to know before its questions.
    pub text: Option<Words>,
    /// Asked only after certain answers.
    pub when: Option<Condition>,
}

/// A condition on an earlier answer.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Condition {
    /// The item.
    pub item: String,
    /// The answers that fulfil it: ids of options, or points.
    pub is: Vec<String>,
}

/// A question.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Item {
    /// Name in answers, scores and exports.
    pub id: String,
    /// Its section, where there are sections.
    pub section: Option<String>,
    /// A short name.
    pub name: Option<Words>,
    /// The question.
    pub text: Words,
    /// How it is answered: the id of a scale.
    pub scale: String,
    /// Of which two items one is chosen.
    pub pair: Vec<String>,
    /// Asked only after certain answers.
    pub when: Option<Condition>,
}

impl Item {
    /// Its short name, or else the question.
    #[must_use]
    pub fn short(&self) -> &Words {
        self.name.as_ref().unwrap_or(&self.text)
    }
}

/// A score, as data.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct ScoreKey {
    /// Name in results and exports.
    pub id: String,
    /// Title.
    pub title: Words,
    /// The items that count.
    pub items: Vec<String>,
    /// Those of them that count as least + largest − answer.
    pub reversed: Vec<String>,
    /// Added to each item.
    pub shift: f64,
    /// How the items are put together.
    pub combine: Combine,
    /// The pairs that weigh the items.
    pub pairs: Vec<String>,
    /// The combination is multiplied by it.
    pub factor: f64,
    /// Added in the end.
    pub offset: f64,
    /// What an item without an answer does.
    pub missing: Missing,
    /// How many items must be answered, where one without an answer is allowed.
    pub least_answered: Option<usize>,
    /// Which end is the good one, where there is one.
    pub better: Option<Better>,
}

/// How the items of a score are put together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Combine {
    /// Their sum.
    Sum,
    /// Their mean.
    Mean,
    /// Their mean, each weighing how often the pairs choose it.
    PairWeighted,
}

/// What an item without an answer does to a score.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Missing {
    /// There is no score.
    NoScore,
    /// It counts as the mean of those that are answered.
    MeanOfAnswered,
}

/// Which end of a score is the good one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Better {
    /// The high one.
    Higher,
    /// The low one.
    Lower,
}

impl Instrument {
    /// How an item is answered.
    #[must_use]
    pub fn scale(&self, item: &Item) -> Option<&ScaleKind> {
        self.scales.iter().find(|scale| scale.id == item.scale).map(|scale| &scale.kind)
    }

    /// An item and where it stands.
    #[must_use]
    pub fn item(&self, id: &str) -> Option<(usize, &Item)> {
        self.items.iter().enumerate().find(|(_, item)| item.id == id)
    }

    /// Its pages: each with the places of its items. One page holds all where there are no sections.
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

    /// The best of its languages for somebody who prefers `wanted`, as an `Accept-Language` header puts it.
    #[must_use]
    pub fn language_for(&self, wanted: &str) -> &str {
        let codes = wanted.split(',').map(|one| one.split([';', '-']).next().unwrap_or_default().trim());
        let known = codes.filter_map(|code| self.languages.iter().find(|language| *language == code)).next();
        known.or(self.languages.first()).map_or("en", String::as_str)
    }
}
