//! A roster as a table: headings, and rows with their line numbers in the file.

use std::collections::BTreeSet;

use csv::StringRecord;

use super::columns::meaning;
use super::quotes::check_quotes;
use super::sheet::WorkbookSheet;
use super::{MAX_COLUMNS, MAX_ROWS, Roster, RosterMapping, RosterRow, Unreadable, entry, repeats, sheet, text};
use crate::single_line_text::tidy;

/// Maximum number of rows above the headings.
const MAX_ABOVE: usize = 20;
/// Marker lines that HIS writes above and below a list.
const MARKS: [&str; 2] = ["startHISsheet", "endHISsheet"];

/// A table whose columns have no assigned meaning yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RosterTable {
    /// Headings of the columns.
    pub headings: Vec<String>,
    /// Line numbers in the file, from 1, and fields.
    pub(super) rows: Vec<(u64, StringRecord)>,
    /// Lines and columns of formulas without a stored result.
    unsolved: BTreeSet<(u64, usize)>,
}

impl RosterTable {
    /// Parses CSV in any common encoding, or the first visible sheet of an Excel workbook.
    ///
    /// # Errors
    /// If the whole file is refused, with the reason.
    pub fn read(bytes: &[u8]) -> Result<Self, Unreadable> {
        if sheet::is_sealed_workbook(bytes) {
            return Err(Unreadable::Sealed);
        }
        if sheet::is_old_workbook(bytes) {
            return Err(Unreadable::OldExcel);
        }
        if sheet::is_workbook(bytes) {
            Self::of_sheet(WorkbookSheet::read(bytes)?)
        } else {
            Self::of_rows(read_csv(bytes)?)
        }
    }

    /// Makes the table of a workbook's first visible sheet.
    ///
    /// # Errors
    /// If the whole file is refused, with the reason.
    pub fn of_sheet(WorkbookSheet { rows, unsolved }: WorkbookSheet) -> Result<Self, Unreadable> {
        let table = Self::of_rows(rows.into_iter().map(|(line, cells)| (line, StringRecord::from(cells))).collect())?;
        Ok(Self { unsolved, ..table })
    }

    /// Finds the headings and removes marker lines.
    fn of_rows(rows: Vec<(u64, StringRecord)>) -> Result<Self, Unreadable> {
        let known = |row: &StringRecord| {
            let columns: BTreeSet<_> = row.iter().filter_map(meaning).map(|(column, _)| column).collect();
            columns.len() >= 2
        };
        let at = rows.iter().take(MAX_ABOVE).position(|(_, row)| known(row)).unwrap_or(0);
        let mut rows = rows.into_iter().skip(at);
        let (_, headings) = rows.next().ok_or(Unreadable::Empty)?;
        if headings.len() > MAX_COLUMNS {
            return Err(Unreadable::TooWide);
        }
        let rows: Vec<_> = rows.filter(|(_, row)| !row.get(0).is_some_and(|text| MARKS.contains(&text))).collect();
        if rows.len() > MAX_ROWS {
            return Err(Unreadable::TooLong);
        }
        if rows.is_empty() {
            return Err(Unreadable::Empty);
        }
        Ok(Self { headings: headings.iter().map(str::to_owned).collect(), rows, unsolved: BTreeSet::new() })
    }

    /// Returns the fields of a column that are not empty.
    pub(super) fn column(&self, index: usize) -> impl Iterator<Item = &str> {
        self.rows.iter().filter_map(move |(_, row)| row.get(index)).filter(|text| !text.is_empty())
    }

    /// Returns the first field of a column that is not empty.
    #[must_use]
    pub fn sample_of(&self, index: usize) -> Option<&str> {
        self.column(index).next()
    }

    /// Returns the first rows of the table, for a preview.
    #[must_use]
    pub fn head(&self, rows: usize) -> Self {
        Self {
            headings: self.headings.clone(),
            rows: self.rows.iter().take(rows).cloned().collect(),
            unsolved: self.unsolved.clone(),
        }
    }

    /// Parses the lines of the table with the given meanings of its columns.
    #[must_use]
    pub fn people(&self, mapping: &RosterMapping) -> Roster {
        let read = |(line, row): &(u64, StringRecord)| RosterRow {
            line: *line,
            entry: entry(row, mapping, self.unsolved_heading(*line, mapping)),
        };
        let mut rows: Vec<RosterRow> = self.rows.iter().map(read).collect();
        repeats::join_or_refuse(&mut rows);
        let ignored = self.headings.iter().enumerate().filter(|(index, _)| !mapping.reads(*index));
        Roster { rows, ignored: ignored.map(|(_, heading)| heading.clone()).filter(|h| !h.is_empty()).collect() }
    }

    /// Returns the heading of the first column to be read whose formula in this line has no stored
    /// result.
    fn unsolved_heading(&self, line: u64, mapping: &RosterMapping) -> Option<String> {
        let column = mapping.columns.values().find(|column| self.unsolved.contains(&(line, **column)))?;
        self.headings.get(*column).cloned()
    }
}

/// Parses CSV in any common encoding: line numbers in the file, and fields.
///
/// # Errors
/// If a quoted field is not closed, or there are too many lines.
pub(crate) fn read_csv(bytes: &[u8]) -> Result<Vec<(u64, StringRecord)>, Unreadable> {
    let text = text::read(bytes);
    check_quotes(&text.body, text.separator, text.skipped)?;
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(text.separator)
        .flexible(true)
        .has_headers(false)
        .trim(csv::Trim::All)
        .from_reader(text.body.as_bytes());
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| not_csv(&error, text.skipped))?;
        let position = record.position().cloned();
        let record: StringRecord = record.iter().map(tidy).collect();
        if record.iter().all(str::is_empty) {
            continue;
        }
        if rows.len() > MAX_ROWS + MAX_ABOVE {
            return Err(Unreadable::TooLong);
        }
        let line = position.map_or(0, |at| line_of(&at, &text.body)) + text.skipped;
        rows.push((line, record));
    }
    Ok(rows)
}

/// Returns the line number of a record, from 1. The position reported by the csv crate may precede
/// the end of the previous line and empty lines.
fn line_of(at: &csv::Position, body: &str) -> u64 {
    let rest = usize::try_from(at.byte()).ok().and_then(|byte| body.as_bytes().get(byte..)).unwrap_or_default();
    let before = rest.iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
    at.line() + before.map(|byte| u64::from(*byte == b'\n')).sum::<u64>()
}

fn not_csv(error: &csv::Error, skipped: u64) -> Unreadable {
    let line = error.position().map_or(1, csv::Position::line) + skipped;
    Unreadable::NotCsv { line, why: "this is not a line of CSV".to_owned() }
}
