//! The topics of a recording as flat tables: a row for each message, a column for each number, with
//! the unit as suffix of the column's name.
//!
//! Columns are derived from `proto/stylet.proto`, so that no field can be forgotten: `position_m`
//! gives `position_x_m`, `axial_n` gives `axial_max_n`, the third boundary of `tent_m` gives
//! `tent_2_m`.

use std::io::{self, BufReader, Read};

use mcap::records::{Record, op};
use prost_reflect::{DescriptorPool, DynamicMessage, FieldDescriptor, MessageDescriptor, ReflectMessage, Value};

use crate::error::ReadError;
use crate::frames::{ChunkReader, RecordFrame, parse_record, walk_records};
use crate::read::{Channels, check_profile};
use crate::topics::Topic;
use crate::wire::DESCRIPTORS;

/// Maximum number of columns of a table. A scene has a few layers; a damaged message may claim
/// millions.
pub const MOST_COLUMNS: usize = 1_000;

/// Suffixes of field names with their units. The longest matching suffix wins.
pub const UNITS: &[(&str, &str)] =
    &[("_m_per_s", "m/s"), ("_us", "µs"), ("_s", "s"), ("_m", "m"), ("_n", "N"), ("_j", "J")];

/// A table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Table {
    /// `/needle/sample`.
    Samples,
    /// `/needle/summary`.
    Summary,
    /// `/needle/energy`.
    Energy,
    /// `/events`.
    Events,
    /// `/tissue/tent`.
    Tents,
}

impl Table {
    /// Every table.
    pub const ALL: [Self; 5] = [Self::Samples, Self::Summary, Self::Energy, Self::Events, Self::Tents];

    /// Returns the name, for a file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Samples => "samples",
            Self::Summary => "summary",
            Self::Energy => "energy",
            Self::Events => "events",
            Self::Tents => "tents",
        }
    }

    fn topic(self) -> Topic {
        match self {
            Self::Samples => Topic::Sample,
            Self::Summary => Topic::Summary,
            Self::Energy => Topic::Energy,
            Self::Events => Topic::Events,
            Self::Tents => Topic::Tent,
        }
    }
}

/// Type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// Double precision: inputs of the simulation.
    Double,
    /// Single precision: results of the simulation.
    Float,
    /// Counts, indices and bits.
    Whole,
    /// Text.
    Text,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name with its unit, for example `position_x_m`.
    pub name: String,
    /// Type of the values.
    pub kind: ColumnKind,
    /// Whether rows may leave it empty.
    pub optional: bool,
}

/// A value of a row.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A value of type [`ColumnKind::Double`].
    Double(f64),
    /// A value of type [`ColumnKind::Float`].
    Float(f32),
    /// A value of type [`ColumnKind::Whole`].
    Whole(i64),
    /// A value of type [`ColumnKind::Text`].
    Text(String),
    /// No value, for example the boundary of an event that is not a rupture.
    Empty,
}

/// Receives tables while they are read.
pub trait TableSink {
    /// Begins a table. Called once for each table, before its rows.
    ///
    /// # Errors
    /// If the table cannot be written.
    fn begin(&mut self, table: Table, columns: &[Column]) -> io::Result<()>;

    /// Adds the next row of a table, in order of time: a cell for each column.
    ///
    /// # Errors
    /// If the row cannot be written.
    fn row(&mut self, table: Table, cells: &[Cell]) -> io::Result<()>;
}

/// Reads the tables of a recording in one pass and bounded memory. Returns `false` if the recording
/// is truncated.
///
/// Tables whose columns depend on the scene (energy, tents) begin with their first row; the others
/// always exist.
///
/// # Errors
/// If the input is not a recording or damaged, or if the sink fails ([`ReadError::Io`]).
pub fn read_tables(source: impl Read, sink: &mut impl TableSink) -> Result<bool, ReadError> {
    let mut reader = TableReader::new(sink)?;
    let mut chunks = ChunkReader::new();
    let complete = walk_records(BufReader::new(source), |frame| match frame.opcode {
        op::CHUNK => chunks.walk(&frame, |inner| reader.take(&inner)),
        _ => reader.take(&frame),
    })?;
    reader.begin_the_rest()?;
    Ok(complete)
}

struct TableReader<'a, S> {
    sink: &'a mut S,
    channels: Channels,
    messages: Vec<(Table, MessageDescriptor)>,
    /// Number of columns of each table that has begun, by its index in [`Table::ALL`].
    begun: [Option<usize>; Table::ALL.len()],
}

impl<'a, S: TableSink> TableReader<'a, S> {
    fn new(sink: &'a mut S) -> Result<Self, ReadError> {
        let unknown = |why: &str| ReadError::missing("the schema of our messages", why);
        let pool = DescriptorPool::decode(DESCRIPTORS).map_err(|error| unknown(&error.to_string()))?;
        let message = |table: Table| pool.get_message_by_name(table.topic().message_name()).map(|found| (table, found));
        let messages: Vec<_> = Table::ALL.into_iter().filter_map(message).collect();
        Ok(Self { sink, channels: Channels::default(), messages, begun: [None; Table::ALL.len()] })
    }

