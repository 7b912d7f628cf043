//! Sentences that somebody may want in another language: English words, and the values that stand in them.
//!
//! `Display` says them in English. Whoever has a catalogue looks the words up and fills in the same values.

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter, Write};

use serde::{Serialize, Serializer};

/// Something to be said to people.
#[derive(Clone, Debug, PartialEq)]
pub enum Phrase {
    /// A name, or a value as somebody wrote it: the same in every language.
    Data(String),
    /// A word that is data as well, which a language may know.
    Known(String),
    /// Digits with a decimal point, for people to read: a language may write another sign. A unit may follow.
    Number(String),
    /// A text that its author wrote in several languages.
    Languages {
        /// In the language of its document.
        own: String,
        /// In others, by their codes.
        others: BTreeMap<String, String>,
    },
    /// Words, made by [`phrase!`](crate::phrase!).
    Sentence {
        /// In English, with the names of values in braces.
        words: &'static str,
        /// What stands at each name.
        values: Vec<(&'static str, Self)>,
    },
}

/// A sentence with its values by name: `phrase!("allowed: at most {most} mm", most = 200)`.
#[macro_export]
macro_rules! phrase {
    ($words:literal $(, $name:ident = $value:expr)* $(,)?) => {
        $crate::Phrase::Sentence {
            words: $words,
            values: vec![$((stringify!($name), $crate::Phrase::from($value))),*],
        }
    };
}

/// Marks a sentence that is said later for the catalogues: a constant, or a word that is also data.
#[macro_export]
macro_rules! sentence {
    ($sentence:literal) => {
        $sentence
    };
}

impl Phrase {
    /// What is the same in every language.
    pub fn data(value: impl Display) -> Self {
        Self::Data(value.to_string())
    }

    /// A sentence without values, which stands in a constant elsewhere.
    #[must_use]
    pub const fn sentence(words: &'static str) -> Self {
        Self::Sentence { words, values: Vec::new() }
    }

    /// A text as somebody wrote it, in quotes.
    #[must_use]
    pub fn quoted(text: &str) -> Self {
        Self::Data(format!("\"{text}\""))
    }

    /// A number with so many decimals.
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

/// As text, in English.
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

/// Puts values where a sentence names them in braces. A name without a value stays as it is.
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
                // Writing into a String fails only where the value's own Display does.
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
    //! A sentence must hold its values, and read in English as it was written. Fails when a value is lost, or read again
    //! as if it were words.

    use super::{Phrase, fill};

    #[test]
    fn values_stand_where_they_are_named() {
        assert_eq!(fill("{a} of {b}, {a}", &[("a", &3), ("b", &5)]), "3 of 5, 3");
        assert_eq!(fill("{unknown} {a", &[("a", &3)]), "{unknown} {a");
        assert_eq!(fill("{a}", &[("a", &"{a}")]), "{a}", "a value is not read again");
    }

    #[test]
    fn a_sentence_may_hold_another() {
        let why = crate::phrase!("a mesh of {size} mm; is its unit right?", size = Phrase::number(2.449, 1));
        let whole = crate::phrase!("{file}: {why}", file = Phrase::quoted("a.stl"), why = why);
        assert_eq!(whole.to_string(), "\"a.stl\": a mesh of 2.4 mm; is its unit right?");
    }
}
