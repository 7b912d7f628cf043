//! Answers as the fields of a form bring them.

use std::collections::BTreeMap;

use documents::instrument::Item;
use serde::Deserialize;

/// What the field of an item is called in a form.
#[must_use]
pub fn name_of_field(item: &Item) -> String {
    format!("q.{}", item.id)
}

/// What was typed into the fields of a form, by their names. Which there are depends on the instrument; a question with several
/// answers sends its field several times.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(transparent)]
pub struct GivenAnswers(BTreeMap<String, FieldTexts>);

/// The texts of a field. A form does not say whether there may be several.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged)]
enum FieldTexts {
    One(String),
    Several(Vec<String>),
}

/// What the box is called by which an item is left without an answer on purpose.
#[must_use]
pub fn name_of_leaving(item: &Item) -> String {
    format!("leave.{}", item.id)
}

impl GivenAnswers {
    /// Whether an item was left without an answer on purpose.
    #[must_use]
    pub fn is_left_out(&self, item: &Item) -> bool {
        matches!(self.0.get(&name_of_leaving(item)), Some(FieldTexts::One(text)) if text == "yes")
    }

    /// What was typed for an item, in the order in which it was sent.
    #[must_use]
    pub fn texts_for(&self, item: &Item) -> Vec<&str> {
        let texts = match self.0.get(&name_of_field(item)) {
            None => &[][..],
            Some(FieldTexts::One(text)) => std::slice::from_ref(text),
            Some(FieldTexts::Several(texts)) => texts,
        };
        texts.iter().map(String::as_str).collect()
    }
}
