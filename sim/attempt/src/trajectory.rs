//! Trajectories: CSV with a header that names the columns and one row per sample, or columns of
//! numbers in memory. Both are checked alike.

use std::fmt::{self, Display};
use std::path::Path;
use std::{fs, io};

use csv::{ReaderBuilder, StringRecord, Trim};

/// Maximum distance of a position from the skin, in m; a larger one most likely comes from a column
/// in millimetres.
const FARTHEST_M: f64 = 10.0;

/// Why a trajectory cannot be used.
#[derive(Debug)]
pub enum TrajectoryError {
    /// The file cannot be read.
    Unreadable {
        /// The file.
        file: String,
        /// Error of the operating system.
        error: io::Error,
    },
    /// The content is rejected.
    Refused {
        /// File and line, or column and row.
        place: String,
        /// The value found, and the values allowed.
        why: String,
    },
}

impl Display for TrajectoryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable { file, error } => write!(f, "{file}: {error}"),
            Self::Refused { place, why } => write!(f, "{place}: {why}"),
        }
    }
}

impl std::error::Error for TrajectoryError {}

fn refused(place: impl Display, why: impl Display) -> TrajectoryError {
    TrajectoryError::Refused { place: place.to_string(), why: why.to_string() }
}

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
    /// If it cannot be read or is no table.
    pub fn read(path: &Path) -> Result<Self, TrajectoryError> {
        let file = path.display().to_string();
        let bytes = fs::read(path).map_err(|error| TrajectoryError::Unreadable { file: file.clone(), error })?;
        let refuse = |error: csv::Error| refuse_table(&file, &bytes, &error);
        let mut reader = ReaderBuilder::new().trim(Trim::All).comment(Some(b'#')).from_reader(&bytes[..]);
        let header = placed(&bytes, reader.headers().map_err(refuse)?.clone());
        if let Some(name) = other_separator(&header) {
            let why = format!(
                "{name} between columns; allowed: commas between columns, and points in numbers (0.5, not 0,5)"
            );
            return Err(refused(format_args!("{file}:{}", line_of(&header)), why));
        }
        let rows = reader.records().map(|row| row.map(|row| placed(&bytes, row)).map_err(refuse));
        let rows: Vec<_> = rows.collect::<Result<_, _>>()?;
        if rows.is_empty() {
            return Err(refused(file, "no rows; a header and at least one row are needed"));
        }
        Ok(Self { file, header, rows })
    }

    /// Returns the index of a column, if the header has it.
    ///
    /// # Errors
    /// If the header has it twice.
    pub fn column(&self, name: &str) -> Result<Option<usize>, TrajectoryError> {
        let mut found = self.header.iter().enumerate().filter(|(_, title)| *title == name);
        let first = found.next().map(|(index, _)| index);
        match found.next() {
            Some(_) => Err(self.wrong_header(format_args!("column {name} appears twice; allowed: once"))),
            None => Ok(first),
        }
    }

    /// Returns the indices of columns, all of which the header must have.
    ///
    /// # Errors
    /// Names the first that is missing.
    pub fn columns<const N: usize>(&self, names: [&str; N]) -> Result<[usize; N], TrajectoryError> {
        let mut columns = [0; N];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = self.column(name)?.ok_or_else(|| {
                let header = self.header.iter().collect::<Vec<_>>().join(",");
                self.wrong_header(format_args!("column {name} is missing; the header is '{header}'"))
            })?;
        }
        Ok(columns)
    }

    /// Returns the rows, each with its time, checked to increase, and the chosen columns as
    /// numbers.
    ///
    /// # Errors
    /// Names the line, value and unit of the first bad number, or the first time that does not
    /// increase.
    pub fn numbers<const N: usize>(&self, columns: [usize; N]) -> Result<Vec<(f64, [f64; N])>, TrajectoryError> {
        let [time] = self.columns(["t_s"])?;
        let mut previous = f64::NEG_INFINITY;
        self.rows
            .iter()
            .map(|row| {
                let t_s = self.number(row, time)?;
                if t_s <= previous {
                    return Err(self.wrong(line_of(row), late_time("t_s", t_s, previous)));
                }
                previous = t_s;
                Ok((t_s, self.values(row, columns)?))
            })
            .collect()
    }

    /// Returns the chosen columns as numbers, row by row.
    ///
    /// # Errors
    /// Names the line, value and unit of the first bad number.
    pub fn rows<const N: usize>(&self, columns: [usize; N]) -> Result<Vec<[f64; N]>, TrajectoryError> {
        self.rows.iter().map(|row| self.values(row, columns)).collect()
    }

    fn values<const N: usize>(&self, row: &StringRecord, columns: [usize; N]) -> Result<[f64; N], TrajectoryError> {
        let mut values = [0.0; N];
        for (value, &column) in values.iter_mut().zip(&columns) {
            *value = self.number(row, column)?;
        }
        Ok(values)
    }

    fn number(&self, row: &StringRecord, column: usize) -> Result<f64, TrajectoryError> {
        let (name, text) = (&self.header[column], &row[column]);
        let unit = match name.rsplit_once('_') {
            Some((_, "s")) => " s",
            Some((_, "m")) => " m",
            Some((_, "n")) => " N",
            _ => "",
        };
        let wrong = |allowed: &str| self.wrong(line_of(row), format_args!("{name} = {text}{unit}; {allowed}"));
        let value: f64 = text.parse().map_err(|_| {
            let is_comma = text.replace(',', ".").parse::<f64>().is_ok();
            wrong(if is_comma {
                "allowed: a number, with a decimal point instead of a comma"
            } else {
                "allowed: a number"
            })
        })?;
        match find_fault(value, unit) {
            Some(allowed) => Err(wrong(allowed)),
            None => Ok(value),
        }
    }

    /// Creates an error in a line of this file.
    pub fn wrong(&self, line: u64, why: impl Display) -> TrajectoryError {
        refused(format_args!("{}:{line}", self.file), why)
    }

    /// Creates an error in the header of this file.
    pub fn wrong_header(&self, why: impl Display) -> TrajectoryError {
        self.wrong(line_of(&self.header), why)
    }

    /// Returns the number of the line on which a row stands; `row` counts from 0.
    pub fn line(&self, row: usize) -> u64 {
        self.rows.get(row).map_or(1, line_of)
    }
}

