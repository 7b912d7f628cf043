//! Writes a table as Apache Parquet with the column writers of the parquet crate; flat columns do
//! not need Arrow.

use std::fs::File;
use std::io;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;
use recording::tables::{Cell, Column, ColumnKind};

/// Number of rows buffered before they are written as a row group: about a minute of the servo.
const ROWS_AT_ONCE: usize = 1 << 16;

/// A Parquet file.
pub struct ParquetTable {
    writer: SerializedFileWriter<File>,
    columns: Vec<Buffer>,
    rows: usize,
}

impl ParquetTable {
    /// Writes the file header.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn new(file: File, columns: &[Column]) -> io::Result<Self> {
        let properties = WriterProperties::builder().set_compression(Compression::ZSTD(ZstdLevel::default())).build();
        let schema = schema(columns).map_err(io::Error::other)?;
        let writer =
            SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties)).map_err(io::Error::other)?;
        Ok(Self { writer, columns: columns.iter().map(Buffer::new).collect(), rows: 0 })
    }

    /// Adds a row: a cell for each column, of the column's type.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn write_row(&mut self, cells: &[Cell]) -> io::Result<()> {
        for (buffer, cell) in self.columns.iter_mut().zip(cells) {
            buffer.push(cell);
        }
        self.rows += 1;
        if self.rows == ROWS_AT_ONCE { self.write_rows().map_err(io::Error::other) } else { Ok(()) }
    }

    /// Writes the remaining rows and the footer.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn finish(mut self) -> io::Result<()> {
        if self.rows > 0 {
            self.write_rows().map_err(io::Error::other)?;
        }
        self.writer.close().map(|_| ()).map_err(io::Error::other)
    }

    fn write_rows(&mut self) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        for buffer in &mut self.columns {
            if let Some(mut column) = group.next_column()? {
                buffer.write(&mut column)?;
                column.close()?;
            }
        }
        self.rows = 0;
        group.close().map(|_| ())
    }
}

fn schema(columns: &[Column]) -> Result<Type, ParquetError> {
    let field = |column: &Column| {
        let (physical, logical) = match column.kind {
            ColumnKind::Double => (Physical::DOUBLE, None),
            ColumnKind::Float => (Physical::FLOAT, None),
            ColumnKind::Whole => (Physical::INT64, None),
            ColumnKind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let repetition = if column.optional { Repetition::OPTIONAL } else { Repetition::REQUIRED };
        let field = Type::primitive_type_builder(&column.name, physical).with_repetition(repetition);
        field.with_logical_type(logical).build().map(Arc::new)
    };
    let fields = columns.iter().map(field).collect::<Result<_, _>>()?;
    Type::group_type_builder("stylet").with_fields(fields).build()
}

/// The buffered values of a column.
struct Buffer {
    values: Values,
    /// Definition levels: 1 for a row with a value, 0 for one without; only for optional columns.
    levels: Option<Vec<i16>>,
}

enum Values {
    Double(Vec<f64>),
    Float(Vec<f32>),
    Whole(Vec<i64>),
    Text(Vec<ByteArray>),
}

impl Buffer {
    fn new(column: &Column) -> Self {
        let values = match column.kind {
            ColumnKind::Double => Values::Double(Vec::new()),
            ColumnKind::Float => Values::Float(Vec::new()),
            ColumnKind::Whole => Values::Whole(Vec::new()),
            ColumnKind::Text => Values::Text(Vec::new()),
        };
        Self { values, levels: column.optional.then(Vec::new) }
    }

    fn push(&mut self, cell: &Cell) {
        if let Some(levels) = &mut self.levels {
            levels.push((*cell != Cell::Empty).into());
        }
        match (&mut self.values, cell) {
            (Values::Double(values), Cell::Double(value)) => values.push(*value),
            (Values::Float(values), Cell::Float(value)) => values.push(*value),
            (Values::Whole(values), Cell::Whole(value)) => values.push(*value),
            (Values::Text(values), Cell::Text(value)) => values.push(value.as_str().into()),
            // An empty cell has a level but no value; a cell whose type differs from its column's
            // does not occur.
            _ => {}
        }
    }

    /// Writes and clears the buffered values.
    fn write(&mut self, column: &mut SerializedColumnWriter<'_>) -> Result<(), ParquetError> {
        let levels = self.levels.as_deref();
        match &mut self.values {
            Values::Double(values) => write::<DoubleType>(column, values, levels),
            Values::Float(values) => write::<FloatType>(column, values, levels),
            Values::Whole(values) => write::<Int64Type>(column, values, levels),
            Values::Text(values) => write::<ByteArrayType>(column, values, levels),
        }?;
        if let Some(levels) = &mut self.levels {
            levels.clear();
        }
        Ok(())
    }
}

fn write<T: DataType>(
    column: &mut SerializedColumnWriter<'_>,
    values: &mut Vec<T::T>,
    levels: Option<&[i16]>,
) -> Result<(), ParquetError> {
    column.typed::<T>().write_batch(values, levels, None)?;
    values.clear();
    Ok(())
}
