//! User-facing texts in the languages of their document.
//!
//! A text is either a plain string in the document's own language, or a table with a text for each
//! language: `title = { en = "…", de = "…" }`. A document with such a table lists its `languages`,
//! its own first. The meaning of plain strings has not changed.

use std::collections::BTreeMap;
use std::fmt;

use phrase::{Phrase, phrase};
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};

use crate::walk::Walked;

/// Key of the text in the document's own language, after reading.
const OWN: &str = "own";

/// Keys of the texts that may be multilingual.
const KEYS: [&str; 7] = ["title", "briefing", "description", "why", "message", "alt", "caption"];

/// A text in the language of its document, with translations.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(from = "StoredWording")]
pub struct Wording {
    own: String,
    others: BTreeMap<String, String>,
}

/// The serialised form: a plain string, or a table of texts by language.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum StoredWording {
    Plain(String),
    Languages(BTreeMap<String, String>),
}

impl Wording {
    /// Creates a text with translations by language code.
    #[must_use]
    pub const fn new(own: String, others: BTreeMap<String, String>) -> Self {
        Self { own, others }
    }

    /// Returns the text in a language, or in the document's own language if there is no
    /// translation.
    #[must_use]
    pub fn in_language(&self, language: &str) -> &str {
        self.others.get(language).map_or(&self.own, String::as_str)
    }

    /// Returns the text in the document's own language, which is hashed, recorded and compared.
    #[must_use]
    pub fn own(&self) -> &str {
        &self.own
    }

    /// Returns the translations by language code.
    #[must_use]
    pub const fn others(&self) -> &BTreeMap<String, String> {
        &self.others
    }

    /// Removes leading and trailing white space.
    pub(crate) fn trimmed(self) -> Self {
        let trim = |text: String| text.trim().to_owned();
        Self { own: trim(self.own), others: self.others.into_iter().map(|(code, text)| (code, trim(text))).collect() }
    }

    /// Serialises only the text in the document's own language.
    ///
    /// # Errors
    /// Those of the serializer.
    pub(crate) fn serialize_own<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.own)
    }
}

impl fmt::Display for Wording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.own)
    }
}

impl From<&Wording> for Phrase {
    fn from(text: &Wording) -> Self {
        Self::Languages { own: text.own.clone(), others: text.others.clone() }
    }
}

impl From<&str> for Wording {
    fn from(own: &str) -> Self {
        Self::new(own.to_owned(), BTreeMap::new())
    }
}

impl From<String> for Wording {
    fn from(own: String) -> Self {
        Self::new(own, BTreeMap::new())
    }
}

impl From<StoredWording> for Wording {
    fn from(stored: StoredWording) -> Self {
        match stored {
            StoredWording::Plain(own) => own.into(),
            StoredWording::Languages(mut others) => Self::new(others.remove(OWN).unwrap_or_default(), others),
        }
    }
}

impl Serialize for Wording {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.others.is_empty() {
            return self.serialize_own(serializer);
        }
        let own = (OWN.to_owned(), self.own.clone());
        let all = self.others.iter().map(|(code, text)| (code.clone(), text.clone()));
        StoredWording::Languages(std::iter::once(own).chain(all).collect()).serialize(serializer)
    }
}

/// An invalid multilingual text.
struct WordingFault {
    field: String,
    found: Phrase,
    allowed: Phrase,
}

/// Checks every multilingual text and converts it to the form that [`Wording`] deserialises.
pub(crate) fn settle_wordings(doc: &mut Walked) {
    let languages: Vec<String> =
        doc.value["languages"].as_array().into_iter().flatten().filter_map(|l| l.as_str().map(str::to_owned)).collect();
    let mut faults = Vec::new();
    for (at, language) in languages.iter().enumerate() {
        if languages[..at].contains(language) {
            let (field, found) = ("languages".to_owned(), Phrase::quoted(language));
            faults.push(WordingFault { field, found, allowed: phrase!("each must be unique") });
        }
    }
    settle_value(&mut doc.value, "", &languages, &mut faults);
    for WordingFault { field, found, allowed } in faults {
        // A refused text is present and already has its issue.
        if !(doc.is_written(&field) && field.rsplit('.').next() == languages.first().map(String::as_str)) {
            doc.refuse(&field, found, allowed);
        }
    }
}