/// Returns the allowed values if a number is not allowed. `unit` starts with a space.
fn find_fault(value: f64, unit: &str) -> Option<&'static str> {
    if !value.is_finite() {
        Some("allowed: a finite number")
    } else if unit == " m" && value.abs() > FARTHEST_M {
        Some("allowed: −10 m to 10 m (is the column in mm?)")
    } else {
        None
    }
}

fn late_time(name: &str, t_s: f64, previous_s: f64) -> String {
    format!("{name} = {t_s} s; times must increase, and the previous row has {previous_s} s")
}

/// A column of numbers in memory.
#[derive(Clone, Copy, Debug)]
pub struct NumberColumn<'a> {
    /// Its name, as given by the caller.
    pub name: &'a str,
    /// Its unit, with a space before it; empty for a number without one.
    pub unit: &'static str,
    /// A value for each row.
    pub values: &'a [f64],
}

/// Rejects columns that would be rejected in a file. The first holds the times.
///
/// # Errors
/// Names column, row, value and the allowed values.
pub fn check_columns(columns: &[NumberColumn<'_>]) -> Result<(), TrajectoryError> {
    let Some(times) = columns.first() else { return Ok(()) };
    let rows = times.values.len();
    if rows == 0 {
        return Err(refused(times.name, "no rows; at least one is needed"));
    }
    for column in columns {
        let length = column.values.len();
        if length != rows {
            let why = format!("{length} rows; allowed: {rows}, as many as {} has", times.name);
            return Err(refused(column.name, why));
        }
        for (row, &value) in column.values.iter().enumerate() {
            if let Some(allowed) = find_fault(value, column.unit) {
                let why = format!("{value}{}; {allowed}", column.unit);
                return Err(refused(format_args!("{}[{row}]", column.name), why));
            }
        }
    }
    let late = times.values.windows(2).position(|pair| pair[1] <= pair[0]);
    match late {
        Some(before) => {
            let why = late_time("t_s", times.values[before + 1], times.values[before]);
            Err(refused(format_args!("{}[{}]", times.name, before + 1), why))
        }
        None => Ok(()),
    }
}

/// Reads `t_s` and `x_m`; other columns are ignored.
///
/// # Errors
/// If the file is no such table; see [`TrajectoryTable::numbers`].
pub fn read_axial(path: &Path) -> Result<Vec<AxialSample>, TrajectoryError> {
    let table = TrajectoryTable::read(path)?;
    let columns = table.columns(["x_m"])?;
    Ok(table.numbers(columns)?.into_iter().map(|(t_s, [x_m])| AxialSample { t_s, x_m }).collect())
}

/// Returns the name of the separator of a header whose columns are not separated by commas.
fn other_separator(header: &StringRecord) -> Option<&'static str> {
    let whole = header.get(0).filter(|_| header.len() == 1)?;
    [(';', "semicolons"), ('\t', "tabs")]
        .into_iter()
        .find(|(separator, _)| whole.contains(*separator))
        .map(|(_, name)| name)
}

fn line_of(row: &StringRecord) -> u64 {
    row.position().map_or(1, csv::Position::line)
}

/// Sets a row's line to the one on which it stands in the file.
fn placed(bytes: &[u8], mut row: StringRecord) -> StringRecord {
    let position = row.position().cloned().map(|mut position| {
        position.set_line(line_at(bytes, &position));
        position
    });
    row.set_position(position);
    row
}

/// Returns the line of the data read from a position on: the csv crate counts comments and empty
/// lines as part of the row below them.
fn line_at(bytes: &[u8], position: &csv::Position) -> u64 {
    let from = usize::try_from(position.byte()).ok();
    let lines = from.and_then(|from| bytes.get(from..)).unwrap_or_default().split(|&byte| byte == b'\n');
    let is_passed_over = |line: &&[u8]| line.first() == Some(&b'#') || line.trim_ascii().is_empty();
    position.line() + lines.take_while(is_passed_over).count() as u64
}

fn refuse_table(file: &str, bytes: &[u8], error: &csv::Error) -> TrajectoryError {
    match error.position() {
        Some(position) => refused(format_args!("{file}:{}", line_at(bytes, position)), explain(error)),
        None => refused(file, explain(error)),
    }
}

/// Describes an error without the position that the csv crate includes.
fn explain(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Io(error) => error.to_string(),
        csv::ErrorKind::Utf8 { .. } => "the row is not UTF-8 text".to_owned(),
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            let hint = if len > expected_len { " (numbers are written with a point, not a comma)" } else { "" };
            format!("{len} fields; allowed: {expected_len}, as in the header{hint}")
        }
        _ => error.to_string(),
    }
}
