//! The first visible sheet of an Excel workbook, with each cell as a spreadsheet shows it. The
//! unpacked size is checked before anything is parsed: a small file may unpack to more than the
//! available memory, or declare more strings than it contains.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Cursor, Read};
use std::panic;

use calamine::{DataRef, Dimensions, Reader, SheetType, SheetVisible, Xlsx};
use serde::{Deserialize, Serialize};
use zip::ZipArchive;

use super::cell_format::{code_of, show_number, show_time};
use super::{MAX_COLUMNS, MAX_ROWS, Unreadable};
use crate::single_line_text::tidy;

/// Maximum size of an unpacked workbook, in bytes.
const MAX_UNPACKED: usize = 64_000_000;
/// Maximum number of cells.
const MAX_CELLS: usize = 1_000_000;
/// Maximum number of parts in a workbook.
const MAX_PARTS: usize = 1000;
/// Maximum number of digits of a workbook's declared string count, for which the parser reserves
/// memory.
const MAX_DIGITS: usize = 6;

/// The first visible sheet of a workbook.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkbookSheet {
    /// Rows that are not empty, with their number from 1.
    pub(super) rows: Vec<(u64, Vec<String>)>,
    /// Cells with formulas whose result is not stored: row, from 1, and column, from 0.
    pub(super) unsolved: BTreeSet<(u64, usize)>,
}

impl WorkbookSheet {
    /// Parses a workbook. The library's memory use is not bounded by the size of the file, so that
    /// untrusted files are parsed in a process with a memory limit.
    ///
    /// # Errors
    /// If the file is not a workbook, or is too large.
    pub fn read(bytes: &[u8]) -> Result<Self, Unreadable> {
        measure(bytes)?;
        // A panic of the library on a corrupt workbook is turned into an error.
        panic::catch_unwind(|| read_sheet(bytes)).unwrap_or(Err(Unreadable::NotSheet))
    }
}

/// Returns whether a file is a zip archive, like workbooks since 2007.
#[must_use]
pub fn is_workbook(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04")
}

/// Returns whether a file is a workbook from before 2007.
pub(super) fn is_old_workbook(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xD0, 0xCF, 0x11, 0xE0])
}

/// Returns whether a file is an encrypted workbook: Excel stores the encrypted package in the older
/// container format, whose directory is in UTF-16.
pub(super) fn is_sealed_workbook(bytes: &[u8]) -> bool {
    let name: Vec<u8> = "EncryptedPackage".encode_utf16().flat_map(u16::to_le_bytes).collect();
    is_old_workbook(bytes) && bytes.windows(name.len()).any(|window| window == name)
}

/// Refuses an archive that is not a workbook, with an error that names its kind.
fn check_kind(archive: &ZipArchive<Cursor<&[u8]>>) -> Result<(), Unreadable> {
    let names: Vec<String> = archive.file_names().filter_map(|name| Some(name.ok()?.into_owned())).collect();
    let has = |wanted: &str| names.iter().any(|name| name.eq_ignore_ascii_case(wanted));
    if has("xl/workbook.bin") {
        return Err(Unreadable::BinaryExcel);
    }
    if has("[Content_Types].xml") {
        return Ok(());
    }
    if has("content.xml") && has("mimetype") {
        return Err(Unreadable::OpenDocument);
    }
    let table = |name: &&String| {
        let lower = name.to_lowercase();
        lower.ends_with("users.csv") || lower.ends_with("students.csv")
    };
    let people = names.iter().find(table).or_else(|| names.iter().find(|name| name.to_lowercase().ends_with(".csv")));
    Err(Unreadable::Archive(people.map(|name| name.chars().take(80).collect())))
}

/// Unpacks all parts without keeping them, and refuses a workbook that is too large.
fn measure(bytes: &[u8]) -> Result<(), Unreadable> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|_| Unreadable::NotSheet)?;
    check_kind(&archive)?;
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

/// Returns whether a part declares more strings than any roster has.
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

type Book<'a> = Xlsx<Cursor<&'a [u8]>>;

fn read_sheet(bytes: &[u8]) -> Result<WorkbookSheet, Unreadable> {
    let mut book: Book<'_> = Xlsx::new(Cursor::new(bytes)).map_err(|_| Unreadable::NotSheet)?;
    let shown = |sheet: &&calamine::Sheet| sheet.visible == SheetVisible::Visible && sheet.typ == SheetType::WorkSheet;
    let name = book.sheets_metadata().iter().find(shown).ok_or(Unreadable::NoVisibleSheet)?.name.clone();
    let merged = book.merge_cells_by_sheet_name(&name).map_err(|_| Unreadable::NotSheet)?;
    let unsolved = find_unsolved(&mut book, &name)?;
    let mut rows = read_cells(&mut book, &name)?;
    // A row that contains only formulas without a result also counts as a row.
    for (line, column) in &unsolved {
        cell_mut(rows.entry(*line).or_default(), *column);
    }
    let mut touched = 0;
    for range in &merged {
        touched += spread_down(range, &mut rows);
        if touched > MAX_CELLS {
            return Err(Unreadable::TooMuch);
        }
    }
    if rows.len() > MAX_ROWS + 100 {
        return Err(Unreadable::TooLong);
    }
    Ok(WorkbookSheet { rows: rows.into_iter().collect(), unsolved })
}

