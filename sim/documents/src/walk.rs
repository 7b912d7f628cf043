//! Converts TOML to a checked document and collects every issue on the way.
//!
//! The checked document is JSON with every default filled in, so that the typed documents
//! deserialise from it without a second list of keys or defaults.

use std::collections::BTreeMap;

use phrase::{Phrase, phrase};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::describe::{DescribedField, DescribedTable, FieldKind, Presence, measure, one_of};
use crate::error::{DocumentError, Issue};
use crate::source::Source;
use crate::suggest::find_nearest_key;

/// A document checked against its description: values, positions and issues so far.
#[derive(Debug)]
pub(crate) struct Walked {
    /// Source text.
    pub source: Source,
    /// Values by key, defaults filled in; refused values are absent.
    pub value: Value,
    places: BTreeMap<String, usize>,
    issues: Vec<Issue>,
}

/// The reason why a document that another names could not be loaded.
#[derive(Debug)]
pub(crate) enum NamedError {
    /// The file could not be read.
    Missing(Phrase),
    /// The document was refused.
    Refused(DocumentError),
}

/// Parses TOML; every syntax error becomes an issue.
pub(crate) fn parse_document(source: &Source) -> Result<DeTable<'_>, DocumentError> {
    let (table, errors) = DeTable::parse_recoverable(source.text());
    let issues: Vec<Issue> = errors
        .iter()
        .map(|e| {
            let found = Phrase::data(e.message().replace('\n', ", "));
            source.issue(e.span().map_or(0, |s| s.start), "TOML", found, phrase!("not well-formed"))
        })
        .collect();
    if issues.is_empty() { Ok(table.into_inner()) } else { Err(DocumentError { issues }) }
}

impl Walked {
    /// Checks a document against its description.
    ///
    /// # Errors
    /// If the text is not TOML. Issues found by the description are collected for
    /// [`Walked::finish`].
    pub(crate) fn new(source: Source, description: &'static DescribedTable) -> Result<Self, DocumentError> {
        let (value, walker) = {
            let table = parse_document(&source)?;
            let mut walker = Walker { source: &source, places: BTreeMap::new(), issues: Vec::new() };
            let value = walker.table(description, &table, "", 0);
            (value, (walker.places, walker.issues))
        };
        let (places, issues) = walker;
        Ok(Self { source, value, places, issues })
    }

    /// Adds an issue at a field; a field that is missing in the text is placed at its nearest
    /// parent.
    pub(crate) fn refuse(&mut self, field: &str, found: Phrase, allowed: Phrase) {
        let issue = self.issue(field, found, allowed);
        self.issues.push(issue);
    }

    /// Creates an issue at a field without adding it.
    pub(crate) fn issue(&self, field: &str, found: Phrase, allowed: Phrase) -> Issue {
        let mut place = field;
        while !place.is_empty() && !self.places.contains_key(place) {
            place = place.rfind(['.', '[']).map_or("", |at| &place[..at]);
        }
        self.source.issue(self.places.get(place).copied().unwrap_or(0), field, found, allowed)
    }

    /// Returns whether the document contains a field, refused or not.
    pub(crate) fn is_written(&self, field: &str) -> bool {
        self.places.contains_key(field)
    }

    /// Returns a document that a field names, or adds its issues; a missing file is an issue of the
    /// field.
    pub(crate) fn accept<T>(&mut self, field: &str, named: Result<T, NamedError>) -> Option<T> {
        match named {
            Ok(document) => return Some(document),
            Err(NamedError::Missing(why)) => {
                self.refuse(field, why, phrase!("allowed: the path of a document, relative to this one"));
            }
            Err(NamedError::Refused(error)) => self.issues.extend(error.issues),
        }
        None
    }

    /// Returns the tables of an array; empty without one.
    pub(crate) fn tables(&self, key: &str) -> Vec<Value> {
        self.value[key].as_array().cloned().unwrap_or_default()
    }

