//! Tables as CSV (RFC 4180, UTF-8), safe to open in a spreadsheet.

use std::collections::BTreeMap;

use anyhow::ensure;
use axum::body::Body;
use axum::http::HeaderName;
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};
use futures::future::ready;
use futures::{StreamExt, TryStream, TryStreamExt};
use model::ids::PersonId;

/// The decimal and column separators.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CsvDialect {
    /// Decimal point, comma between cells (RFC 4180).
    #[default]
    Point,
    /// Decimal comma, semicolon between cells, as spreadsheets expect in most of Europe.
    Comma,
}

impl CsvDialect {
    const fn delimiter(self) -> u8 {
        match self {
            Self::Point => b',',
            Self::Comma => b';',
        }
    }

    fn print_number(self, number: f64) -> String {
        match self {
            Self::Point => number.to_string(),
            Self::Comma => number.to_string().replace('.', ","),
        }
    }
}

/// One cell of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum CsvCell {
    /// Text, which a spreadsheet must not interpret as a formula.
    Text(String),
    /// A number, formatted by the dialect.
    Number(f64),
    /// Empty: a missing value.
    Empty,
}

impl From<&str> for CsvCell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for CsvCell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for CsvCell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<Option<f64>> for CsvCell {
    fn from(number: Option<f64>) -> Self {
        number.map_or(Self::Empty, Self::Number)
    }
}

impl From<bool> for CsvCell {
    fn from(yes: bool) -> Self {
        Self::from(if yes { "yes" } else { "no" })
    }
}

impl CsvCell {
    fn print(&self, dialect: CsvDialect) -> String {
        match self {
            Self::Text(text) => neutralise_cell(text),
            Self::Number(number) => dialect.print_number(*number),
            Self::Empty => String::new(),
        }
    }
}

/// Returns a text that no spreadsheet interprets as a formula: an apostrophe, which marks text, is
/// inserted before a formula at the start, and after each character at which a spreadsheet with
/// another separator may split the cell.
#[must_use]
pub fn neutralise_cell(text: &str) -> String {
    let mut safe = String::with_capacity(text.len() + 1);
    if text.trim_start_matches(' ').starts_with(['=', '+', '-', '@', '\t', '\r', '\n']) {
        safe.push('\'');
    }
    let mut previous = None;
    for c in text.chars() {
        let is_split = previous.is_some_and(|previous| matches!(previous, ',' | ';' | '\t' | '\r' | '\n'));
        if is_split && matches!(c, '=' | '+' | '-' | '@') {
            safe.push('\'');
        }
        safe.push(c);
        previous = Some(c);
    }
    safe
}

/// Formats a table as CSV: a header line, then the rows.
///
/// # Errors
/// When a row does not have one cell per column.
pub fn write_csv(names: &[&str], rows: &[Vec<CsvCell>]) -> anyhow::Result<String> {
    write_csv_as(CsvDialect::Point, names, rows)
}

/// Formats a table as CSV in a dialect.
///
/// # Errors
/// When a row does not have one cell per column.
pub fn write_csv_as(dialect: CsvDialect, names: &[&str], rows: &[Vec<CsvCell>]) -> anyhow::Result<String> {
    let heading = write_lines(dialect, [names.iter().map(|name| (*name).to_owned())])?;
    Ok(heading + &stream_lines(dialect, names.len(), rows)?)
}

/// Formats rows as lines, each of `width` cells.
fn stream_lines(dialect: CsvDialect, width: usize, rows: &[Vec<CsvCell>]) -> anyhow::Result<String> {
    let crooked = rows.iter().find(|row| row.len() != width);
    ensure!(crooked.is_none(), "a row of {} cells under {width} names", crooked.map_or(0, Vec::len));
    write_lines(dialect, rows.iter().map(|row| row.iter().map(|cell| cell.print(dialect))))
}