/// Returns the formulas without a stored result: they were written by a program and have not been
/// computed by a spreadsheet yet.
fn find_unsolved(book: &mut Book<'_>, name: &str) -> Result<BTreeSet<(u64, usize)>, Unreadable> {
    let mut cells = book.worksheet_cells_reader(name).map_err(|_| Unreadable::NotSheet)?;
    let (mut unsolved, mut count) = (BTreeSet::new(), 0);
    while let Some(cell) = cells.next_cell_with_formula_metadata().map_err(|_| Unreadable::NotSheet)? {
        count += 1;
        if count > MAX_CELLS {
            return Err(Unreadable::TooMuch);
        }
        let column = cell.pos.1 as usize;
        if cell.formula.is_some() && cell.value == DataRef::Empty && column < MAX_COLUMNS {
            unsolved.insert((u64::from(cell.pos.0) + 1, column));
        }
    }
    Ok(unsolved)
}

fn read_cells(book: &mut Book<'_>, name: &str) -> Result<BTreeMap<u64, Vec<String>>, Unreadable> {
    let mut cells = book.worksheet_cells_reader(name).map_err(|_| Unreadable::NotSheet)?;
    let codes: Vec<Option<String>> =
        cells.styles().iter().map(|style| style.number_format.as_ref().and_then(code_of)).collect();
    let (mut rows, mut count) = (BTreeMap::new(), 0);
    while let Some((cell, style)) = cells.next_cell_with_style_id().map_err(|_| Unreadable::NotSheet)? {
        count += 1;
        if count > MAX_CELLS {
            return Err(Unreadable::TooMuch);
        }
        let (line, column) = cell.get_position();
        let text = show_value(cell.get_value(), codes.get(style).and_then(Option::as_deref));
        if text.is_empty() {
            continue;
        }
        let column = column as usize;
        if column >= MAX_COLUMNS {
            return Err(Unreadable::TooWide);
        }
        *cell_mut(rows.entry(u64::from(line) + 1).or_default(), column) = text;
        if rows.len() > MAX_ROWS + 100 {
            return Err(Unreadable::TooLong);
        }
    }
    Ok(rows)
}

fn cell_mut(row: &mut Vec<String>, column: usize) -> &mut String {
    if row.len() <= column {
        row.resize(column + 1, String::new());
    }
    &mut row[column]
}

/// Copies the text of a merged range's first cell to all its rows, because a reader sees it next to
/// all of them. The other columns of the range are cleared. Returns the number of rows plus 1, as a
/// measure of the work.
fn spread_down(range: &Dimensions, rows: &mut BTreeMap<u64, Vec<String>>) -> usize {
    let (first, last) = (u64::from(range.start.0) + 1, u64::from(range.end.0) + 1);
    let (left, right) = (range.start.1 as usize, range.end.1 as usize);
    if first > last || left > right || left >= MAX_COLUMNS {
        return 1;
    }
    let mut touched = 1;
    let shown = rows.get(&first).and_then(|row| row.get(left)).cloned().unwrap_or_default();
    for (_, row) in rows.range_mut(first..=last) {
        touched += 1;
        *cell_mut(row, left) = shown.clone();
        for hidden in row.iter_mut().take(right.saturating_add(1)).skip(left + 1) {
            hidden.clear();
        }
    }
    touched
}

/// Returns the text that a spreadsheet shows in a cell, on one line.
fn show_value(value: &DataRef<'_>, code: Option<&str>) -> String {
    let number = |number: f64| code.and_then(|code| show_number(number, code));
    match value {
        DataRef::String(text) | DataRef::DurationIso(text) => one_line(text),
        DataRef::SharedString(text) => one_line(text),
        DataRef::DateTimeIso(text) => text.trim().trim_end_matches("T00:00:00").to_owned(),
        DataRef::Int(whole) => number(*whole as f64).unwrap_or_else(|| whole.to_string()),
        DataRef::Float(float) => number(*float).unwrap_or_else(|| float.to_string()),
        DataRef::Bool(is) => is.to_string(),
        DataRef::DateTime(time) => show_time(time, code),
        DataRef::Error(_) | DataRef::Empty => String::new(),
    }
}

/// Joins the lines of a cell, which Alt+Enter separates.
fn one_line(text: &str) -> String {
    tidy(&text.replace("_x000D_", " ").replace(['\r', '\n'], " "))
}
