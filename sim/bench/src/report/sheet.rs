//! Tables of results, written as CSV and Markdown.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::BenchError;

/// A table of results. Column names carry their units.
pub struct ReportSheet {
    columns: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl ReportSheet {
    /// Creates an empty table.
    pub fn new(columns: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self { columns: columns.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = impl Into<String>>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }

    /// Writes the table as CSV.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn write_csv(&self, path: &Path) -> Result<(), BenchError> {
        let cannot = |error: csv::Error| BenchError::work(format_args!("{}: {error}", path.display()));
        let mut writer = csv::Writer::from_path(path).map_err(cannot)?;
        writer.write_record(&self.columns).map_err(cannot)?;
        self.rows.iter().try_for_each(|row| writer.write_record(row)).map_err(cannot)?;
        writer.flush().map_err(|error| BenchError::work(format_args!("{}: {error}", path.display())))
    }

    /// Formats the table as Markdown.
    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let rule = format!("|{}\n", "---|".repeat(self.columns.len()));
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        format!("{}{rule}{rows}", line(&self.columns))
    }
}

/// Writes a text file and returns its path.
///
/// # Errors
/// On an I/O error.
pub fn write_text(path: PathBuf, text: &str) -> Result<PathBuf, BenchError> {
    match fs::write(&path, text) {
        Ok(()) => Ok(path),
        Err(error) => Err(BenchError::work(format_args!("{}: {error}", path.display()))),
    }
}
