//! Editing of documents in a form: fields are read from the text and written to it one by one.
//! Comments, order, number formats and unchanged keys are preserved.
//!
//! Fields are addressed as in issues, for example `rubric[1].full`.

pub mod draft;
mod instrument;
mod languages;
mod naming;
mod rows;
mod sent;

use std::collections::BTreeMap;

pub use languages::is_wording;
pub use naming::id_from_title;
use rows::last_position;
pub use sent::{SentForm, TypedField};
use toml_edit::{DocumentMut, Item, Table, TableLike, Value};

/// Usual order of the tables at the root; a new table is inserted after those before it.
const ORDER: [&str; 15] = [
    "title",
    "intro",
    "briefing",
    "entry",
    "target",
    "required",
    "rubric",
    "hard_fail",
    "coaching",
    "picture",
    "exercise",
    "scale",
    "section",
    "item",
    "score",
];

/// Type of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldSort {
    /// A text of one or several lines.
    Text,
    /// A number, kept in the format in which it is entered.
    Number,
    /// A boolean.
    Flag,
    /// Id of a metric, followed by `@` and its version unless it is the first.
    Metric,
    /// Presence of a table.
    Presence,
    /// A text in one of the document's languages.
    Translation,
    /// The document's own language.
    OwnLanguage,
    /// A list of ids with one checkbox each; the id follows the address of the field after a colon.
    Ids,
    /// Presence of a list of texts.
    TextList,
    /// The subject of a table; the table is removed with it.
    Subject,
}

/// A document that is edited field by field.
#[derive(Clone, Debug)]
pub struct EditedDocument {
    tree: DocumentMut,
}

/// A step of an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FieldStep<'p> {
    Key(&'p str),
    Row(usize),
}

/// Splits an address into steps. Keys of the documents contain neither full stops nor brackets.
fn field_steps(field: &str) -> Vec<FieldStep<'_>> {
    let parts = field.split(['.', '[']).filter(|part| !part.is_empty());
    let row = |part: &str| part.strip_suffix(']').and_then(|row| row.parse().ok()).map(FieldStep::Row);
    parts.map(|part| row(part).unwrap_or(FieldStep::Key(part))).collect()
}

impl EditedDocument {
    /// Parses a document. Returns `None` if it is not valid TOML.
    #[must_use]
    pub fn from_text(text: &str) -> Option<Self> {
        text.parse().ok().map(|tree| Self { tree })
    }

    /// Returns the text of the document.
    #[must_use]
    pub fn into_text(self) -> String {
        self.tree.to_string()
    }

    fn find_item(&self, field: &str) -> Option<&Item> {
        field_steps(field).into_iter().try_fold(self.tree.as_item(), |item, step| match step {
            FieldStep::Key(key) => item.get(key),
            FieldStep::Row(row) => item.get(row),
        })
    }

    /// Returns the value of a field as written: a text without quotes, a number in its own format,
    /// a true boolean as `yes`. Empty if the field is missing.
    #[must_use]
    pub fn written_at(&self, field: &str) -> String {
        match self.find_item(field) {
            Some(Item::Value(Value::String(text))) => text.value().clone(),
            Some(Item::Value(Value::Boolean(flag))) => if *flag.value() { "yes" } else { "" }.to_owned(),
            Some(Item::Value(value)) => value.clone().decorated("", "").to_string(),
            _ => String::new(),
        }
    }

    /// Returns the metric in a field of a row, followed by `@` and its version unless it is the
    /// first.
    #[must_use]
    pub fn metric_at(&self, field: &str) -> String {
        let (metric, version) = (self.written_at(field), self.written_at(&version_beside(field)));
        if version.is_empty() || version == "1" { metric } else { format!("{metric}@{version}") }
    }

    /// Returns the texts of a list.
    #[must_use]
    pub fn texts_at(&self, field: &str) -> Vec<String> {
        let list = self.find_item(field).and_then(Item::as_array);
        list.into_iter().flatten().filter_map(|text| text.as_str().map(str::to_owned)).collect()
    }

