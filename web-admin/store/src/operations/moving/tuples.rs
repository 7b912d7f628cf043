//! Rows in the binary format of PostgreSQL's `COPY`. It is exact for all kinds and independent of
//! the engine, so that equal hashes prove equal tables.

use data_encoding::HEXLOWER;
use sha2::{Digest, Sha256};
use sqlx::Row;
use sqlx::sqlite::SqliteRow;

use super::CarriedTable;
use super::columns::{CarriedColumn, TablePlan, ValueKind};
use crate::{Error, Result};

/// Header of the format: signature, no flags, no extension.
pub(super) const HEADER: [u8; 19] = *b"PGCOPY\n\xff\r\n\0\0\0\0\0\0\0\0\0";
/// Trailer of the format.
pub(super) const TRAILER: [u8; 2] = (-1_i16).to_be_bytes();
/// Length of a NULL value.
const ABSENT: i32 = -1;

/// Number and hash of the rows copied so far.
pub(super) struct TableTally {
    name: String,
    rows: u64,
    hash: Sha256,
}

impl TableTally {
    pub fn new(table: &TablePlan) -> Self {
        Self { name: table.name.clone(), rows: 0, hash: Sha256::new() }
    }

    /// Adds a row in binary form.
    pub fn count(&mut self, row: &[u8]) {
        self.rows += 1;
        self.hash.update(row);
    }

    pub fn finish(self) -> CarriedTable {
        CarriedTable { name: self.name, rows: self.rows, sha256: HEXLOWER.encode(&self.hash.finalize()) }
    }
}

/// Appends a row from SQLite in binary form. If PostgreSQL cannot store a value, the error names
/// the column.
pub(super) fn append_row(row: &SqliteRow, table: &TablePlan, to: &mut Vec<u8>) -> Result<()> {
    let columns = i16::try_from(table.columns.len()).map_err(|error| Error::Encode(error.into()))?;
    to.extend(columns.to_be_bytes());
    for (place, column) in table.columns.iter().enumerate() {
        append_value(row, place, column, to)
            .map_err(|why| Error::Encode(format!("{}.{}: {why}", table.name, column.name).into()))?;
    }
    Ok(())
}

fn append_value(
    row: &SqliteRow,
    place: usize,
    column: &CarriedColumn,
    to: &mut Vec<u8>,
) -> std::result::Result<(), Box<dyn std::error::Error + Send + Sync>> {
    match column.kind {
        ValueKind::Id => match row.try_get_unchecked::<Option<&[u8]>, _>(place)? {
            Some(id) if id.len() != 16 => Err(format!("an id of {} bytes; allowed: 16", id.len()).into()),
            id => append_field(id, to),
        },
        ValueKind::Bytes => append_field(row.try_get_unchecked(place)?, to),
        ValueKind::Whole => {
            let value: Option<i64> = row.try_get_unchecked(place)?;
            append_field(value.map(i64::to_be_bytes).as_ref().map(|bytes| &bytes[..]), to)
        }
        ValueKind::Real => {
            let value: Option<f64> = row.try_get_unchecked(place)?;
            append_field(value.map(f64::to_be_bytes).as_ref().map(|bytes| &bytes[..]), to)
        }
        ValueKind::Truth => match row.try_get_unchecked::<Option<i64>, _>(place)? {
            None => append_field(None, to),
            Some(0) => append_field(Some(&[0]), to),
            Some(1) => append_field(Some(&[1]), to),
            Some(other) => Err(format!("{other} as a truth value; allowed: 0, 1").into()),
        },
        ValueKind::Text => match row.try_get_unchecked::<Option<&str>, _>(place)? {
            Some(text) if text.contains('\0') => Err("a text with U+0000, which PostgreSQL cannot store".into()),
            text => append_field(text.map(str::as_bytes), to),
        },
    }
}

fn append_field(
    value: Option<&[u8]>,
    to: &mut Vec<u8>,
) -> std::result::Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let length = value.map_or(Ok(ABSENT), |value| i32::try_from(value.len()))?;
    to.extend(length.to_be_bytes());
    to.extend(value.into_iter().flatten());
    Ok(())
}

/// Splits the output of `COPY` into rows, independently of the size of its chunks.
#[derive(Default)]
pub(super) struct RowReader {
    left: Vec<u8>,
    taken: usize,
    is_begun: bool,
}

impl RowReader {
    /// Adds a chunk.
    pub fn add(&mut self, piece: &[u8]) {
        self.left.drain(..self.taken);
        self.taken = 0;
        self.left.extend(piece);
    }

    /// Returns the next complete row in binary form, or `None` if more data is needed.
    pub fn next_row(&mut self) -> Option<&[u8]> {
        if !self.is_begun {
            self.left.get(..HEADER.len())?;
            self.taken += HEADER.len();
            self.is_begun = true;
        }
        let row = self.left.get(self.taken..)?;
        let mut fields = FieldReader::new(row)?;
        while fields.left > 0 {
            fields.next_field()?;
        }
        let length = row.len() - fields.rest.len();
        self.taken += length;
        self.left.get(self.taken - length..self.taken)
    }
}

/// Splits a row in binary form into values.
pub(super) struct FieldReader<'a> {
    rest: &'a [u8],
    left: u16,
}

impl<'a> FieldReader<'a> {
    /// Makes a reader. Returns `None` for an incomplete row or the trailer.
    pub fn new(row: &'a [u8]) -> Option<Self> {
        let (count, rest) = row.split_first_chunk()?;
        let left = u16::try_from(i16::from_be_bytes(*count)).ok()?;
        Some(Self { rest, left })
    }

    /// Returns the next value: `Some(None)` is NULL, `None` an incomplete value.
    pub fn next_field(&mut self) -> Option<Option<&'a [u8]>> {
        let (length, rest) = self.rest.split_first_chunk()?;
        let value = match usize::try_from(i32::from_be_bytes(*length)) {
            Err(_) => None,
            Ok(length) => Some(rest.get(..length)?),
        };
        self.rest = &rest[value.map_or(0, <[u8]>::len)..];
        self.left -= 1;
        Some(value)
    }
}
