//! The forms of text in documents.

use phrase::{Phrase, phrase};

/// A form of text: a pattern for the schema and a predicate for the reader.
#[derive(Debug)]
pub(crate) struct Text {
    /// The allowed values in words: for a single text, and for each text of a list.
    pub allowed: [fn() -> Phrase; 2],
    /// Minimum number of characters.
    pub min: usize,
    /// Maximum number of characters.
    pub max: usize,
    /// Regular expression for the schema (ECMA 262), equivalent to `allows`.
    pub pattern: &'static str,
    /// Returns whether a character is allowed at a position, counted from 0.
    pub allows: fn(usize, char) -> bool,
}

impl Text {
    /// An identifier.
    pub(crate) const ID: Self = Self {
        allowed: [
            || phrase!("allowed: 1 to 64 letters, digits, - or _, the first a letter or digit"),
            || phrase!("allowed: a list of texts, each 1 to 64 letters, digits, - or _, the first a letter or digit"),
        ],
        min: 1,
        max: 64,
        pattern: "^[A-Za-z0-9][A-Za-z0-9_-]*$",
        allows: |at, c| c.is_ascii_alphanumeric() || (at > 0 && (c == '-' || c == '_')),
    };

    /// A name that may be the suffix of a metric id, and therefore contains no dot.
    pub(crate) const NAME: Self = Self {
        allowed: [
            || phrase!("allowed: 1 to 60 characters without a dot or line break"),
            || phrase!("allowed: a list of texts, each 1 to 60 characters without a dot or line break"),
        ],
        min: 1,
        max: 60,
        pattern: "^[^.\\u0000-\\u001f\\u007f]+$",
        allows: |_, c| c != '.' && !c.is_ascii_control(),
    };

    /// One line of user-facing text.
    pub(crate) const LINE: Self = Self {
        allowed: [
            || phrase!("allowed: 1 to 300 characters on one line"),
            || phrase!("allowed: a list of texts, each 1 to 300 characters on one line"),
        ],
        min: 1,
        max: 300,
        pattern: "^[^\\u0000-\\u001f\\u007f]+$",
        allows: |_, c| !c.is_ascii_control(),
    };

    /// File name of a picture next to the document. The picture reader checks the extension
    /// together with the content.
    pub(crate) const PICTURE: Self = Self {
        allowed: [
            || {
                phrase!(
                    "allowed: 5 to 64 letters, digits, dots, - or _, the first a letter or digit, and .png or .jpg at the end"
                )
            },
            || {
                phrase!(
                    "allowed: a list of texts, each 5 to 64 letters, digits, dots, - or _, the first a letter or digit, and .png or \
                     .jpg at the end"
                )
            },
        ],
        min: 5,
        max: 64,
        pattern: "^[A-Za-z0-9][A-Za-z0-9._-]*\\.(png|jpg)$",
        allows: |at, c| c.is_ascii_alphanumeric() || (at > 0 && matches!(c, '-' | '_' | '.')),
    };

    /// Paragraphs.
    pub(crate) const PROSE: Self = Self {
        allowed: [
            || phrase!("allowed: at most 8000 characters"),
            || phrase!("allowed: a list of texts, each at most 8000 characters"),
        ],
        min: 0,
        max: 8000,
        pattern: "",
        allows: |_, _| true,
    };

    /// Returns whether `text` has this form.
    pub(crate) fn admits(&self, text: &str) -> bool {
        (self.min..=self.max).contains(&text.chars().count())
            && text.chars().enumerate().all(|(at, c)| (self.allows)(at, c))
    }
}