    /// Refuses duplicate texts at `key` in the tables of an array.
    pub(crate) fn refuse_duplicates(&mut self, array: &str, key: &str) {
        let mut seen: BTreeMap<String, usize> = BTreeMap::new();
        for (at, table) in self.tables(array).iter().enumerate() {
            let Some(text) = table[key].as_str() else { continue };
            if let Some(first) = seen.get(text) {
                let allowed =
                    phrase!("{first} already has it; each must be unique", first = format!("{array}[{first}]"));
                self.refuse(&format!("{array}[{at}].{key}"), Phrase::quoted(text), allowed);
            } else {
                seen.insert(text.to_owned(), at);
            }
        }
    }

    /// Deserialises the typed document.
    ///
    /// # Errors
    /// Every issue found so far, in document order, those of this document first.
    pub(crate) fn finish<T: DeserializeOwned>(mut self) -> Result<T, DocumentError> {
        if self.issues.is_empty() {
            match serde_json::from_value(std::mem::take(&mut self.value)) {
                Ok(document) => return Ok(document),
                Err(e) => self.refuse("document", Phrase::data(e), phrase!("not as described")),
            }
        }
        let own = self.source.file;
        self.issues.sort_by_key(|i| (i.file != own, i.file.clone(), i.line, i.column));
        Err(DocumentError { issues: self.issues })
    }
}

/// Joins a path of keys; control characters are replaced so that it prints on one line.
fn join_key_path(parent: &str, key: &str) -> String {
    let key: String = key.chars().map(|c| if c.is_control() { '�' } else { c }).collect();
    if parent.is_empty() { key } else { format!("{parent}.{key}") }
}

struct Walker<'s> {
    source: &'s Source,
    places: BTreeMap<String, usize>,
    issues: Vec<Issue>,
}

impl Walker<'_> {
    fn table(&mut self, table: &'static DescribedTable, found: &DeTable<'_>, path: &str, offset: usize) -> Value {
        for key in found.keys() {
            if !table.fields.iter().any(|f| f.key == key.get_ref().as_ref()) {
                let issue = self.source.issue(
                    key.span().start,
                    &join_key_path(path, key.get_ref()),
                    phrase!("unknown key"),
                    suggest_key(key.get_ref(), table),
                );
                self.issues.push(issue);
            }
        }
        let mut checked = Map::new();
        for field in table.fields {
            let path = join_key_path(path, field.key);
            let value = match found.iter().find(|(k, _)| k.get_ref() == field.key) {
                Some((_, value)) => {
                    self.places.insert(path.clone(), value.span().start);
                    self.value(field, value, &path)
                }
                None => self.absent(field, &path, offset),
            };
            if let Some(value) = value {
                checked.insert(field.key.to_owned(), value);
            }
        }
        Value::Object(checked)
    }

    fn absent(&mut self, field: &DescribedField, path: &str, offset: usize) -> Option<Value> {
        match field.presence {
            Presence::Required => {
                self.issues.push(self.source.issue(offset, path, phrase!("missing"), field.kind.allowed()));
                None
            }
            Presence::Optional => None,
            Presence::Number(number) => default_number(field, number),
            Presence::Text(text) => Some(text.into()),
            Presence::Flag(flag) => Some(flag.into()),
            Presence::Empty => Some(match field.kind {
                FieldKind::Table(table) => self.table(table, &DeTable::new(), path, offset),
                _ => Value::Array(Vec::new()),
            }),
        }
    }

    fn value(&mut self, field: &DescribedField, value: &Spanned<DeValue<'_>>, path: &str) -> Option<Value> {
        let checked = match (&field.kind, value.get_ref()) {
            (FieldKind::Number { min, max, .. }, found) => number_value(found, *min, *max),
            (FieldKind::Integer { min, max }, DeValue::Integer(i)) => {
                parse_integer(i.as_str(), i.radix()).filter(|i| (min..=max).contains(&i)).map(Value::from)
            }
            (FieldKind::Flag, DeValue::Boolean(flag)) => Some(Value::from(*flag)),
            (FieldKind::Text(text), DeValue::String(s)) => text.admits(s).then(|| s.as_ref().into()),
            (FieldKind::Words { text, .. }, DeValue::String(s)) => text.admits(s).then(|| s.as_ref().into()),
            (FieldKind::Words { table, .. }, DeValue::Table(t)) => {
                return Some(self.table(table, t, path, value.span().start));
            }
            (FieldKind::Choice(words), DeValue::String(s)) => words.contains(&s.as_ref()).then(|| s.as_ref().into()),
            (FieldKind::Table(table), DeValue::Table(t)) => {
                return Some(self.table(table, t, path, value.span().start));
            }
            (FieldKind::Tables { table, min, max }, DeValue::Array(a)) if (min..=max).contains(&&a.len()) => {
                return self.tables(table, a.iter(), path);
            }
            (FieldKind::Vector { len, min, max, .. }, DeValue::Array(a)) if a.len() == *len => {
                a.iter().map(|e| number_value(e.get_ref(), *min, *max)).collect::<Option<Vec<_>>>().map(Value::Array)
            }
            (FieldKind::Texts(text), DeValue::Array(a)) => a
                .iter()
                .map(|e| e.get_ref().as_str().filter(|s| text.admits(s)).map(Value::from))
                .collect::<Option<Vec<_>>>()
                .map(Value::Array),
            _ => None,
        };
        if checked.is_none() {
            self.refuse_value(field, value, path);
        }
        checked
    }

    fn tables<'t, 'i: 't>(
        &mut self,
        table: &'static DescribedTable,
        found: impl Iterator<Item = &'t Spanned<DeValue<'i>>>,
        path: &str,
    ) -> Option<Value> {
        let mut checked = Vec::new();
        for (at, element) in found.enumerate() {
            let path = format!("{path}[{at}]");
            self.places.insert(path.clone(), element.span().start);
            match element.get_ref() {
                DeValue::Table(t) => checked.push(self.table(table, t, &path, element.span().start)),
                _ => {
                    let found = Phrase::Data(self.source.excerpt(element.span()));
                    let allowed = phrase!("allowed: a table");
                    self.issues.push(self.source.issue(element.span().start, &path, found, allowed));
                    checked.push(Value::Null);
                }
            }
        }
        Some(Value::Array(checked))
    }

    fn refuse_value(&mut self, field: &DescribedField, value: &Spanned<DeValue<'_>>, path: &str) {
        let found = match value.get_ref() {
            DeValue::Array(a) if matches!(field.kind, FieldKind::Tables { .. }) => {
                phrase!("{count} tables", count = a.len())
            }
            _ => Phrase::Data(measure(self.source.excerpt(value.span()), field.unit())),
        };
        self.issues.push(self.source.issue(value.span().start, path, found, field.kind.allowed()));
    }
}

