//! Trajectories in CSV: a header naming the columns, then one row per sample.

use std::fs;
use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};

use crate::exit::Failure;

/// Positions farther than this from the skin are refused, in m: the likeliest cause is a column in millimetres.
const FARTHEST_M: f64 = 10.0;

/// A sample of axial motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxialSample {
    /// Time, in s.
    pub t_s: f64,
    /// Axial displacement, in m; negative above the skin.
    pub x_m: f64,
}

/// A CSV file in memory, with its columns by name.
pub struct TrajectoryTable {
    file: String,
    header: StringRecord,
    rows: Vec<StringRecord>,
}

impl TrajectoryTable {
    /// Reads a file with a header and at least one row; lines that start with # are comments.
    ///
    /// # Errors
    /// When it cannot be read or is no table.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let file = path.display().to_string();
        let bytes = fs::read(path).map_err(|error| Failure::refused(path, error))?;
        let refuse = |error: csv::Error| refuse(&file, &bytes, &error);
        let mut reader = ReaderBuilder::new().trim(Trim::All).comment(Some(b'#')).from_reader(&bytes[..]);
        let header = placed(&bytes, reader.headers().map_err(refuse)?.clone());
        let rows = reader.records().map(|row| row.map(|row| placed(&bytes, row)).map_err(refuse));
        let rows: Vec<_> = rows.collect::<Result<_, _>>()?;
        if rows.is_empty() {
            return Err(Failure::input(format_args!("{file}: no rows; a header and at least one row are needed")));
        }
        Ok(Self { file, header, rows })
    }

    /// The column of a name, if the header has it.
    ///
    /// # Errors
    /// When the header has it twice.
    pub fn column(&self, name: &str) -> Result<Option<usize>, Failure> {
        let mut found = self.header.iter().enumerate().filter(|(_, title)| *title == name);
        let first = found.next().map(|(index, _)| index);
        match found.next() {
            Some(_) => Err(self.wrong_header(format_args!("column {name} appears twice; once is allowed"))),
            None => Ok(first),
        }
    }

    /// The columns of several names, all of which the header must have.
    ///
    /// # Errors
    /// Naming the first that is missing.
    pub fn columns<const N: usize>(&self, names: [&str; N]) -> Result<[usize; N], Failure> {
        let mut columns = [0; N];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = self.column(name)?.ok_or_else(|| {
                let header = self.header.iter().collect::<Vec<_>>().join(",");
                self.wrong_header(format_args!("column {name} is missing; the header is '{header}'"))
            })?;
        }
        Ok(columns)
    }

    /// The rows, each with its times checked to increase and the chosen columns as numbers.
    ///
    /// # Errors
    /// Naming the line, value and unit of the first bad number, or the first time that does not increase.
    pub fn numbers<const N: usize>(&self, columns: [usize; N]) -> Result<Vec<(f64, [f64; N])>, Failure> {
        let [time] = self.columns(["t_s"])?;
        let mut previous = f64::NEG_INFINITY;
        self.rows
            .iter()
            .map(|row| {
                let t_s = self.number(row, time)?;
                if t_s <= previous {
                    let why = format_args!("t_s = {t_s} s; times must increase, and the row before has {previous} s");
                    return Err(self.wrong(line_of(row), why));
                }
                previous = t_s;
                Ok((t_s, self.values(row, columns)?))
            })
            .collect()
    }

    /// The chosen columns as numbers, row by row.
    ///
    /// # Errors
    /// Naming the line, value and unit of the first bad number.
    pub fn rows<const N: usize>(&self, columns: [usize; N]) -> Result<Vec<[f64; N]>, Failure> {
        self.rows.iter().map(|row| self.values(row, columns)).collect()
    }

    fn values<const N: usize>(&self, row: &StringRecord, columns: [usize; N]) -> Result<[f64; N], Failure> {
        let mut values = [0.0; N];
        for (value, &column) in values.iter_mut().zip(&columns) {
            *value = self.number(row, column)?;
        }
        Ok(values)
    }

    fn number(&self, row: &StringRecord, column: usize) -> Result<f64, Failure> {
        let (name, text) = (&self.header[column], &row[column]);
        let unit = match name.rsplit_once('_') {
            Some((_, "s")) => " s",
            Some((_, "m")) => " m",
            Some((_, "n")) => " N",
            _ => "",
        };
        let wrong = |allowed: &str| self.wrong(line_of(row), format_args!("{name} = {text}{unit}; {allowed}"));
        let value: f64 = text.parse().map_err(|_| wrong("a number is allowed"))?;
        if !value.is_finite() {
            return Err(wrong("a finite number is allowed"));
        }
        if unit == " m" && value.abs() > FARTHEST_M {
            return Err(wrong("−10 m to 10 m is allowed (is the column in mm?)"));
        }
        Ok(value)
    }

    /// An error in a line of this file.
    pub fn wrong(&self, line: u64, why: impl std::fmt::Display) -> Failure {
        Failure::input(format_args!("{}:{line}: {why}", self.file))
    }

    /// An error in the header of this file.
    pub fn wrong_header(&self, why: impl std::fmt::Display) -> Failure {
        self.wrong(line_of(&self.header), why)
    }

    /// The line in the file of a row, counted from 0.
    pub fn line(&self, row: usize) -> u64 {
        self.rows.get(row).map_or(1, line_of)
    }
}

/// Reads `t_s` and `x_m`; other columns are ignored.
///
/// # Errors
/// When the file is no such table; see [`TrajectoryTable::numbers`].
pub fn read_axial(path: &Path) -> Result<Vec<AxialSample>, Failure> {
    let table = TrajectoryTable::read(path)?;
    let columns = table.columns(["x_m"])?;
    Ok(table.numbers(columns)?.into_iter().map(|(t_s, [x_m])| AxialSample { t_s, x_m }).collect())
}

fn line_of(row: &StringRecord) -> u64 {
    row.position().map_or(1, csv::Position::line)
}

/// A row that knows the line it stands on.
fn placed(bytes: &[u8], mut row: StringRecord) -> StringRecord {
    let position = row.position().cloned().map(|mut position| {
        position.set_line(line_at(bytes, &position));
        position
    });
    row.set_position(position);
    row
}

/// The line of what was read from a position on: to the csv crate, comments and empty lines are a part of the row below them.
fn line_at(bytes: &[u8], position: &csv::Position) -> u64 {
    let from = usize::try_from(position.byte()).ok();
    let lines = from.and_then(|from| bytes.get(from..)).unwrap_or_default().split(|&byte| byte == b'\n');
    let is_passed_over = |line: &&[u8]| line.first() == Some(&b'#') || line.trim_ascii().is_empty();
    position.line() + lines.take_while(is_passed_over).count() as u64
}

fn refuse(file: &str, bytes: &[u8], error: &csv::Error) -> Failure {
    match error.position() {
        Some(position) => Failure::input(format_args!("{file}:{}: {}", line_at(bytes, position), explain(error))),
        None => Failure::input(format_args!("{file}: {}", explain(error))),
    }
}

/// What is wrong, in words without the csv crate's own account of the place.
fn explain(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Io(error) => error.to_string(),
        csv::ErrorKind::Utf8 { .. } => "the row is not UTF-8 text".to_owned(),
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("{len} fields; {expected_len} are allowed, as in the header")
        }
        _ => error.to_string(),
    }
}
