//! Answers submitted with a form.

use std::collections::BTreeMap;

use documents::instrument::Item;
use serde::Deserialize;

/// Returns the name of an item's field in the form.
#[must_use]
pub fn name_of_field(item: &Item) -> String {
    format!("q.{}", item.id)
}

/// Values of a form's fields, by name. The fields depend on the instrument; a question with several
/// answers submits its field several times.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(transparent)]
pub struct GivenAnswers(BTreeMap<String, FieldTexts>);

/// Values of a field. The encoding of a form does not distinguish fields that can repeat.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged)]
enum FieldTexts {
    One(String),
    Several(Vec<String>),
}

/// Returns the name of the checkbox by which an item is deliberately left unanswered.
#[must_use]
pub fn name_of_leaving(item: &Item) -> String {
    format!("leave.{}", item.id)
}

impl GivenAnswers {
    /// Returns whether an item was deliberately left unanswered.
    #[must_use]
    pub fn is_left_out(&self, item: &Item) -> bool {
        matches!(self.0.get(&name_of_leaving(item)), Some(FieldTexts::One(text)) if text == "yes")
    }

    /// Returns the values submitted for an item, in order.
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
