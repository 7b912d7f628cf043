//! `stylet export`: exports the numbers of a recording as tables for other programs.

mod csv;

use std::fs;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

use columnar::ParquetTable;
use recording::error::ReadError;
use recording::tables::{self, Cell, Column, Table, TableSink};
use serde::Serialize;

use self::csv::CsvTable;
use crate::exit::{Failure, Outcome};
use crate::new_file::{NewFile, create_folder};
use crate::progress::Progress;
use crate::{output, sources};

/// Export the numbers of a recording as tables, for a spreadsheet, R or Python
///
/// Writes a folder with one file per topic: samples (every servo tick), summary (10 ms), energy,
/// events, tents (the field, if the scene has one). Column names include their units;
/// docs/recordings.md describes them. Every number is exactly that of the recording: the inputs of
/// the simulation in double precision, computed values in single precision.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    stylet export attempt.mcap --to csv\n  \
    stylet export attempt.mcap --to parquet --out tables")]
pub struct ExportArgs {
    /// The recording
    #[arg(value_name = "REC.mcap")]
    recording: PathBuf,
    /// Format of the tables
    #[arg(long, value_name = "FORMAT")]
    to: Format,
    /// Folder for the tables [default: the recording's path without .mcap]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace existing tables
    #[arg(long)]
    force: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// The output formats.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Format {
    /// Text with a header; missing values are empty
    Csv,
    /// Apache Parquet, compressed with zstd
    Parquet,
}

impl Format {
    fn file(self, table: Table) -> String {
        let ending = match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        };
        format!("{}.{ending}", table.name())
    }
}

/// A table that was written.
#[derive(Serialize)]
struct WrittenTable {
    file: String,
    rows: u64,
    columns: usize,
}

/// Runs the command.
pub fn run(args: &ExportArgs) -> Outcome {
    let folder = args.out.clone().unwrap_or_else(|| args.recording.with_extension(""));
    let file = sources::open(&args.recording)?;
    let progress = Progress::new(file.metadata().map_or(0, |metadata| metadata.len()), "exporting");
    let source = BufReader::new(progress.watch(file));
    let mut export = Export::new(&folder, args)?;
    let complete = tables::read_tables(source, &mut export).map_err(|error| match error {
        ReadError::Io(error) => Failure::work(format_args!("{}: {error}", folder.display())),
        error => Failure::refused(&args.recording, error),
    })?;
    drop(progress);
    let written = export.keep()?;
    if !complete {
        sources::warn_of_cut(&args.recording);
    }
    if args.json {
        return output::print_json(&written);
    }
    output::print_buffered(|out| {
        written
            .iter()
            .try_for_each(|table| writeln!(out, "{}: {} rows, {} columns", table.file, table.rows, table.columns))
    })
}

/// A table that is being written.
trait TableFile {
    fn row(&mut self, cells: &[Cell]) -> io::Result<()>;
    fn finish(self: Box<Self>) -> io::Result<()>;
}

impl TableFile for ParquetTable {
    fn row(&mut self, cells: &[Cell]) -> io::Result<()> {
        self.write_row(cells)
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        Self::finish(*self)
    }
}

/// A table, and its temporary file.
struct OpenTable {
    table: Table,
    content: Box<dyn TableFile>,
    file: NewFile,
    written: WrittenTable,
}

/// The tables of a recording that are being written.
struct Export<'a> {
    folder: &'a Path,
    format: Format,
    overwrite: bool,
    /// Whether the folder was created by this export.
    new_folder: bool,
    open: Vec<OpenTable>,
}

impl<'a> Export<'a> {
    fn new(folder: &'a Path, args: &ExportArgs) -> Result<Self, Failure> {
        if folder.exists() && !folder.is_dir() {
            return Err(Failure::refused(folder, "is a file; allowed: a folder (--out)"));
        }
        let taken = Table::ALL.map(|table| folder.join(args.to.file(table))).into_iter().find(|file| file.exists());
        if let Some(file) = taken.filter(|_| !args.force) {
            return Err(Failure::refused(&file, "exists already; choose another folder or pass --force to replace it"));
        }
        let new_folder = !folder.exists();
        create_folder(folder)?;
        Ok(Self { folder, format: args.to, overwrite: args.force, new_folder, open: Vec::new() })
    }

    /// Finishes every table and renames the files into place.
    fn keep(mut self) -> Result<Vec<WrittenTable>, Failure> {
        let mut written = Vec::new();
        for open in std::mem::take(&mut self.open) {
            let failed = |error| Failure::work(format_args!("{}: {error}", open.written.file));
            open.content.finish().map_err(failed)?;
            open.file.keep()?;
            written.push(open.written);
        }
        Ok(written)
    }
}

impl Drop for Export<'_> {
    fn drop(&mut self) {
        // Unfinished tables are deleted, and with them a folder created for them; a folder that is
        // not empty stays.
        self.open.clear();
        if self.new_folder {
            let _ = fs::remove_dir(self.folder);
        }
    }
}

impl TableSink for Export<'_> {
    fn begin(&mut self, table: Table, columns: &[Column]) -> io::Result<()> {
        let path = self.folder.join(self.format.file(table));
        let mut file =
            NewFile::create(&path, self.overwrite).map_err(|failure| io::Error::other(failure.to_string()))?;
        let handle = file.file().try_clone()?;
        let content: Box<dyn TableFile> = match self.format {
            Format::Csv => Box::new(CsvTable::new(handle, columns)?),
            Format::Parquet => Box::new(ParquetTable::new(handle, columns)?),
        };
        let written = WrittenTable { file: path.display().to_string(), rows: 0, columns: columns.len() };
        self.open.push(OpenTable { table, content, file, written });
        Ok(())
    }

    fn row(&mut self, table: Table, cells: &[Cell]) -> io::Result<()> {
        let Some(open) = self.open.iter_mut().find(|open| open.table == table) else { return Ok(()) };
        open.written.rows += 1;
        open.content.row(cells)
    }
}
