//! What a document may say: each field's key, unit, range, default and meaning, written once.
//!
//! The reader ([`crate::walk`]) and the JSON Schema ([`crate::schema`]) both derive from these tables, so neither can
//! drift from the other.

use std::borrow::Borrow;
use std::fmt::Display;
use std::ops::RangeInclusive;

use phrase::{Phrase, phrase};

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

/// A TOML table: the fields it may hold, in the order people write them.
#[derive(Debug)]
pub(crate) struct DescribedTable {
    /// What the table is, for the schema.
    pub doc: &'static str,
    /// Its fields.
    pub fields: &'static [DescribedField],
}

/// One field of a table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DescribedField {
    /// The key, with the unit in it.
    pub key: &'static str,
    /// What its value may be.
    pub kind: FieldKind,
    /// Whether it may be left out, and what then holds.
    pub presence: Presence,
    /// What it means.
    pub doc: &'static str,
}

/// What a value may be.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FieldKind {
    /// A finite number, ends included.
    Number { unit: &'static str, min: f64, max: f64 },
    /// A whole number, ends included.
    Integer { min: i64, max: i64 },
    /// `true` or `false`.
    Flag,
    /// Text of a certain form.
    Text(&'static Text),
    /// Text of a certain form, or a table with such a text for each of the document's languages.
    Words { text: &'static Text, table: &'static DescribedTable },
    /// One of some words.
    Choice(&'static [&'static str]),
    /// So many finite numbers, each within the ends.
    Vector { unit: &'static str, len: usize, min: f64, max: f64 },
    /// A list of texts.
    Texts(&'static Text),
    /// A table.
    Table(&'static DescribedTable),
    /// An array of tables of a bounded length.
    Tables { table: &'static DescribedTable, min: usize, max: usize },
}

/// Whether a field may be left out.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Presence {
    /// It must be there.
    Required,
    /// It may be left out, and then there is none.
    Optional,
    /// Left out, it is this number.
    Number(f64),
    /// Left out, it is this text.
    Text(&'static str),
    /// Left out, it is this flag.
    Flag(bool),
    /// Left out, it is an empty list, or a table of defaults.
    Empty,
}

impl DescribedField {
    /// A field that may be left out.
    const fn new(key: &'static str, kind: FieldKind, doc: &'static str) -> Self {
        Self { key, kind, presence: Presence::Optional, doc }
    }

    /// A number in `unit` within `range`.
    const fn number(key: &'static str, unit: &'static str, range: RangeInclusive<f64>, doc: &'static str) -> Self {
        Self::new(key, FieldKind::Number { unit, min: *range.start(), max: *range.end() }, doc)
    }

    /// Three numbers in mm, each within ±`limit`.
    const fn place(key: &'static str, limit: f64, doc: &'static str) -> Self {
        Self::new(key, FieldKind::Vector { unit: "mm", len: 3, min: -limit, max: limit }, doc)
    }

    /// Text of a form.
    const fn text(key: &'static str, text: &'static Text, doc: &'static str) -> Self {
        Self::new(key, FieldKind::Text(text), doc)
    }

    /// A line that people read, in one language or several.
    const fn said_line(key: &'static str, doc: &'static str) -> Self {
        Self::new(key, FieldKind::Words { text: &Text::LINE, table: &instrument::LINES }, doc)
    }

    /// Paragraphs that people read, in one language or several.
    const fn said_prose(key: &'static str, doc: &'static str) -> Self {
        Self::new(key, FieldKind::Words { text: &Text::PROSE, table: &instrument::PROSES }, doc)
    }

    /// The codes of a document's languages.
    const fn languages() -> Self {
        let doc = "Codes of its languages, its own first; needed where a text is written in several";
        Self::new("languages", FieldKind::Texts(&Text::ID), doc).with(Presence::Empty)
    }

    /// The same field with another presence.
    const fn with(self, presence: Presence) -> Self {
        Self { presence, ..self }
    }

    /// The same field, required.
    const fn required(self) -> Self {
        self.with(Presence::Required)
    }

    /// The same field with a number as default.
    const fn or(self, default: f64) -> Self {
        self.with(Presence::Number(default))
    }

    /// The same field with a text as default.
    const fn or_text(self, default: &'static str) -> Self {
        self.with(Presence::Text(default))
    }

    /// The unit that the key carries, or nothing.
    pub(crate) fn unit(&self) -> &'static str {
        match self.kind {
            FieldKind::Number { unit, .. } | FieldKind::Vector { unit, .. } => unit,
            _ => "",
        }
    }
}

impl FieldKind {
    /// What is allowed, in words.
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

/// One of some names.
pub(crate) fn one_of(names: &[impl Borrow<str>]) -> Phrase {
    phrase!("allowed: {names}", names = names.join(", "))
}

/// A value as it is written, and its unit where it has one.
pub(crate) fn measure(value: impl Display, unit: &str) -> String {
    if unit.is_empty() { value.to_string() } else { format!("{value} {unit}") }
}
