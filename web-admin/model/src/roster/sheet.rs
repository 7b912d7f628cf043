//! The first sheet of an Excel workbook, cell by cell. What it unpacks to is measured before anything reads it: a small file may
//! unpack to more than there is memory, or announce more strings than there are.

use std::io::{Cursor, Read};
use std::panic;

use calamine::{DataRef, Reader, Xlsx};
use serde::{Deserialize, Serialize};
use zip::ZipArchive;

use super::{MAX_COLUMNS, MAX_ROWS, Unreadable};

/// Most bytes that a workbook may unpack to.
const MAX_UNPACKED: usize = 64_000_000;
/// Most cells that are read.
const MAX_CELLS: usize = 1_000_000;
/// Most parts of a workbook.
const MAX_PARTS: usize = 1000;
/// Most digits of the number of strings that a workbook announces: room is made for so many.
const MAX_DIGITS: usize = 6;

/// The first sheet of a workbook: its rows that are not empty, each with its number from 1.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkbookSheet(pub(super) Vec<(u64, Vec<String>)>);

impl WorkbookSheet {
    /// Reads a workbook. What the library allocates is not bounded by the size of the file, so untrusted files are read in a process
    /// with a limit of memory.
    ///
    /// # Errors
    /// When the file is no workbook or is too large.
    pub fn read(bytes: &[u8]) -> Result<Self, Unreadable> {
        measure(bytes)?;
        // A panic of the library on a broken workbook is a refusal.
        panic::catch_unwind(|| read_cells(bytes)).unwrap_or(Err(Unreadable::NotSheet)).map(Self)
    }
}

/// Whether a file is an archive, as workbooks are since 2007.
#[must_use]
pub fn is_workbook(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04")
}

/// Whether a file is a workbook of before 2007.
pub(super) fn is_old_workbook(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xD0, 0xCF, 0x11, 0xE0])
}

/// Unpacks every part, keeps none, and refuses what is too large.
fn measure(bytes: &[u8]) -> Result<(), Unreadable> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|_| Unreadable::NotSheet)?;
    if archive.len() > MAX_PARTS {
        return Err(Unreadable::TooMuch);
    }
    let mut left = MAX_UNPACKED;
    for index in 0..archive.len() {
        let part = archive.by_index(index).map_err(|_| Unreadable::NotSheet)?;
        let mut unpacked = Vec::new();
        part.take(left as u64 + 1).read_to_end(&mut unpacked).map_err(|_| Unreadable::NotSheet)?;
        left = left.checked_sub(unpacked.len()).ok_or(Unreadable::TooMuch)?;
        if announces_too_many(&unpacked) {
            return Err(Unreadable::TooMuch);
        }
    }
    Ok(())
}

/// Whether a part says that it has more strings than any roster.
fn announces_too_many(part: &[u8]) -> bool {
    // In UTF-16 every other byte is zero.
    let text: Vec<u8> = part.iter().copied().filter(|byte| *byte != 0).collect();
    let word = b"uniqueCount";
    let mut places = (0..text.len()).filter(|at| text[*at..].starts_with(word));
    places.any(|at| {
        let rest = text[at + word.len()..].iter().skip_while(|byte| !byte.is_ascii_digit());
        rest.take_while(|byte| byte.is_ascii_digit()).count() > MAX_DIGITS
    })
}

fn read_cells(bytes: &[u8]) -> Result<Vec<(u64, Vec<String>)>, Unreadable> {
    let mut book: Xlsx<_> = Xlsx::new(Cursor::new(bytes)).map_err(|_| Unreadable::NotSheet)?;
    let name = book.sheet_names().first().cloned().ok_or(Unreadable::NotSheet)?;
    let mut cells = book.worksheet_cells_reader(&name).map_err(|_| Unreadable::NotSheet)?;
    let (mut rows, mut row, mut count) = (Vec::new(), SheetRow::default(), 0);
    while let Some(cell) = cells.next_cell().map_err(|_| Unreadable::NotSheet)? {
        count += 1;
        if count > MAX_CELLS {
            return Err(Unreadable::TooMuch);
        }
        let (line, column) = cell.get_position();
        let text = say_value(cell.get_value());
        if text.is_empty() {
            continue;
        }
        let column = column as usize;
        if column >= MAX_COLUMNS {
            return Err(Unreadable::TooWide);
        }
        let line = u64::from(line) + 1;
        if line != row.line {
            std::mem::replace(&mut row, SheetRow { line, fields: Vec::new() }).finish(&mut rows)?;
        }
        if row.fields.len() <= column {
            row.fields.resize(column + 1, String::new());
        }
        row.fields[column] = text;
    }
    row.finish(&mut rows)?;
    Ok(rows)
}

/// A row under way.
#[derive(Default)]
struct SheetRow {
    line: u64,
    fields: Vec<String>,
}

impl SheetRow {
    fn finish(self, rows: &mut Vec<(u64, Vec<String>)>) -> Result<(), Unreadable> {
        if rows.len() > MAX_ROWS + 100 {
            return Err(Unreadable::TooLong);
        }
        if !self.fields.is_empty() {
            rows.push((self.line, self.fields));
        }
        Ok(())
    }
}

/// What stands in a cell, as Excel shows it without a format: a number that is whole has no decimals.
fn say_value(value: &DataRef<'_>) -> String {
    match value {
        DataRef::String(text) | DataRef::DateTimeIso(text) | DataRef::DurationIso(text) => text.trim().to_owned(),
        DataRef::SharedString(text) => text.trim().to_owned(),
        DataRef::Int(number) => number.to_string(),
        DataRef::Float(number) => number.to_string(),
        DataRef::Bool(is) => is.to_string(),
        DataRef::DateTime(time) => time.as_f64().to_string(),
        DataRef::Error(_) | DataRef::Empty => String::new(),
    }
}