/// Suggests a known key for an unknown one.
fn suggest_key(key: &str, table: &DescribedTable) -> Phrase {
    match find_nearest_key(key, table) {
        Some(field) if !field.unit().is_empty() => {
            phrase!("did you mean `{key}`? The unit is part of the key", key = field.key)
        }
        Some(field) => phrase!("did you mean `{key}`?", key = field.key),
        None => {
            let known: Vec<_> = table.fields.iter().map(|f| f.key).collect();
            one_of(&known)
        }
    }
}

fn default_number(field: &DescribedField, number: f64) -> Option<Value> {
    match field.kind {
        // Integer defaults are small whole numbers, so the cast is exact.
        FieldKind::Integer { .. } => Some(Value::from(number as i64)),
        _ => serde_json::Number::from_f64(number).map(Value::Number),
    }
}

/// Returns a finite number from `min` to `max`; NaN and infinities are in no range.
fn number_value(found: &DeValue<'_>, min: f64, max: f64) -> Option<Value> {
    let number = match found {
        DeValue::Float(f) => f.as_str().parse::<f64>().ok()?,
        DeValue::Integer(i) if i.radix() == 10 => i.as_str().parse::<f64>().ok()?,
        DeValue::Integer(i) => parse_integer(i.as_str(), i.radix())? as f64,
        _ => return None,
    };
    (min..=max).contains(&number).then(|| serde_json::Number::from_f64(number).map(Value::Number)).flatten()
}

fn parse_integer(text: &str, radix: u32) -> Option<i64> {
    i64::from_str_radix(text, radix).ok()
}
