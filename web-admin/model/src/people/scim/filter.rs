//! Filters (RFC 7644, section 3.4.2.2): comparisons by `eq`, joined by `and`.

use serde_json::Value;

use super::{Object, ScimError, standard_name};

/// Maximum length of a filter, in bytes.
const LONGEST: usize = 2000;

/// Comparisons that must all hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filter(pub(super) Vec<Comparison>);

/// A comparison of an attribute with a value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Comparison {
    pub attribute: String,
    pub part: Option<String>,
    pub value: Value,
}

fn refuse(filter: &str) -> ScimError {
    let shown: String = filter.chars().take(100).collect();
    let detail = format!("filter: \"{shown}\"; supported: comparisons by eq, joined by and");
    ScimError::invalid("invalidFilter", detail)
}

impl Filter {
    /// Parses a filter.
    ///
    /// # Errors
    /// If it contains anything but comparisons by `eq`, joined by `and`.
    pub fn parse(text: &str) -> Result<Self, ScimError> {
        if text.len() > LONGEST {
            return Err(refuse(text));
        }
        let mut comparisons = Vec::new();
        let mut rest = text.trim();
        loop {
            let (attribute, after) = split_word(rest).ok_or_else(|| refuse(text))?;
            let (operator, after) = split_word(after).ok_or_else(|| refuse(text))?;
            if !operator.eq_ignore_ascii_case("eq") {
                return Err(refuse(text));
            }
            let mut values = serde_json::Deserializer::from_str(after).into_iter::<Value>();
            let value = match values.next() {
                Some(Ok(value)) if !value.is_array() && !value.is_object() => value,
                _ => return Err(refuse(text)),
            };
            let attribute = attribute.rsplit(':').next().unwrap_or(attribute);
            let (attribute, part) = match attribute.split_once('.') {
                Some((attribute, part)) => (attribute, Some(standard_name(part).to_owned())),
                None => (attribute, None),
            };
            comparisons.push(Comparison { attribute: standard_name(attribute).to_owned(), part, value });
            rest = after[values.byte_offset()..].trim_start();
            if rest.is_empty() {
                return Ok(Self(comparisons));
            }
            rest = match split_word(rest) {
                Some((and, after)) if and.eq_ignore_ascii_case("and") => after,
                _ => return Err(refuse(text)),
            };
        }
    }

    /// Returns the text with which an attribute is compared, to look it up.
    #[must_use]
    pub fn text_of(&self, attribute: &str) -> Option<&str> {
        let found = self.0.iter().find(|one| one.attribute == attribute && one.part.is_none());
        found.and_then(|one| one.value.as_str())
    }

    /// Returns whether a resource matches.
    #[must_use]
    pub fn matches(&self, fields: &Object) -> bool {
        self.0.iter().all(|one| one.holds(fields))
    }
}

impl Comparison {
    fn holds(&self, fields: &Object) -> bool {
        let Some(found) = fields.get(&self.attribute) else { return false };
        let is_exact = matches!(self.attribute.as_str(), "id" | "externalId");
        let equal = |found: &Value| match (found, &self.value) {
            (Value::String(a), Value::String(b)) if !is_exact => a.to_lowercase() == b.to_lowercase(),
            (a, b) => a == b,
        };
        let part = self.part.as_deref().unwrap_or("value");
        match found {
            Value::Array(values) => values.iter().any(|value| value.get(part).is_some_and(equal)),
            Value::Object(parts) => parts.get(part).is_some_and(equal),
            value => self.part.is_none() && equal(value),
        }
    }
}

/// Splits off the first word.
pub(super) fn split_word(text: &str) -> Option<(&str, &str)> {
    let text = text.trim_start();
    let end = text.find(char::is_whitespace)?;
    Some((&text[..end], text[end..].trim_start()))
}
