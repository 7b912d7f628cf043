//! Parses answers from form values and checks them against the response scale.

use std::fmt::{self, Formatter};

use documents::instrument::{Condition, Instrument, Item, ScaleKind};
use phrase::{Phrase, phrase};
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// An answer to an item. The answers of a response are in the order of the instrument's items,
/// `None` for items without an answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Answer {
    /// A point, a mark or a number, in the scale's unit.
    Number(f64),
    /// The id of an option or of an item, or a free text.
    Text(String),
    /// Ids of options.
    Several(Vec<String>),
}

impl Answer {
    /// Returns the number of a numeric answer.
    #[must_use]
    pub const fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Text(_) | Self::Several(_) => None,
        }
    }

    /// Returns the texts that a condition is compared with.
    fn words(&self) -> Vec<String> {
        match self {
            Self::Number(number) => vec![number.to_string()],
            Self::Text(text) => vec![text.clone()],
            Self::Several(ids) => ids.clone(),
        }
    }
}

/// Implemented by hand: the derived implementation for an untagged enum copies each value first,
/// and results contain hundreds of thousands.
impl<'de> Deserialize<'de> for Answer {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(AnswerReader)
    }
}

struct AnswerReader;

impl<'de> Visitor<'de> for AnswerReader {
    type Value = Answer;

    fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("a number, a text or a list of texts")
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Answer, E> {
        Ok(Answer::Number(number))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Answer, E> {
        Ok(Answer::Number(number as f64))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Answer, E> {
        Ok(Answer::Number(number as f64))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Answer, E> {
        Ok(Answer::Text(text.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Answer, A::Error> {
        let mut ids = Vec::new();
        while let Some(id) = list.next_element()? {
            ids.push(id);
        }
        Ok(Answer::Several(ids))
    }
}

/// An answer that its scale does not allow.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}", self.phrase())]
pub struct Refused {
    /// The value, shortened; for a text that is too long, its length.
    pub found: Found,
    /// The allowed values.
    pub allowed: Allowed,
}

/// The refused value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Found {
    /// Its beginning, in quotes.
    Said(String),
    /// Its length in characters.
    Characters(usize),
}

/// The values that a scale allows.
#[derive(Clone, Debug, PartialEq)]
pub enum Allowed {
    /// An integer from 1 to this.
    Points(u32),
    /// Minimum, maximum and step.
    Steps(f64, f64, f64),
    /// Minimum, maximum and unit.
    Range(f64, f64, String),
    /// One of these options.
    OneOf(Vec<String>),
    /// A text of at most this many characters.
    Characters(usize),
}

impl Refused {
    /// Returns the translatable message.
    #[must_use]
    pub fn phrase(&self) -> Phrase {
        phrase!("{found}; allowed: {allowed}", found = self.found.phrase(), allowed = self.allowed.phrase())
    }

    fn new(found: &str, allowed: Allowed) -> Self {
        let short: String = found.chars().take(60).collect();
        let end = if short.len() < found.len() { "…" } else { "" };
        Self { found: Found::Said(format!("\"{short}{end}\"")), allowed }
    }
}

/// Formats a bound as the instrument's author wrote it, with its unit.
fn stated(value: f64, unit: &str) -> Phrase {
    let number = value.to_string();
    Phrase::Number(match unit {
        "" | "1" | "count" => number,
        "°" => number + unit,
        unit => format!("{number}\u{a0}{unit}"),
    })
}

impl Found {
    fn phrase(&self) -> Phrase {
        match self {
            Self::Said(said) => Phrase::data(said),
            Self::Characters(count) => phrase!("{n} characters", n = *count),
        }
    }
}

impl Allowed {
    fn phrase(&self) -> Phrase {
        match self {
            Self::Points(most) => phrase!("a whole number from 1 to {most}", most = i64::from(*most)),
            Self::Steps(min, max, step) => {
                let [min, max, step] = [min, max, step].map(|value| stated(*value, ""));
                phrase!("{min} to {max} in steps of {step}", min = min, max = max, step = step)
            }
            Self::Range(min, max, unit) => {
                phrase!("a number from {min} to {max}", min = stated(*min, ""), max = stated(*max, unit))
            }
            Self::OneOf(ids) => Phrase::data(ids.join(", ")),
            Self::Characters(most) => phrase!("at most {most} characters", most = *most),
        }
    }
}

/// Parses an answer from an item's form values; `None` for an empty answer.
///
/// # Errors
/// If the scale does not allow it.
pub fn read_answer(item: &Item, scale: &ScaleKind, said: &[&str]) -> Result<Option<Answer>, Refused> {
    let said: Vec<&str> = said.iter().copied().filter(|value| !value.trim().is_empty()).collect();
    let Some(first) = said.first() else { return Ok(None) };
    let answer = match scale {
        ScaleKind::Likert { points, .. } => read_whole_number(first, *points)?,
        ScaleKind::Slider { min, max, step, .. } => read_scale_mark(first, *min, *max, *step)?,
        ScaleKind::Number { min, max, unit } => read_number(first, *min, *max, unit)?,
        ScaleKind::Pair => Answer::Text(read_one_option(first, item.pair.iter().map(String::as_str))?),
        ScaleKind::Choice { options } => Answer::Text(read_one_option(first, options.iter().map(|o| o.id.as_str()))?),
        ScaleKind::Choices { options } => {
            let chosen = said.iter().map(|id| read_one_option(id, options.iter().map(|o| o.id.as_str())));
            let mut chosen = chosen.collect::<Result<Vec<_>, _>>()?;
            chosen.sort();
            chosen.dedup();
            Answer::Several(chosen)
        }
        ScaleKind::Text { max_characters } => read_text_answer(first, *max_characters)?,
    };
    Ok(Some(answer))
}

fn parse_finite(said: &str) -> Option<f64> {
    // Accept a decimal comma, as used in much of Europe.
    said.trim().replace(',', ".").parse::<f64>().ok().filter(|number| number.is_finite())
}

fn read_whole_number(said: &str, points: u32) -> Result<Answer, Refused> {
    let point = said.trim().parse::<u32>().ok().filter(|point| (1..=points).contains(point));
    point.map(|point| Answer::Number(f64::from(point))).ok_or_else(|| Refused::new(said, Allowed::Points(points)))
}

fn read_scale_mark(said: &str, min: f64, max: f64, step: f64) -> Result<Answer, Refused> {
    let on_a_step = |number: &f64| {
        let steps = (number - min) / step;
        (min..=max).contains(number) && (steps - steps.round()).abs() < 1e-6
    };
    parse_finite(said)
        .filter(on_a_step)
        .map(Answer::Number)
        .ok_or_else(|| Refused::new(said, Allowed::Steps(min, max, step)))
}

fn read_number(said: &str, min: f64, max: f64, unit: &str) -> Result<Answer, Refused> {
    parse_finite(said)
        .filter(|number| (min..=max).contains(number))
        .map(Answer::Number)
        .ok_or_else(|| Refused::new(said, Allowed::Range(min, max, unit.to_owned())))
}

fn read_one_option<'a>(said: &str, ids: impl Iterator<Item = &'a str> + Clone) -> Result<String, Refused> {
    let found = ids.clone().find(|id| *id == said);
    found.map(str::to_owned).ok_or_else(|| Refused::new(said, Allowed::OneOf(ids.map(str::to_owned).collect())))
}

fn read_text_answer(said: &str, most: usize) -> Result<Answer, Refused> {
    // Forms send line breaks as CRLF, which would count twice against the limit.
    let plain = said.replace("\r\n", "\n");
    let length = plain.chars().count();
    if length > most {
        return Err(Refused { found: Found::Characters(length), allowed: Allowed::Characters(most) });
    }
    Ok(Answer::Text(plain))
}

/// Returns whether a condition holds; `true` without a condition.
#[must_use]
pub fn is_asked(instrument: &Instrument, when: Option<&Condition>, answers: &[Option<Answer>]) -> bool {
    let Some(when) = when else { return true };
    let given = instrument.item(&when.item).and_then(|(at, _)| answers.get(at)?.as_ref());
    given.is_some_and(|answer| answer.words().iter().any(|word| when.is.contains(word)))
}

/// Returns the pages to show, given the answers so far: the index of each, and the indices of its
/// items to ask.
#[must_use]
pub fn asked_pages(instrument: &Instrument, answers: &[Option<Answer>]) -> Vec<(usize, Vec<usize>)> {
    let asked = |when: Option<&Condition>| is_asked(instrument, when, answers);
    let pages = instrument.pages().into_iter().enumerate();
    let pages = pages
        .filter(|(_, (section, items))| !items.is_empty() && asked(section.and_then(|section| section.when.as_ref())));
    let of = |items: Vec<usize>| items.into_iter().filter(|at| asked(instrument.items[*at].when.as_ref())).collect();
    pages.map(|(at, (_, items))| (at, of(items))).collect()
}