fn write_lines(
    dialect: CsvDialect,
    rows: impl IntoIterator<Item = impl Iterator<Item = String>>,
) -> anyhow::Result<String> {
    let mut writer = csv::WriterBuilder::new()
        .delimiter(dialect.delimiter())
        .terminator(csv::Terminator::CRLF)
        .from_writer(Vec::new());
    for row in rows {
        writer.write_record(row)?;
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}

/// Returns a file to save.
pub fn attach_file(media_type: &str, file: &str, body: impl IntoResponse) -> Response {
    let disposition = format!("attachment; filename=\"{file}\"");
    ([(CONTENT_TYPE, media_type), (CONTENT_DISPOSITION, disposition.as_str())], body).into_response()
}

/// Returns a table as a file download.
///
/// # Errors
/// When a row does not have one cell per column.
pub fn download_csv(file: &str, names: &[&str], rows: &[Vec<CsvCell>]) -> anyhow::Result<Response> {
    download_csv_as(CsvDialect::Point, file, names, rows)
}

/// Returns a table in a dialect as a file download.
///
/// # Errors
/// When a row does not have one cell per column.
pub fn download_csv_as(
    dialect: CsvDialect,
    file: &str,
    names: &[&str],
    rows: &[Vec<CsvCell>],
) -> anyhow::Result<Response> {
    Ok((csv_headers(file), write_csv_as(dialect, names, rows)?).into_response())
}

/// Returns a table of any length as a file download, streamed in batches of rows.
///
/// # Errors
/// When the header line cannot be formatted. A later failure aborts the response, so that no client
/// takes it for complete.
pub fn stream_csv(
    file: &str,
    names: &[&str],
    rows: impl TryStream<Ok = Vec<Vec<CsvCell>>, Error = anyhow::Error> + Send + 'static,
) -> anyhow::Result<Response> {
    let (heading, width) = (write_csv(names, &[])?, names.len());
    let bodies = rows.and_then(move |rows| ready(stream_lines(CsvDialect::Point, width, &rows))).inspect_err(|cause| {
        tracing::error!(cause = format!("{cause:#}"), "export interrupted");
    });
    let body = Body::from_stream(futures::stream::once(async { Ok(heading) }).chain(bodies.into_stream()));
    Ok((csv_headers(file), body).into_response())
}

/// Prepends a byte order mark, by which Excel recognises UTF-8.
#[must_use]
pub fn mark_byte_order(file: Response) -> Response {
    let (parts, body) = file.into_parts();
    let marked = futures::stream::once(async { Ok("\u{feff}".into()) }).chain(body.into_data_stream());
    Response::from_parts(parts, Body::from_stream(marked))
}

fn csv_headers(file: &str) -> [(HeaderName, String); 2] {
    let safe: String = file.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '-' }).collect();
    let disposition = format!("attachment; filename=\"{safe}.csv\"");
    [(CONTENT_TYPE, "text/csv; charset=utf-8".to_owned()), (CONTENT_DISPOSITION, disposition)]
}

/// Returns the cells `trainee_id` and `pseudonym`, since names are not unique.
#[must_use]
pub fn trainee_cells(id: PersonId, pseudonyms: &BTreeMap<PersonId, String>) -> Vec<CsvCell> {
    let pseudonym = pseudonyms.get(&id).map_or(CsvCell::Empty, |known| CsvCell::from(known.as_str()));
    vec![CsvCell::from(id.to_string()), pseudonym]
}

#[cfg(test)]
mod tests {
    //! A name that looks like a formula must remain text in every program; a negative number must
    //! remain a number.

    use super::*;

    #[test]
    fn formulas_become_text_and_numbers_stay_numbers() {
        let row = vec![
            CsvCell::from("=HYPERLINK(\"http://x\")"),
            CsvCell::from("  @SUM(1)"),
            CsvCell::from("Müller, \"Ana\""),
            CsvCell::from(-1.5),
            CsvCell::from(None),
        ];
        let text = write_csv(&["a", "b", "c", "d", "e"], &[row]).expect("five cells under five names");
        assert_eq!(text, "a,b,c,d,e\r\n\"'=HYPERLINK(\"\"http://x\"\")\",'  @SUM(1),\"Müller, \"\"Ana\"\"\",-1.5,\r\n");
    }

    #[test]
    fn a_cell_that_is_split_at_another_separator_holds_no_formula() {
        assert_eq!(neutralise_cell("Ana;=1+1,@x\n-2"), "Ana;'=1+1,'@x\n'-2");
        assert_eq!(neutralise_cell("good; a - b = c"), "good; a - b = c");
    }

    #[test]
    fn a_decimal_comma_goes_with_semicolons() {
        let row = vec![CsvCell::from("Müller; Ana"), CsvCell::from(-1.5), CsvCell::from("1,5")];
        let text = write_csv_as(CsvDialect::Comma, &["a", "b", "c"], &[row]).expect("three cells under three names");
        assert_eq!(text, "a;b;c\r\n\"Müller; Ana\";-1,5;1,5\r\n");
    }

    #[test]
    fn a_crooked_table_is_refused() {
        assert!(write_csv(&["a", "b"], &[vec![CsvCell::from("only one")]]).is_err());
    }
}
