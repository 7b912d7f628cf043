//! Tables as CSV (RFC 4180, UTF-8), safe to open in a spreadsheet.

use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};

/// One cell of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Text, which a spreadsheet must not take for a formula.
    Text(String),
    /// A number, with a full stop.
    Number(f64),
    /// Nothing: a figure that does not exist.
    Empty,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<Option<f64>> for Cell {
    fn from(number: Option<f64>) -> Self {
        number.map_or(Self::Empty, Self::Number)
    }
}

impl From<bool> for Cell {
    fn from(yes: bool) -> Self {
        Self::from(if yes { "yes" } else { "no" })
    }
}

impl Cell {
    fn print(&self) -> String {
        match self {
            Self::Text(text) => neutral(text),
            Self::Number(number) => number.to_string(),
            Self::Empty => String::new(),
        }
    }
}

/// A text that no spreadsheet takes for a formula: one that begins like a formula gets an apostrophe before it, which
/// spreadsheets take for "this is text".
#[must_use]
pub fn neutral(text: &str) -> String {
    let formula = text.trim_start_matches(' ').starts_with(['=', '+', '-', '@', '\t', '\r', '\n']);
    if formula { format!("'{text}") } else { text.to_owned() }
}

/// A table as CSV: a line of names, then the rows.
///
/// # Errors
/// When a row has not as many cells as there are names.
pub fn csv(names: &[&str], rows: &[Vec<Cell>]) -> anyhow::Result<String> {
    let mut writer = csv::WriterBuilder::new().terminator(csv::Terminator::CRLF).from_writer(Vec::new());
    writer.write_record(names)?;
    for row in rows {
        writer.write_record(row.iter().map(Cell::print))?;
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}

/// A table as a file to be saved under a name.
///
/// # Errors
/// When a row has not as many cells as there are names.
pub fn download(file: &str, names: &[&str], rows: &[Vec<Cell>]) -> anyhow::Result<Response> {
    let body = csv(names, rows)?;
    let safe: String = file.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '-' }).collect();
    let disposition = format!("attachment; filename=\"{safe}.csv\"");
    Ok(([(CONTENT_TYPE, "text/csv; charset=utf-8".to_owned()), (CONTENT_DISPOSITION, disposition)], body)
        .into_response())
}

#[cfg(test)]
mod tests {
    //! A name that is a formula must stay a name, whatever opens the file; a negative number stays a number.

    use super::*;

    #[test]
    fn formulas_become_text_and_numbers_stay_numbers() {
        let row = vec![
            Cell::from("=HYPERLINK(\"http://x\")"),
            Cell::from("  @SUM(1)"),
            Cell::from("Müller, \"Ana\""),
            Cell::from(-1.5),
            Cell::from(None),
        ];
        let text = csv(&["a", "b", "c", "d", "e"], &[row]).expect("five cells under five names");
        assert_eq!(text, "a,b,c,d,e\r\n\"'=HYPERLINK(\"\"http://x\"\")\",'  @SUM(1),\"Müller, \"\"Ana\"\"\",-1.5,\r\n");
    }

    #[test]
    fn a_crooked_table_is_refused() {
        assert!(csv(&["a", "b"], &[vec![Cell::from("only one")]]).is_err());
    }
}
