//! A document written in a form: its fields are read from the text and written into it, one by one. Comments, order, how a number is
//! written and every key that nobody has changed stay as they are.
//!
//! A field has the address that an issue names: `rubric[1].full`.

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

/// The root's tables in the order in which people write them: a new one goes behind those before it.
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

/// What a field holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldSort {
    /// A text, on one line or many.
    Text,
    /// A number, in the figures in which it is typed.
    Number,
    /// Yes or no.
    Flag,
    /// A metric's id, and behind an @ its version where it is not the first.
    Metric,
    /// A table that is there or not.
    Presence,
    /// A text in one of the document's languages.
    Translation,
    /// In which language the document is written.
    OwnLanguage,
    /// A list of ids, each a box of its own; the value of a box follows the field's address after a colon.
    Ids,
    /// A list of texts that is there or not.
    TextList,
    /// What a table is about, which goes with it.
    Subject,
}

/// A document, changed field by field.
#[derive(Clone, Debug)]
pub struct EditedDocument {
    tree: DocumentMut,
}

/// A step on the way to a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FieldStep<'p> {
    Key(&'p str),
    Row(usize),
}

/// The steps of an address; keys of our documents hold neither full stops nor brackets.
fn field_steps(field: &str) -> Vec<FieldStep<'_>> {
    let parts = field.split(['.', '[']).filter(|part| !part.is_empty());
    let row = |part: &str| part.strip_suffix(']').and_then(|row| row.parse().ok()).map(FieldStep::Row);
    parts.map(|part| row(part).unwrap_or(FieldStep::Key(part))).collect()
}

impl EditedDocument {
    /// The document of a text; nothing where it is no TOML.
    #[must_use]
    pub fn from_text(text: &str) -> Option<Self> {
        text.parse().ok().map(|tree| Self { tree })
    }

    /// Its text.
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

    /// What stands at a field, as it is written: a text without its quotes, a number in its own figures, a yes as `yes`; empty where
    /// nothing stands there.
    #[must_use]
    pub fn written_at(&self, field: &str) -> String {
        match self.find_item(field) {
            Some(Item::Value(Value::String(text))) => text.value().clone(),
            Some(Item::Value(Value::Boolean(flag))) => if *flag.value() { "yes" } else { "" }.to_owned(),
            Some(Item::Value(value)) => value.clone().decorated("", "").to_string(),
            _ => String::new(),
        }
    }

    /// The metric at a field of a row, with its version behind an @ where it is not the first.
    #[must_use]
    pub fn metric_at(&self, field: &str) -> String {
        let (metric, version) = (self.written_at(field), self.written_at(&version_beside(field)));
        if version.is_empty() || version == "1" { metric } else { format!("{metric}@{version}") }
    }

    /// The texts of a list.
    #[must_use]
    pub fn texts_at(&self, field: &str) -> Vec<String> {
        let list = self.find_item(field).and_then(Item::as_array);
        list.into_iter().flatten().filter_map(|text| text.as_str().map(str::to_owned)).collect()
    }

    /// Whether something stands at a field.
    #[must_use]
    pub fn is_written(&self, field: &str) -> bool {
        self.find_item(field).is_some_and(|item| !item.is_none())
    }

    /// Writes what was typed into a field. What is there already stays to the byte.
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

    /// Puts an id into a list of texts, or takes it out.
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

    /// Puts a value in the place of another, with the comment behind it; or where nothing was; or takes it away.
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

    /// What a field stands in.
    fn parent_mut(&mut self, field: &str) -> Option<&mut Item> {
        match field.rsplit_once('.') {
            Some((parent, _)) => self.item_mut(parent),
            None => Some(self.tree.as_item_mut()),
        }
    }

    /// A component of a vector; where there was no vector, the others are 0, or without a text.
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

    /// A table at the root or in another, empty where it is new, behind those that people write before it.
    fn ensure_table(&mut self, field: &str) {
        // A row that there is not is no table to be begun.
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

    /// The place of the last table that people write before this one.
    fn position_before(&self, key: &str) -> Option<isize> {
        let before = ORDER.iter().take_while(|known| **known != key);
        before.filter_map(|key| last_position(self.tree.get(key)?)).last()
    }
}

/// The id of the exercise that a line of a course means by a file: the one that the course's current revision gives that name, or else the
/// one that the file is called after.
#[must_use]
pub fn find_exercise_id(files: &BTreeMap<String, String>, file: &str) -> String {
    files.get(file).cloned().unwrap_or_else(|| file.trim_end_matches(".toml").to_owned())
}

/// Puts an exercise of the school behind the others of a course.
pub fn add_course_exercise(course: &mut EditedDocument, exercise_id: &str) {
    let row = course.count_rows("exercise");
    course.add_row("exercise", &[]);
    course.write_field(&format!("exercise[{row}].file"), FieldSort::Text, &format!("{exercise_id}.toml"));
}

/// The address of the version beside a metric.
fn version_beside(field: &str) -> String {
    let row = field.rsplit_once('.').map_or("", |(row, _)| row);
    format!("{row}.version")
}

/// The key under which a field stands in its table.
fn last_key(field: &str) -> &str {
    field.rsplit_once('.').map_or(field, |(_, key)| key)
}

/// A vector and the place of a component in it.
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

/// A number in the figures in which it was typed, a comma read as the decimal point. What is no number is kept as a text, so that
/// nothing that was typed is lost; the reader of the document will refuse it at its place.
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
