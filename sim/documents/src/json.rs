//! Reads cases in JSON and locates errors in them.

use law::axial::ParamError;
use phrase::{Phrase, phrase};
use serde::de::DeserializeOwned;

use crate::error::{DocumentError, Issue};
use crate::source::find_position;

/// A case's text and its file name.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Json<'t> {
    /// The file name as the caller passed it.
    pub file: &'t str,
    /// Content.
    pub text: &'t str,
}

impl Json<'_> {
    /// Parses the text in the form of a folder's reference cases.
    ///
    /// # Errors
    /// The first value that does not have that form, with line and column.
    pub(crate) fn read<T: DeserializeOwned>(self, form: &str) -> Result<T, DocumentError> {
        serde_json::from_str(self.text).map_err(|error| {
            let (line, column) = (error.line(), error.column().max(1));
            self.issue(line, column, "case", [Phrase::data(error), phrase!("allowed: the form of {form}", form = form)])
        })
    }

    /// Returns the error for an invalid parameter, at its position in the text.
    pub(crate) fn refused(self, ParamError { field, value, unit, allowed }: ParamError) -> DocumentError {
        let (line, column) = find_position(self.text, byte_offset(self.text, &field));
        self.issue(line, column, &field, [Phrase::data(format_args!("{value} {unit}")), Phrase::data(allowed)])
    }

    fn issue(self, line: usize, column: usize, field: &str, [found, allowed]: [Phrase; 2]) -> DocumentError {
        let (file, field) = (self.file.to_owned(), field.to_owned());
        DocumentError::from(Issue { file, line, column, field, found, allowed })
    }
}

/// Returns the byte offset in JSON of a field such as `layers[1].thickness_m` or `sample_r_m[3]`,
/// or 0.
///
/// Every table of a list has each of its keys exactly once, so the n-th occurrence of the key
/// belongs to table n. A number in a list gets the position of the list.
fn byte_offset(json: &str, field: &str) -> usize {
    let (parent, key) = field.rsplit_once('.').unwrap_or(("", field));
    let key = key.split_once('[').map_or(key, |(list, _)| list);
    let nth = parent.split(['[', ']']).nth(1).and_then(|n| n.parse().ok()).unwrap_or(0);
    let quoted = format!("\"{key}\"");
    let is_key = |at: &usize| json[at + quoted.len()..].trim_start().starts_with(':');
    json.match_indices(&quoted).map(|(at, _)| at).filter(is_key).nth(nth).unwrap_or(0)
}
