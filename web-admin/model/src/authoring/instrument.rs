//! References within an instrument: rows have ids, and references to an id are updated when it is
//! renamed or removed.

use toml_edit::{InlineTable, Item, Value};

use super::{EditedDocument, FieldSort, with_decor_of};

/// Fields that refer to items: each is a text or a list of texts.
const ITEM_NAMES: [&str; 6] =
    ["score[].items", "score[].reversed", "score[].pairs", "item[].pair", "item[].when.item", "section[].when.item"];

/// Fields with conditions.
const CONDITIONS: [&str; 2] = ["item[].when", "section[].when"];

/// Keys of each kind of scale.
const KEYS_OF_KIND: [(&str, &[&str]); 7] = [
    ("likert", &["points", "labels", "first", "last", "relevant_from"]),
    ("slider", &["min", "max", "step", "first", "last"]),
    ("pair", &[]),
    ("choice", &["option"]),
    ("choices", &["option"]),
    ("number", &["min", "max", "unit"]),
    ("text", &["max_characters"]),
];

/// A renamed id.
#[derive(Clone, Debug)]
struct Renaming {
    before: String,
    now: String,
}

/// Previous value of a field.
#[derive(Clone, Debug)]
struct Remembered {
    field: String,
    held: String,
}

/// Ids and choices in an instrument before the form is written to it.
#[derive(Clone, Debug)]
pub(super) struct InstrumentNames {
    items: Vec<Remembered>,
    scales: Vec<Remembered>,
    sections: Vec<Remembered>,
    options: Vec<Remembered>,
    /// Choices that determine which other fields exist.
    choices: Vec<Remembered>,
}

impl InstrumentNames {
    pub(super) fn of(document: &EditedDocument) -> Self {
        let held = |pattern: &str| remember_fields(document, pattern);
        let choices = [
            "scale[].kind",
            "item[].scale",
            "item[].when.item",
            "section[].when.item",
            "score[].missing",
            "score[].combine",
        ];
        Self {
            items: held("item[].id"),
            scales: held("scale[].id"),
            sections: held("section[].id"),
            options: held("scale[].option[].id"),
            choices: choices.into_iter().flat_map(held).collect(),
        }
    }

    /// Updates references to changed ids, and fields that depend on changed choices.
    pub(super) fn follow(&self, document: &mut EditedDocument) {
        let changed: Vec<&Remembered> =
            self.choices.iter().filter(|choice| document.written_at(&choice.field) != choice.held).collect();
        for choice in changed {
            drop_what_depends(document, &choice.field);
        }
        let items = renamings(document, &self.items);
        ITEM_NAMES.iter().for_each(|pattern| rename_at(document, pattern, &items));
        rename_at(document, "item[].scale", &renamings(document, &self.scales));
        rename_at(document, "item[].section", &renamings(document, &self.sections));
        self.options.iter().for_each(|option| follow_option(document, option));
        fit_labels(document);
        for list in ["score[].reversed", "score[].pairs"] {
            drop_empty_lists(document, list);
        }
    }
}

fn remember_fields(document: &EditedDocument, pattern: &str) -> Vec<Remembered> {
    let fields = document.list_addresses(pattern).into_iter();
    fields.map(|field| Remembered { held: document.written_at(&field), field }).collect()
}

/// Returns the renamed ids, if the old id was unique and neither name is empty.
fn renamings(document: &EditedDocument, names: &[Remembered]) -> Vec<Renaming> {
    let is_single = |name: &str| names.iter().filter(|known| known.held == name).count() == 1;
    let renaming = |name: &Remembered| Renaming { before: name.held.clone(), now: document.written_at(&name.field) };
    let renamed = |name: &Renaming| name.before != name.now && !name.before.is_empty() && !name.now.is_empty();
    names.iter().map(renaming).filter(|name| renamed(name) && is_single(&name.before)).collect()
}

fn find_new_name<'r>(name: &str, renamings: &'r [Renaming]) -> Option<&'r str> {
    renamings.iter().find(|renaming| renaming.before == name).map(|renaming| renaming.now.as_str())
}

fn rename_at(document: &mut EditedDocument, pattern: &str, renamings: &[Renaming]) {
    if renamings.is_empty() {
        return;
    }
    for field in document.list_addresses(pattern) {
        match document.item_mut(&field) {
            Some(Item::Value(Value::Array(names))) => {
                for name in names.iter_mut() {
                    if let Some(now) = name.as_str().and_then(|name| find_new_name(name, renamings)) {
                        *name = with_decor_of(Value::from(now), name);
                    }
                }
            }
            Some(Item::Value(name)) => {
                if let Some(now) = name.as_str().and_then(|name| find_new_name(name, renamings)) {
                    *name = with_decor_of(Value::from(now), name);
                }
            }
            _ => {}
        }
    }
}

/// Updates the conditions on a scale's items after an option was renamed.
fn follow_option(document: &mut EditedDocument, option: &Remembered) {
    let renaming = renamings(document, std::slice::from_ref(option));
    let Some((scale, _)) = option.field.split_once('.').filter(|_| !renaming.is_empty()) else { return };
    let scale = document.written_at(&format!("{scale}.id"));
    let conditions: Vec<String> = CONDITIONS.iter().flat_map(|pattern| document.list_addresses(pattern)).collect();
    for condition in conditions {
        let asked = document.written_at(&format!("{condition}.item"));
        if document
            .find_row_of("item", &asked)
            .is_some_and(|row| document.written_at(&format!("item[{row}].scale")) == scale)
        {
            rename_at(document, &format!("{condition}.is"), &renaming);
        }
    }
}

