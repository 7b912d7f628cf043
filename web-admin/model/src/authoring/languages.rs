//! Languages of a document edited in a form, and its translated texts.

use documents::list_document_languages;
use toml_edit::{Array, InlineTable, Item, TableLike, Value};

use super::{EditedDocument, FieldSort, last_key, replace_value};

/// Fields that can be translated, without row numbers.
const WORDINGS: [&str; 17] = [
    "title",
    "briefing",
    "description",
    "hard_fail[].why",
    "coaching[].message",
    "picture[].alt",
    "picture[].caption",
    "intro",
    "scale[].labels[]",
    "scale[].first",
    "scale[].last",
    "scale[].option[].text",
    "section[].title",
    "section[].text",
    "item[].name",
    "item[].text",
    "score[].title",
];

fn is_document_language(code: &str) -> bool {
    list_document_languages().any(|known| known == code)
}

/// Returns whether the field at an address can be translated.
#[must_use]
pub fn is_wording(field: &str) -> bool {
    WORDINGS.contains(&super::sent::pattern_of_field(field).as_str())
}

/// Splits the address of a translation into field and language.
pub(super) fn split_language(field: &str) -> Option<(&str, &str)> {
    let (text, language) = field.rsplit_once('.')?;
    (is_document_language(language) && is_wording(text)).then_some((text, language))
}

impl EditedDocument {
    /// Returns the language codes of the document, its own language first. Empty if it declares
    /// none.
    #[must_use]
    pub fn languages(&self) -> Vec<String> {
        self.texts_at("languages")
    }

    /// Returns the address of a text in one of the document's languages. It is the address of the
    /// field itself if the text is not a table and the language is the document's own.
    #[must_use]
    pub fn address_in(&self, text: &str, language: &str) -> String {
        let is_own = self.languages().first().is_none_or(|own| own == language);
        let in_table = self.find_item(text).is_some_and(Item::is_table_like);
        if is_own && !in_table { text.to_owned() } else { format!("{text}.{language}") }
    }

    /// Returns the title in a language, or else in the document's own language.
    #[must_use]
    pub fn title_in(&self, language: &str) -> String {
        self.wording_in("title", language)
    }

    /// Returns a text in a language, or else in the document's own language.
    #[must_use]
    pub fn wording_in(&self, text: &str, language: &str) -> String {
        let languages = self.languages();
        let own = languages.first().map_or("", String::as_str);
        let written = [language, own].map(|language| self.written_at(&format!("{text}.{language}")));
        let found = written.into_iter().find(|text| !text.is_empty());
        found.unwrap_or_else(|| self.plain_at(text))
    }

    fn plain_at(&self, field: &str) -> String {
        let plain = self.find_item(field).and_then(Item::as_str);
        plain.unwrap_or_default().to_owned()
    }

    /// Declares the document's own language, unless it declares languages already.
    pub fn name_own_language(&mut self, language: &str) {
        if is_document_language(language) && !self.is_written("languages") {
            self.put_value("languages", Some(Value::Array(Array::from_iter([language]))));
        }
    }

    /// Adds a language to the document, which must declare its own language first. Returns false if
    /// the language is unknown or already present.
    pub fn add_language(&mut self, language: &str) -> bool {
        let known = self.languages();
        if known.is_empty() || !is_document_language(language) || known.iter().any(|code| code == language) {
            return false;
        }
        let Some(list) = self.item_mut("languages").and_then(Item::as_array_mut) else { return false };
        list.push(language);
        true
    }

    /// Removes a language and all texts in it, except for the document's own language.
    pub fn remove_language(&mut self, at: usize) {
        let Some(language) = self.languages().into_iter().nth(at).filter(|_| at > 0) else { return };
        for text in self.list_wordings() {
            self.write_field(&format!("{text}.{language}"), FieldSort::Translation, "");
        }
        if let Some(list) = self.item_mut("languages").and_then(Item::as_array_mut) {
            list.remove(at);
        }
    }

    /// Returns the addresses of all fields that can be translated.
    fn list_wordings(&self) -> Vec<String> {
        WORDINGS.iter().flat_map(|text| self.list_addresses(text)).collect()
    }

    /// Returns all addresses that match a pattern without row numbers.
    pub(super) fn list_addresses(&self, pattern: &str) -> Vec<String> {
        let Some((array, rest)) = pattern.split_once("[]") else { return vec![pattern.to_owned()] };
        let rows = (0..self.count_rows(array)).map(|row| format!("{array}[{row}]{rest}"));
        rows.flat_map(|address| self.list_addresses(&address)).collect()
    }

    /// Writes a text in a language. A plain text becomes a table with the document's own language
    /// and this one.
    pub(super) fn write_translation(&mut self, field: &str, typed: &str) {
        let Some((text, language)) = split_language(field) else { return };
        if self.written_at(field) == typed {
            return;
        }
        if self.find_item(text).is_some_and(Item::is_table_like) {
            self.put_value(field, (!typed.is_empty()).then(|| Value::from(typed)));
            // A table without any language is removed.
            if !text.ends_with(']')
                && self.find_item(text).and_then(Item::as_table_like).is_some_and(TableLike::is_empty)
            {
                self.put_value(text, None);
            }
            return;
        }
        if typed.is_empty() || text.ends_with(']') {
            return;
        }
        let mut texts = InlineTable::new();
        if let (Some(own), true) = (self.languages().first(), self.is_written(text)) {
            texts.insert(own, Value::from(self.written_at(text)));
        }
        texts.insert(language, Value::from(typed));
        if let Some(table) = self.parent_mut(text).and_then(Item::as_table_like_mut) {
            replace_value(table, last_key(text), Some(Value::InlineTable(texts)));
        }
    }
}
