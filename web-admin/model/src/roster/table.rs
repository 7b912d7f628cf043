//! A roster as a table: headings, and rows that say where they stand in the file.

use std::collections::BTreeSet;

use csv::StringRecord;

use super::columns::meaning;
use super::quotes::check_quotes;
use super::sheet::WorkbookSheet;
use super::{MAX_COLUMNS, MAX_ROWS, Roster, RosterMapping, RosterRow, Unreadable, entry, repeats, sheet, text};
use crate::line::tidy;

/// How many rows may stand above the headings.
const MAX_ABOVE: usize = 20;
/// What HIS writes above and below a list.
const MARKS: [&str; 2] = ["startHISsheet", "endHISsheet"];

/// A file whose columns may mean anything yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RosterTable {
    /// What stands above the columns.
    pub headings: Vec<String>,
    /// Lines of the file, from 1, and what stands in them.
    pub(super) rows: Vec<(u64, StringRecord)>,
    /// Lines and columns of formulas without a result.
    unsolved: BTreeSet<(u64, usize)>,
}

impl RosterTable {
    /// Reads CSV in any usual encoding, or the first visible sheet of an Excel workbook.
    ///
    /// # Errors
    /// When it is refused whole, saying why.
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

    /// The table of a workbook's first visible sheet.
    ///
    /// # Errors
    /// When it is refused whole, saying why.
    pub fn of_sheet(WorkbookSheet { rows, unsolved }: WorkbookSheet) -> Result<Self, Unreadable> {
        let table = Self::of_rows(rows.into_iter().map(|(line, cells)| (line, StringRecord::from(cells))).collect())?;
        Ok(Self { unsolved, ..table })
    }

    /// Finds the headings, and leaves out what is empty.
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

    /// What stands in a column, row by row.
    pub(super) fn column(&self, index: usize) -> impl Iterator<Item = &str> {
        self.rows.iter().filter_map(move |(_, row)| row.get(index)).filter(|text| !text.is_empty())
    }

    /// The first thing that stands in a column.
    #[must_use]
    pub fn sample_of(&self, index: usize) -> Option<&str> {
        self.column(index).next()
    }

    /// The table with no more than so many rows, to be looked at.
    #[must_use]
    pub fn head(&self, rows: usize) -> Self {
        Self {
            headings: self.headings.clone(),
            rows: self.rows.iter().take(rows).cloned().collect(),
            unsolved: self.unsolved.clone(),
        }
    }

    /// The people in it, by what its columns are said to mean.
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

    /// The heading of a column that is read, whose formula has no result in a line.
    fn unsolved_heading(&self, line: u64, mapping: &RosterMapping) -> Option<String> {
        let column = mapping.columns.values().find(|column| self.unsolved.contains(&(line, **column)))?;
        self.headings.get(*column).cloned()
    }
}

fn read_csv(bytes: &[u8]) -> Result<Vec<(u64, StringRecord)>, Unreadable> {
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

/// The line that a record stands in, from 1. The reader is still before what ends the last line, and before empty ones, when it tells
/// where the next record begins.
fn line_of(at: &csv::Position, body: &str) -> u64 {
    let rest = usize::try_from(at.byte()).ok().and_then(|byte| body.as_bytes().get(byte..)).unwrap_or_default();
    let before = rest.iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
    at.line() + before.map(|byte| u64::from(*byte == b'\n')).sum::<u64>()
}

fn not_csv(error: &csv::Error, skipped: u64) -> Unreadable {
    let line = error.position().map_or(1, csv::Position::line) + skipped;
    Unreadable::NotCsv { line, why: "this is not a line of CSV".to_owned() }
}
