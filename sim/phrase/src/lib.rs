//! Translatable sentences: English text with named values.
//!
//! `Display` formats them in English. The crate `words` translates the text and inserts the same
//! values.

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter, Write};

use serde::{Serialize, Serializer};

/// A user-facing text.
#[derive(Clone, Debug, PartialEq)]
pub enum Phrase {
    /// A name or a literal value: the same in every language.
    Data(String),
    /// A word that is also data and may have a translation.
    Known(String),
    /// Digits with a decimal point, to be localised. A unit may follow.
    Number(String),
    /// A text that its author wrote in several languages.
    Languages {
        /// The text in the language of its document.
        own: String,
        /// The other languages, by code.
        others: BTreeMap<String, String>,
    },
    /// A sentence, created with [`phrase!`](crate::phrase!).
    Sentence {
        /// The English text, with the names of values in braces.
        words: &'static str,
        /// The value of each name.
        values: Vec<(&'static str, Self)>,
    },
}

/// Creates a sentence with named values: `phrase!("allowed: at most {most} mm", most = 200)`.
#[macro_export]
macro_rules! phrase {
    ($words:literal $(, $name:ident = $value:expr)* $(,)?) => {
        $crate::Phrase::Sentence {
            words: $words,
            values: vec![$((stringify!($name), $crate::Phrase::from($value))),*],
        }
    };
}

/// Marks a sentence for the catalogues that is translated later: a constant, or a word that is also
/// data.
#[macro_export]
macro_rules! sentence {
    ($sentence:literal) => {
        $sentence
    };
}

impl Phrase {
    /// Creates a text that is the same in every language.
    pub fn data(value: impl Display) -> Self {
        Self::Data(value.to_string())
    }

    /// Creates a sentence without values from a constant defined elsewhere.
    #[must_use]
    pub const fn sentence(words: &'static str) -> Self {
        Self::Sentence { words, values: Vec::new() }
    }

    /// Creates a quoted literal text.
    #[must_use]
    pub fn quoted(text: &str) -> Self {
        Self::Data(format!("\"{text}\""))
    }

    /// Creates a number with `decimals` decimal places.
    #[must_use]
    pub fn number(value: f64, decimals: usize) -> Self {
        Self::Number(format!("{value:.decimals$}"))
    }
}

impl Display for Phrase {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Data(text) | Self::Known(text) | Self::Number(text) | Self::Languages { own: text, .. } => {
                f.write_str(text)
            }
            Self::Sentence { words, values } => {
                let values: Vec<(&str, &dyn Display)> =
                    values.iter().map(|(name, value)| (*name, value as _)).collect();
                f.write_str(&fill(words, &values))
            }
        }
    }
}

/// Serialises as English text.
impl Serialize for Phrase {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

macro_rules! from_data {
    ($($kind:ty)+) => {
        $(impl From<$kind> for Phrase {
            fn from(value: $kind) -> Self {
                Self::data(value)
            }
        })+
    };
}

from_data!(&str &String String f64 i64 u64 usize);

/// Replaces the names in braces by their values. A name without a value is left unchanged.
#[must_use]
pub fn fill(sentence: &str, values: &[(&str, &dyn Display)]) -> String {
    let mut filled = String::with_capacity(sentence.len() + 16);
    let mut rest = sentence;
    while let Some((before, after)) = rest.split_once('{') {
        filled.push_str(before);
        let value = after
            .split_once('}')
            .and_then(|(name, rest)| values.iter().find(|(known, _)| *known == name).map(|(_, value)| (value, rest)));
        rest = match value {
            Some((value, rest)) => {
                // Writing to a String fails only if the value's own Display does.
                let _ = write!(filled, "{value}");
                rest
            }
            None => {
                filled.push('{');
                after
            }
        };
    }
    filled + rest
}

#[cfg(test)]
mod tests {
    //! A sentence must contain its values and read in English exactly as written; values must not
    //! be expanded again as text.

    use super::{Phrase, fill};

    #[test]
    fn values_stand_where_they_are_named() {
        assert_eq!(fill("{a} of {b}, {a}", &[("a", &3), ("b", &5)]), "3 of 5, 3");
        assert_eq!(fill("{unknown} {a", &[("a", &3)]), "{unknown} {a");
        assert_eq!(fill("{a}", &[("a", &"{a}")]), "{a}", "a value is not read again");
    }

    #[test]
    fn a_sentence_may_hold_another() {
        let why = crate::phrase!("a mesh of {size} mm; check its unit", size = Phrase::number(2.449, 1));
        let whole = crate::phrase!("{file}: {why}", file = Phrase::quoted("a.stl"), why = why);
        assert_eq!(whole.to_string(), "\"a.stl\": a mesh of 2.4 mm; check its unit");
    }
}