fn settle_value(value: &mut Value, path: &str, languages: &[String], faults: &mut Vec<WordingFault>) {
    match value {
        Value::Object(map) => {
            for (key, inner) in map {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                match inner {
                    Value::Object(texts) if KEYS.contains(&key.as_str()) => {
                        settle_texts(texts, &path, languages, faults)
                    }
                    _ => settle_value(inner, &path, languages, faults),
                }
            }
        }
        Value::Array(list) => {
            for (at, inner) in list.iter_mut().enumerate() {
                settle_value(inner, &format!("{path}[{at}]"), languages, faults);
            }
        }
        _ => {}
    }
}

fn settle_texts(texts: &mut Map<String, Value>, path: &str, languages: &[String], faults: &mut Vec<WordingFault>) {
    let Some(first) = languages.first() else {
        let found = phrase!("a text in several languages");
        let allowed = phrase!(
            "the document declares no languages: add languages = [\"en\", \"de\"] below its title, its main language \
             first"
        );
        faults.push(WordingFault { field: path.to_owned(), found, allowed });
        return;
    };
    for language in texts.keys().filter(|language| !languages.contains(language)) {
        let allowed = phrase!("allowed: {languages}, the languages of this document", languages = languages.join(", "));
        faults.push(WordingFault {
            field: format!("{path}.{language}"),
            found: phrase!("a text in another language"),
            allowed,
        });
    }
    match texts.remove(first) {
        Some(own) => drop(texts.insert(OWN.to_owned(), own)),
        None => faults.push(WordingFault {
            field: format!("{path}.{first}"),
            found: phrase!("missing"),
            allowed: phrase!("a text in the first of the document's languages is required"),
        }),
    }
}

#[cfg(test)]
mod tests {
    //! Documents written before translations keep their meaning, and a reader gets their own
    //! language or the document's.

    use super::*;
    use crate::{Curriculum, DocumentError};

    const PLAIN: &str =
        "id = \"c\"\ntitle = \"Plain\"\n[mastery]\nrule = \"passes\"\npasses = 1\nof = 1\n[[exercise]]\nfile = \"x\"\n";

    fn issues(head: &str) -> Vec<String> {
        let text = PLAIN.replace("title = \"Plain\"\n", head);
        let refused: DocumentError =
            Curriculum::from_parts(text.as_bytes(), |_| None).expect_err("without its exercise");
        let issues = refused.issues.iter().filter(|issue| !issue.field.starts_with("exercise"));
        issues.map(|issue| format!("{}: {}", issue.field, issue.found)).collect()
    }

    #[test]
    fn a_text_is_plain_or_has_the_languages_that_its_document_names() {
        assert!(issues("title = \"Plain\"\n").is_empty());
        assert!(issues("title = \"Plain\"\nlanguages = [\"en\"]\n").is_empty());
        assert!(issues("title = { en = \"A\", de = \"B\" }\nlanguages = [\"en\", \"de\"]\n").is_empty());
        assert!(issues("title = { en = \"A\" }\nlanguages = [\"en\", \"de\"]\n").is_empty(), "others may be missing");
        for (head, field) in [
            ("title = { en = \"A\" }\n", "title: a text in several languages"),
            ("title = { de = \"B\" }\nlanguages = [\"en\", \"de\"]\n", "title.en: missing"),
            ("title = { en = \"A\", fr = \"B\" }\nlanguages = [\"en\"]\n", "title.fr: a text in another language"),
            ("title = { en = \"A\", tlh = \"B\" }\nlanguages = [\"en\"]\n", "title.tlh: unknown key"),
            ("title = \"A\"\nlanguages = [\"en\", \"en\"]\n", "languages: \"en\""),
            ("title = { en = \"\" }\nlanguages = [\"en\"]\n", "title.en: \"\""),
            ("title = 1\n", "title: 1"),
        ] {
            assert_eq!(issues(head), [field], "{head}");
        }
    }

    #[test]
    fn a_reader_gets_their_language_or_the_documents_own() {
        let wording = Wording::new("A".to_owned(), BTreeMap::from([("de".to_owned(), "B".to_owned())]));
        assert_eq!(["de", "en", "fr"].map(|language| wording.in_language(language)), ["B", "A", "A"]);
        for text in [wording, Wording::from("plain")] {
            let stored = serde_json::to_string(&text).expect("JSON");
            assert_eq!(serde_json::from_str::<Wording>(&stored).expect("a text"), text, "{stored}");
        }
        assert_eq!(serde_json::to_string(&Wording::from("plain")).expect("JSON"), "\"plain\"");
    }
}
