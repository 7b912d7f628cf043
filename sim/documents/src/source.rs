//! The text of a document and positions in it.

use std::collections::BTreeSet;

use data_encoding::HEXLOWER;
use phrase::{Phrase, phrase};
use sha2::{Digest, Sha256};
use toml::{Table, Value};

use crate::error::{DocumentError, Issue};

/// Maximum size of a document, in bytes; bounds the work caused by a malicious document full of
/// errors.
pub const MOST_BYTES: usize = 256 * 1024;

/// A document's text and its file name.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    /// The file name as the caller passed it.
    pub file: String,
    text: String,
    /// Lower-case hexadecimal SHA-256 of the bytes.
    pub sha256: String,
}

impl Source {
    /// Decodes a document's bytes.
    ///
    /// # Errors
    /// Too many bytes, or bytes that are not UTF-8.
    pub(crate) fn new(file: &str, bytes: &[u8]) -> Result<Self, DocumentError> {
        let sha256 = HEXLOWER.encode(&Sha256::digest(bytes));
        if bytes.len() > MOST_BYTES {
            let source = Self { file: file.to_owned(), text: String::new(), sha256 };
            let found = phrase!("{count} bytes", count = bytes.len());
            let allowed = phrase!("allowed: at most {most} bytes", most = MOST_BYTES);
            return Err(source.issue(0, "document", found, allowed).into());
        }
        match std::str::from_utf8(bytes) {
            Ok(text) => Ok(Self { file: file.to_owned(), text: text.to_owned(), sha256 }),
            Err(e) => {
                let good = String::from_utf8_lossy(&bytes[..e.valid_up_to()]).into_owned();
                let source = Self { file: file.to_owned(), text: good, sha256 };
                let [found, allowed] = [phrase!("bytes that are not UTF-8"), phrase!("allowed: UTF-8 text")];
                Err(source.issue(e.valid_up_to(), "document", found, allowed).into())
            }
        }
    }

    /// The text.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Creates an issue at a byte offset.
    pub(crate) fn issue(&self, offset: usize, field: &str, found: Phrase, allowed: Phrase) -> Issue {
        let (line, column) = find_position(&self.text, offset);
        Issue { file: self.file.clone(), line, column, field: field.to_owned(), found, allowed }
    }

    /// Returns the text in a range of bytes, cut to one short line.
    pub(crate) fn excerpt(&self, span: std::ops::Range<usize>) -> String {
        let written = self.text.get(span).unwrap_or_default();
        let line = written.lines().next().unwrap_or_default();
        let short: String = line.chars().take(60).collect();
        if short.len() < written.len() { format!("{short}…") } else { short }
    }
}

/// Returns line and column of a byte offset, both from 1, the column in characters.
pub(crate) fn find_position(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let start = before.rfind('\n').map_or(0, |at| at + 1);
    (1 + before.matches('\n').count(), 1 + before[start..].chars().count())
}

/// Returns every text value in a document, which includes all file names; empty if the document is
/// not TOML.
#[must_use]
pub fn list_named_texts(document: &[u8]) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let text = std::str::from_utf8(document).ok().filter(|text| text.len() <= MOST_BYTES);
    if let Some(table) = text.and_then(|text| text.parse::<Table>().ok()) {
        collect_texts(&Value::Table(table), &mut found);
    }
    found
}

fn collect_texts(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::String(text) => drop(found.insert(text.clone())),
        Value::Array(values) => values.iter().for_each(|value| collect_texts(value, found)),
        Value::Table(table) => table.iter().for_each(|(_, value)| collect_texts(value, found)),
        _ => {}
    }
}

/// Loads a file that a document names, or returns the reason why it cannot.
pub(crate) type Find<'f> = &'f dyn Fn(&str) -> Result<Vec<u8>, Phrase>;

/// The files that a document names, with their content.
pub(crate) type Files = Vec<(String, Vec<u8>)>;

#[cfg(test)]
mod tests {
    //! Columns count characters, not bytes; lines and columns start at 1.

    use super::find_position;

    #[test]
    fn positions_count_from_one_in_characters() {
        let text = "a = 1\nµm = 2\n";
        assert_eq!(find_position(text, 0), (1, 1));
        assert_eq!(find_position(text, 6), (2, 1));
        assert_eq!(find_position(text, text.find('2').unwrap()), (2, 6));
        assert_eq!(find_position(text, 999), (3, 1));
    }
}