    /// Returns whether a field exists.
    #[must_use]
    pub fn is_written(&self, field: &str) -> bool {
        self.find_item(field).is_some_and(|item| !item.is_none())
    }

    /// Writes an entered value to a field. An equal value is left unchanged, byte for byte.
    pub fn write_field(&mut self, field: &str, sort: FieldSort, typed: &str) {
        match sort {
            FieldSort::Metric => self.write_metric(field, typed),
            FieldSort::Presence if typed.is_empty() => self.put_value(field, None),
            FieldSort::Presence => self.ensure_table(field),
            FieldSort::Translation => self.write_translation(field, typed),
            FieldSort::OwnLanguage => self.name_own_language(typed),
            FieldSort::Ids => {}
            FieldSort::TextList if typed.is_empty() => self.put_value(field, None),
            FieldSort::TextList if self.is_written(field) => {}
            FieldSort::TextList => self.put_value(field, Some(Value::Array(toml_edit::Array::new()))),
            _ if self.written_at(field) == typed => {}
            FieldSort::Subject if typed.is_empty() => {
                self.put_value(field.rsplit_once('.').map_or(field, |(table, _)| table), None)
            }
            FieldSort::Text if typed.is_empty() => self.put_value(field, None),
            FieldSort::Text | FieldSort::Subject => self.put_value(field, Some(Value::from(typed))),
            FieldSort::Number => self.write_number(field, typed.trim()),
            FieldSort::Flag => self.put_value(field, Some(Value::from(!typed.is_empty()))),
        }
    }

    fn write_number(&mut self, field: &str, typed: &str) {
        if typed.is_empty() && !field.ends_with(']') {
            return self.put_value(field, None);
        }
        if self.written_at(field) != typed {
            self.put_value(field, Some(read_number(typed)));
        }
    }

    fn write_metric(&mut self, field: &str, typed: &str) {
        if self.metric_at(field) == typed {
            return;
        }
        let (metric, version) = typed.split_once('@').unwrap_or((typed, ""));
        self.write_field(field, FieldSort::Text, metric);
        self.write_field(&version_beside(field), FieldSort::Number, version);
    }

    /// Adds an id to a list of texts, or removes it.
    pub fn tick_id(&mut self, field: &str, id: &str, is_in: bool) {
        let texts = self.texts_at(field);
        if texts.iter().any(|text| text == id) == is_in {
            return;
        }
        if !self.is_written(field) {
            self.put_value(field, Some(Value::Array(toml_edit::Array::new())));
        }
        let Some(list) = self.item_mut(field).and_then(Item::as_array_mut) else { return };
        match is_in {
            true => list.push(id),
            false => list.retain(|text| text.as_str() != Some(id)),
        }
    }

    fn item_mut(&mut self, field: &str) -> Option<&mut Item> {
        if !self.is_written(field) {
            return None;
        }
        field_steps(field).into_iter().try_fold(self.tree.as_item_mut(), |item, step| match step {
            FieldStep::Key(key) => item.get_mut(key),
            FieldStep::Row(row) => item.get_mut(row),
        })
    }

    /// Replaces a value and keeps the comment behind it, inserts a new value, or removes it with
    /// `None`.
    fn put_value(&mut self, field: &str, value: Option<Value>) {
        if let Some((vector, at)) = split_row(field) {
            return self.put_component(vector, at, value);
        }
        if let Some((parent, _)) =
            field.rsplit_once('.').filter(|(parent, _)| value.is_some() && !self.is_written(parent))
        {
            self.ensure_table(parent);
        }
        let Some(table) = self.parent_mut(field).and_then(Item::as_table_like_mut) else { return };
        replace_value(table, last_key(field), value);
    }

    /// Returns the table that contains a field.
    fn parent_mut(&mut self, field: &str) -> Option<&mut Item> {
        match field.rsplit_once('.') {
            Some((parent, _)) => self.item_mut(parent),
            None => Some(self.tree.as_item_mut()),
        }
    }

