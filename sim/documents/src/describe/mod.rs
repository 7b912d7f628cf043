//! Description of every document field: key, unit, range, default and meaning, defined once.
//!
//! The reader ([`crate::walk`]) and the JSON Schema ([`crate::schema`]) both derive from these
//! tables, so neither can drift from the other.

use std::borrow::Borrow;
use std::fmt::Display;
use std::ops::RangeInclusive;

use phrase::{Phrase, phrase};

mod body;
mod curriculum;
mod exercise;
mod instrument;
mod scene;
mod segmentation;
mod text;

pub(crate) use curriculum::CURRICULUM;
pub(crate) use exercise::EXERCISE;
pub(crate) use instrument::INSTRUMENT;
pub use instrument::list_document_languages;
pub(crate) use scene::{LAYERS, SCENE};
pub(crate) use segmentation::SEGMENTATION;
pub(crate) use text::Text;

/// A TOML table: the fields it may hold, in the order in which authors write them.
#[derive(Debug)]
pub(crate) struct DescribedTable {
    /// Description for the schema.
    pub doc: &'static str,
    /// Its fields.
    pub fields: &'static [DescribedField],
}

/// One field of a table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DescribedField {
    /// The key, including the unit suffix.
    pub key: &'static str,
    /// Type and limits of the value.
    pub kind: FieldKind,
    /// Whether the field is required, and its default.
    pub presence: Presence,
    /// Meaning, for the schema and the handbook.
    pub doc: &'static str,
}

/// Type and limits of a value.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FieldKind {
    /// A finite number from `min` to `max`, both included.
    Number { unit: &'static str, min: f64, max: f64 },
    /// An integer from `min` to `max`, both included.
    Integer { min: i64, max: i64 },
    /// `true` or `false`.
    Flag,
    /// Text of a certain form.
    Text(&'static Text),
    /// Text of a certain form, or a table with one text for each of the document's languages.
    Words { text: &'static Text, table: &'static DescribedTable },
    /// One of a list of words.
    Choice(&'static [&'static str]),
    /// `len` finite numbers, each from `min` to `max`.
    Vector { unit: &'static str, len: usize, min: f64, max: f64 },
    /// A list of texts.
    Texts(&'static Text),
    /// A table.
    Table(&'static DescribedTable),
    /// An array of `min` to `max` tables.
    Tables { table: &'static DescribedTable, min: usize, max: usize },
}

/// Whether a field is required, and its default.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Presence {
    /// The field is required.
    Required,
    /// The field may be absent and has no default.
    Optional,
    /// The default is this number.
    Number(f64),
    /// The default is this text.
    Text(&'static str),
    /// The default is this flag.
    Flag(bool),
    /// The default is an empty list or a table of defaults.
    Empty,
}

impl DescribedField {
    /// Creates an optional field.
    const fn new(key: &'static str, kind: FieldKind, doc: &'static str) -> Self {
        Self { key, kind, presence: Presence::Optional, doc }
    }

    /// Creates a field for a number in `unit` within `range`.
    const fn number(key: &'static str, unit: &'static str, range: RangeInclusive<f64>, doc: &'static str) -> Self {
        Self::new(key, FieldKind::Number { unit, min: *range.start(), max: *range.end() }, doc)
    }

    /// Creates a field for three numbers in mm, each within ±`limit`.
    const fn place(key: &'static str, limit: f64, doc: &'static str) -> Self {
        Self::new(key, FieldKind::Vector { unit: "mm", len: 3, min: -limit, max: limit }, doc)
    }

    /// Creates a field for text of a form.
    const fn text(key: &'static str, text: &'static Text, doc: &'static str) -> Self {
        Self::new(key, FieldKind::Text(text), doc)
    }

    /// Creates a field for one line of user-facing text, in one language or several.
    const fn said_line(key: &'static str, doc: &'static str) -> Self {
        Self::new(key, FieldKind::Words { text: &Text::LINE, table: &instrument::LINES }, doc)
    }

    /// Creates a field for user-facing paragraphs, in one language or several.
    const fn said_prose(key: &'static str, doc: &'static str) -> Self {
        Self::new(key, FieldKind::Words { text: &Text::PROSE, table: &instrument::PROSES }, doc)
    }

    /// Creates the field for the codes of a document's languages.
    const fn languages() -> Self {
        let doc = "Codes of its languages, the main one first; needed if a text is written in several";
        Self::new("languages", FieldKind::Texts(&Text::ID), doc).with(Presence::Empty)
    }

    /// Returns the field with another presence.
    const fn with(self, presence: Presence) -> Self {
        Self { presence, ..self }
    }

    /// Returns the field, required.
    const fn required(self) -> Self {
        self.with(Presence::Required)
    }

    /// Returns the field with a number as default.
    const fn or(self, default: f64) -> Self {
        self.with(Presence::Number(default))
    }

    /// Returns the field with a text as default.
    const fn or_text(self, default: &'static str) -> Self {
        self.with(Presence::Text(default))
    }

    /// Returns the unit of the value, or an empty string.
    pub(crate) fn unit(&self) -> &'static str {
        match self.kind {
            FieldKind::Number { unit, .. } | FieldKind::Vector { unit, .. } => unit,
            _ => "",
        }
    }
}

impl FieldKind {
    /// Describes the allowed values in words.
    pub(crate) fn allowed(&self) -> Phrase {
        match self {
            Self::Number { unit, min, max } => {
                phrase!("allowed: a number from {min} to {most}", min = *min, most = measure(*max, unit))
            }
            Self::Integer { min, max } => {
                phrase!("allowed: a whole number from {min} to {max}", min = *min, max = *max)
            }
            Self::Flag => phrase!("allowed: true or false"),
            Self::Text(text) => text.allowed[0](),
            Self::Words { text, .. } => {
                phrase!("{text}; or a table with a text for each language", text = text.allowed[0]())
            }
            Self::Choice(words) => one_of(words),
            Self::Vector { unit, len, min, max } => phrase!(
                "allowed: {len} numbers, each from {min} to {most}",
                len = *len,
                min = *min,
                most = measure(*max, unit)
            ),
            Self::Texts(text) => text.allowed[1](),
            Self::Table(_) => phrase!("allowed: a table"),
            Self::Tables { min, max, .. } => {
                phrase!("allowed: {min} to {max} tables, each headed [[…]]", min = *min, max = *max)
            }
        }
    }
}

/// Lists the allowed names.
pub(crate) fn one_of(names: &[impl Borrow<str>]) -> Phrase {
    phrase!("allowed: {names}", names = names.join(", "))
}

/// Formats a value, followed by its unit if it has one.
pub(crate) fn measure(value: impl Display, unit: &str) -> String {
    if unit.is_empty() { value.to_string() } else { format!("{value} {unit}") }
}
