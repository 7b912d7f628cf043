//! A table in CSV format.

use std::fs::File;
use std::io;

use recording::tables::{Cell, Column};

use super::TableFile;

/// A CSV file with a header.
pub struct CsvTable {
    writer: csv::Writer<File>,
}

impl CsvTable {
    /// Writes the header.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn new(file: File, columns: &[Column]) -> io::Result<Self> {
        let mut writer = csv::Writer::from_writer(file);
        writer.write_record(columns.iter().map(|column| &column.name))?;
        Ok(Self { writer })
    }
}

impl TableFile for CsvTable {
    fn row(&mut self, cells: &[Cell]) -> io::Result<()> {
        for cell in cells {
            self.writer.write_field(text(cell))?;
        }
        self.writer.write_record(None::<&[u8]>)?;
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.writer.flush()
    }
}

/// The shortest text that parses to the same number, in the recorded precision.
fn text(cell: &Cell) -> String {
    match cell {
        Cell::Double(number) => number.to_string(),
        Cell::Float(number) => number.to_string(),
        Cell::Whole(number) => number.to_string(),
        Cell::Text(text) => text.clone(),
        Cell::Empty => String::new(),
    }
}
