//! A case in JSON: read, and its mistakes placed.

use law::axial::ParamError;
use phrase::{Phrase, phrase};
use serde::de::DeserializeOwned;

use crate::error::{DocumentError, Issue};
use crate::source::find_position;

/// A case's text, with the name people know it by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Json<'t> {
    /// The file as it was named to us.
    pub file: &'t str,
    /// What it holds.
    pub text: &'t str,
}

impl Json<'_> {
    /// What is written, in the form of the reference cases of a folder.
    ///
    /// # Errors
    /// The first thing that is not of that form, with line and column.
    pub(crate) fn read<T: DeserializeOwned>(self, form: &str) -> Result<T, DocumentError> {
        serde_json::from_str(self.text).map_err(|error| {
            let (line, column) = (error.line(), error.column().max(1));
            self.issue(line, column, "case", [Phrase::data(error), phrase!("allowed: the form of {form}", form = form)])
        })
    }

    /// A number that cannot be, placed where it is written.
    pub(crate) fn refused(self, ParamError { field, value, unit, allowed }: ParamError) -> DocumentError {
        let (line, column) = find_position(self.text, byte_offset(self.text, &field));
        self.issue(line, column, &field, [Phrase::data(format_args!("{value} {unit}")), Phrase::data(allowed)])
    }

    fn issue(self, line: usize, column: usize, field: &str, [found, allowed]: [Phrase; 2]) -> DocumentError {
        let (file, field) = (self.file.to_owned(), field.to_owned());
        DocumentError::from(Issue { file, line, column, field, found, allowed })
    }
}

/// Byte offset in JSON of a field such as `layers[1].thickness_m` or `sample_r_m[3]`, or 0.
///
/// Every table of a list has each of its keys exactly once, so table n holds the n-th place where the key stands. A number
/// in a list is placed where the list begins.
fn byte_offset(json: &str, field: &str) -> usize {
    let (parent, key) = field.rsplit_once('.').unwrap_or(("", field));
    let key = key.split_once('[').map_or(key, |(list, _)| list);
    let nth = parent.split(['[', ']']).nth(1).and_then(|n| n.parse().ok()).unwrap_or(0);
    let quoted = format!("\"{key}\"");
    let is_key = |at: &usize| json[at + quoted.len()..].trim_start().starts_with(':');
    json.match_indices(&quoted).map(|(at, _)| at).filter(is_key).nth(nth).unwrap_or(0)
}
