//! Titles of exercises and courses in several languages: all are stored together, and the reader's
//! language is chosen when they are read.
//!
//! Only this module chooses the language of a title. A title in one language is stored unchanged.

use documents::Wording;

/// Separator between the languages of a stored text, which no title may contain.
const BETWEEN: char = '\u{1f}';

/// A text in several languages, as stored in a column.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type), sqlx(transparent))]
pub struct StoredTitle(String);

/// Encodes a text in all its languages for a column: its own language first, then each other with
/// its code.
#[must_use]
pub fn store_wording(wording: &Wording) -> String {
    let mut stored = wording.own().to_owned();
    for (language, text) in wording.others() {
        stored.push(BETWEEN);
        stored.push_str(language);
        stored.push('=');
        stored.push_str(text);
    }
    stored
}

impl StoredTitle {
    /// Returns the text in a language, or else in its own language.
    fn in_language(self, language: &str) -> String {
        let mut parts = self.0.split(BETWEEN);
        let own = parts.next().unwrap_or_default();
        let other = parts.find_map(|part| part.strip_prefix(language)?.strip_prefix('='));
        other.unwrap_or(own).to_owned()
    }
}

impl From<StoredTitle> for String {
    fn from(title: StoredTitle) -> Self {
        title.in_language(words::current().code())
    }
}

#[cfg(test)]
mod tests {
    //! Checks that titles from before there were languages are unchanged, and that no text of
    //! another language is returned.

    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn a_title_is_read_in_the_readers_language_or_its_own() {
        let others =
            [("de", "Im Fett anhalten"), ("fr", "de=Arrêt")].map(|(code, text)| (code.to_owned(), text.to_owned()));
        let stored = store_wording(&Wording::new("Stop in the fat".to_owned(), BTreeMap::from(others)));
        let read = |language: &str| StoredTitle(stored.clone()).in_language(language);
        assert_eq!(
            ["en", "de", "fr", "d"].map(read),
            ["Stop in the fat", "Im Fett anhalten", "de=Arrêt", "Stop in the fat"]
        );
        let plain = store_wording(&Wording::from("de=plain"));
        assert_eq!(plain, "de=plain");
        assert_eq!(StoredTitle(plain).in_language("de"), "de=plain");
    }
}