    fn take(&mut self, frame: &RecordFrame<'_>) -> Result<(), ReadError> {
        if frame.opcode == op::ATTACHMENT {
            return Ok(());
        }
        match parse_record(frame.opcode, frame.data).map_err(|error| frame.damaged(error))? {
            Record::Header(header) => check_profile(&header.profile),
            Record::Schema { header, .. } => {
                self.channels.declare_schema(header);
                Ok(())
            }
            Record::Channel(channel) => self.channels.declare(&channel),
            Record::Message { header, data } => {
                let topic = self.channels.topic(header.channel_id).map_err(|why| frame.damaged(why))?;
                let message = self.messages.iter().find(|(table, _)| Some(table.topic()) == topic).cloned();
                message.map_or(Ok(()), |(table, kind)| {
                    let message = DynamicMessage::decode(kind, &*data).map_err(|error| frame.damaged(error))?;
                    self.add(table, &message, frame)
                })
            }
            _ => Ok(()),
        }
    }

    fn add(&mut self, table: Table, message: &DynamicMessage, frame: &RecordFrame<'_>) -> Result<(), ReadError> {
        let begun = self.begun[table as usize];
        let mut row = Row { naming: begun.is_none(), ..Row::default() };
        row.message("", message);
        let (found, allowed) = (row.cells.len(), begun.unwrap_or(row.cells.len()));
        if found != allowed || found > MOST_COLUMNS {
            let most = allowed.min(MOST_COLUMNS);
            return Err(frame.damaged(format!("{} of {found} columns; allowed: at most {most}", table.name())));
        }
        if begun.is_none() {
            self.sink.begin(table, &row.columns)?;
            self.begun[table as usize] = Some(found);
        }
        Ok(self.sink.row(table, &row.cells)?)
    }

    /// Begins tables without rows whose columns do not depend on the scene.
    fn begin_the_rest(&mut self) -> Result<(), ReadError> {
        for (table, kind) in &self.messages {
            let known = kind.fields().all(|field| !field.is_list());
            if known && self.begun[*table as usize].is_none() {
                let mut row = Row { naming: true, ..Row::default() };
                row.message("", &DynamicMessage::new(kind.clone()));
                self.sink.begin(*table, &row.columns)?;
            }
        }
        Ok(())
    }
}

/// A flattened message.
#[derive(Default)]
struct Row {
    /// Whether to collect the columns as well as the cells.
    naming: bool,
    columns: Vec<Column>,
    cells: Vec<Cell>,
}

impl Row {
    /// Adds the fields of a message with the prefix `place`. An absent submessage counts as zero.
    fn message(&mut self, place: &str, message: &DynamicMessage) {
        for field in message.descriptor().fields() {
            let name = self.name(place, field.name());
            if is_field_optional(&field) && !message.has_field(&field) {
                self.add(&name, &field, &field.default_value(), true);
                continue;
            }
            match &*message.get_field(&field) {
                Value::List(items) => {
                    for (i, item) in items.iter().enumerate().take(MOST_COLUMNS) {
                        let name = self.name(&name, &i.to_string());
                        self.add(&name, &field, item, false);
                    }
                }
                value => self.add(&name, &field, value, false),
            }
        }
    }

    fn add(&mut self, name: &str, field: &FieldDescriptor, value: &Value, absent: bool) {
        let (kind, cell) = match value {
            Value::Message(message) => return self.message(name, message),
            Value::F64(number) => (ColumnKind::Double, Cell::Double(*number)),
            Value::F32(number) => (ColumnKind::Float, Cell::Float(*number)),
            Value::U32(number) => (ColumnKind::Whole, Cell::Whole((*number).into())),
            Value::I32(number) => (ColumnKind::Whole, Cell::Whole((*number).into())),
            Value::I64(number) => (ColumnKind::Whole, Cell::Whole(*number)),
            Value::Bool(yes) => (ColumnKind::Whole, Cell::Whole((*yes).into())),
            Value::String(text) => (ColumnKind::Text, Cell::Text(text.clone())),
            Value::EnumNumber(number) => (ColumnKind::Text, Cell::Text(enumeration_word(field, *number))),
            // A test asserts that our messages contain none of these types.
            Value::U64(_) | Value::Bytes(_) | Value::List(_) | Value::Map(_) => return,
        };
        if self.naming {
            self.columns.push(Column { name: name.to_owned(), kind, optional: is_field_optional(field) });
        }
        self.cells.push(if absent { Cell::Empty } else { cell });
    }

    /// Returns the name of a part of `place`: the part is inserted before the unit, if there is
    /// one.
    fn name(&self, place: &str, part: &str) -> String {
        match (self.naming, place) {
            (false, _) => String::new(),
            (true, "") => part.to_owned(),
            (true, place) => {
                let unit =
                    UNITS.iter().map(|(ending, _)| *ending).find(|ending| place.ends_with(ending)).unwrap_or_default();
                format!("{}_{part}{unit}", place.strip_suffix(unit).unwrap_or(place))
            }
        }
    }
}

/// Returns whether a number or text is optional; submessages are not: if absent they are zero.
fn is_field_optional(field: &FieldDescriptor) -> bool {
    field.supports_presence() && field.kind().as_message().is_none()
}

/// Returns the name of an enumeration's value; its number if a later version has added the value.
fn enumeration_word(field: &FieldDescriptor, number: i32) -> String {
    let value = field.kind().as_enum().and_then(|kind| kind.get_value(number));
    value.map_or_else(|| number.to_string(), |value| value.name().to_owned())
}