    /// Writes a component of a vector. The other component of a new vector is 0 or an empty text.
    fn put_component(&mut self, vector: &str, at: usize, value: Option<Value>) {
        let Some(value) = value.filter(|_| at < 2) else { return };
        if !self.is_written(vector) {
            let mut both = toml_edit::Array::new();
            match value {
                Value::String(_) => both.extend(["", ""]),
                _ => both.extend([0, 0]),
            }
            self.put_value(vector, Some(Value::Array(both)));
        }
        let Some(old) = self.item_mut(vector).and_then(Item::as_array_mut).and_then(|all| all.get_mut(at)) else {
            return;
        };
        *old = with_decor_of(value, old);
    }

    /// Creates an empty table at the root or in another table, if it is missing, in the usual
    /// order.
    fn ensure_table(&mut self, field: &str) {
        // Rows are never created here.
        if self.is_written(field) || field.ends_with(']') {
            return;
        }
        if let Some((parent, key)) = field.rsplit_once('.') {
            let Some(table) = self.item_mut(parent).and_then(Item::as_table_like_mut) else { return };
            table.insert(key, Item::Value(Value::InlineTable(toml_edit::InlineTable::new())));
            return;
        }
        let mut table = Table::new();
        table.set_position(self.position_before(field));
        self.tree.insert(field, Item::Table(table));
    }

    /// Returns the position of the last table that usually precedes this one.
    fn position_before(&self, key: &str) -> Option<isize> {
        let before = ORDER.iter().take_while(|known| **known != key);
        before.filter_map(|key| last_position(self.tree.get(key)?)).last()
    }
}

/// Returns the id of the exercise that a course names by its file: the one recorded for this file
/// in the course's current revision, or else the stem of the file name.
#[must_use]
pub fn find_exercise_id(files: &BTreeMap<String, String>, file: &str) -> String {
    files.get(file).cloned().unwrap_or_else(|| file.trim_end_matches(".toml").to_owned())
}

/// Appends an exercise of the school to a course.
pub fn add_course_exercise(course: &mut EditedDocument, exercise_id: &str) {
    let row = course.count_rows("exercise");
    course.add_row("exercise", &[]);
    course.write_field(&format!("exercise[{row}].file"), FieldSort::Text, &format!("{exercise_id}.toml"));
}

/// Returns the address of the version that belongs to a metric.
fn version_beside(field: &str) -> String {
    let row = field.rsplit_once('.').map_or("", |(row, _)| row);
    format!("{row}.version")
}

/// Returns the key of a field within its table.
fn last_key(field: &str) -> &str {
    field.rsplit_once('.').map_or(field, |(_, key)| key)
}

/// Splits the address of a vector's component into vector and index.
fn split_row(field: &str) -> Option<(&str, usize)> {
    let (vector, row) = field.strip_suffix(']')?.rsplit_once('[')?;
    row.parse().ok().map(|row| (vector, row))
}

fn replace_value(table: &mut dyn TableLike, key: &str, value: Option<Value>) {
    match (table.get_mut(key), value) {
        (Some(Item::Value(old)), Some(new)) => *old = with_decor_of(new, old),
        (_, Some(new)) => drop(table.insert(key, Item::Value(new))),
        (Some(_), None) => drop(table.remove(key)),
        (None, None) => {}
    }
}

fn with_decor_of(mut value: Value, old: &Value) -> Value {
    value.decor_mut().clone_from(old.decor());
    value
}

/// Parses an entered number and keeps its format; a single comma is a decimal point. Other text is
/// stored as a string, so that no input is lost; the document's parser then reports an error for
/// it.
fn read_number(typed: &str) -> Value {
    let pointed = match typed.matches(',').count() {
        1 if !typed.contains('.') => typed.replace(',', "."),
        _ => typed.to_owned(),
    };
    let is_number = |value: &Value| value.is_integer() || value.is_float();
    if let Some(value) = pointed.parse::<Value>().ok().filter(is_number) {
        return value;
    }
    match pointed.parse::<f64>() {
        Ok(number) if number.is_finite() => Value::from(number),
        _ => Value::from(typed),
    }
}

#[cfg(test)]
mod instrument_tests;
#[cfg(test)]
mod tests;