/// Removes fields that only exist with the previous choice.
fn drop_what_depends(document: &mut EditedDocument, field: &str) {
    let Some((row, key)) = field.rsplit_once('.') else { return };
    let chosen = document.written_at(field);
    let gone: Vec<&str> = match key {
        "kind" => {
            let Some((_, kept)) = KEYS_OF_KIND.iter().find(|(kind, _)| *kind == chosen) else { return };
            KEYS_OF_KIND.iter().flat_map(|(_, keys)| *keys).copied().filter(|key| !kept.contains(key)).collect()
        }
        "scale" if kind_of_scale(document, &chosen) != "pair" => vec!["pair"],
        "item" => vec!["is"],
        "missing" if chosen != "mean-of-answered" => vec!["least_answered"],
        "combine" if chosen != "pair-weighted" => vec!["pairs"],
        _ => return,
    };
    for key in gone {
        let field = format!("{row}.{key}");
        if document.is_written(&field) {
            document.put_value(&field, None);
        }
    }
}

fn kind_of_scale(document: &EditedDocument, scale: &str) -> String {
    let row = document.find_row_of("scale", scale);
    row.map_or_else(String::new, |row| document.written_at(&format!("scale[{row}].kind")))
}

/// Adjusts the number of labels to the number of points. Surplus labels are kept while they contain
/// text.
fn fit_labels(document: &mut EditedDocument) {
    for row in 0..document.count_rows("scale") {
        let points: Option<usize> = document.written_at(&format!("scale[{row}].points")).parse().ok();
        let labels = document.item_mut(&format!("scale[{row}].labels")).and_then(Item::as_array_mut);
        let (Some(points), Some(labels)) = (points.filter(|points| *points <= 11), labels) else { continue };
        let is_empty =
            |label: Option<&Value>| label.and_then(Value::as_inline_table).is_some_and(InlineTable::is_empty);
        while labels.len() > points && is_empty(labels.get(labels.len() - 1)) {
            labels.remove(labels.len() - 1);
        }
        while labels.len() < points {
            labels.push(Value::InlineTable(InlineTable::new()));
        }
    }
}

fn drop_empty_lists(document: &mut EditedDocument, pattern: &str) {
    for list in document.list_addresses(pattern) {
        let is_empty = document.item_mut(&list).and_then(|item| item.as_array().map(toml_edit::Array::is_empty));
        if is_empty == Some(true) {
            document.put_value(&list, None);
        }
    }
}

impl EditedDocument {
    /// Returns the index of the row with an id.
    #[must_use]
    pub fn find_row_of(&self, array: &str, id: &str) -> Option<usize> {
        (0..self.count_rows(array)).find(|row| self.written_at(&format!("{array}[{row}].id")) == id)
    }

    /// Returns whether the list at an address contains an id.
    #[must_use]
    pub fn names_id(&self, list: &str, id: &str) -> bool {
        self.texts_at(list).iter().any(|name| name == id)
    }

    /// Adds a row with a new unique id. Returns its index.
    pub fn add_named_row(&mut self, array: &str, stem: &str) -> usize {
        let row = self.count_rows(array);
        let mut number = row + 1;
        while self.find_row_of(array, &format!("{stem}-{number}")).is_some() {
            number += 1;
        }
        self.add_row(array, &[("id", &format!("{stem}-{number}"))]);
        row
    }

    /// Adds a question with the given scale, on the same page as the previous question. Returns its
    /// index.
    pub fn add_question(&mut self, scale: &str) -> usize {
        let row = self.add_named_row("item", "q");
        let pages = self.count_rows("section");
        let before = row.checked_sub(1).map(|before| self.written_at(&format!("item[{before}].section")));
        let last = pages.checked_sub(1).map(|last| self.written_at(&format!("section[{last}].id")));
        let page = before.filter(|page| !page.is_empty()).or(last).filter(|_| pages > 0);
        self.write_field(&format!("item[{row}].section"), FieldSort::Text, &page.unwrap_or_default());
        self.write_field(&format!("item[{row}].scale"), FieldSort::Text, scale);
        row
    }

    /// Adds a page at the end. Returns its index. If it is the first page, all questions are moved
    /// to it.
    pub fn add_section(&mut self) -> usize {
        let row = self.add_named_row("section", "page");
        if row == 0 {
            let id = self.written_at("section[0].id");
            for item in self.list_addresses("item[].section") {
                self.write_field(&item, FieldSort::Text, &id);
            }
        }
        row
    }

    /// Removes a question, and its id from the scores.
    pub fn remove_question(&mut self, row: usize) {
        let id = self.written_at(&format!("item[{row}].id"));
        self.remove_row("item", row);
        if self.find_row_of("item", &id).is_some() {
            return;
        }
        for list in ["score[].items", "score[].reversed", "score[].pairs"] {
            for list in self.list_addresses(list) {
                self.tick_id(&list, &id, false);
            }
        }
        drop_empty_lists(self, "score[].reversed");
        drop_empty_lists(self, "score[].pairs");
    }

    /// Removes a page; its questions stay without a page.
    pub fn remove_section(&mut self, row: usize) {
        let id = self.written_at(&format!("section[{row}].id"));
        self.remove_row("section", row);
        for item in self.list_addresses("item[].section") {
            if self.written_at(&item) == id {
                self.write_field(&item, FieldSort::Text, "");
            }
        }
    }

    /// Removes a scale, unless a question uses it.
    pub fn remove_scale(&mut self, row: usize) {
        let id = self.written_at(&format!("scale[{row}].id"));
        if self.list_addresses("item[].scale").iter().all(|item| self.written_at(item) != id) {
            self.remove_row("scale", row);
        }
    }
}
