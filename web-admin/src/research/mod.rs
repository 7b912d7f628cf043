//! Exports a school's attempts as Parquet tables for research: under pseudonyms, in bounded memory,
//! with a codebook.

mod columns;

use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

use acts::studies::research::ResearchCounts;
use anyhow::Context;
use columnar::ParquetTable;
use columns::{ATTEMPTS, METRICS, SESSION, columns_of_file, describe_columns};
use model::ids::{SchoolId, SessionId};
use pages::format;
use platform::recording_store::LocalRecording;
use recording::tables::{Cell, Column, Table, TableSink, read_tables};
use serde_json::json;
use store::scoring::scores;
use store::studies::research::{ResearchAttempt, count_held_back, list_research_attempts};

use crate::AppState;

/// Attempts read per query.
const AT_ONCE: u32 = 200;

/// The request for an export.
#[derive(Clone, Debug)]
pub struct ResearchOrder {
    /// Folder for the tables; it exists and contains none of them.
    pub folder: PathBuf,
    /// Whether to write every sample of every recording.
    pub samples: bool,
}

impl ResearchOrder {
    /// Returns the files that the export writes.
    #[must_use]
    pub fn files(&self) -> Vec<PathBuf> {
        let tables = ["attempts", "metrics"].into_iter().chain(self.samples.then_some("samples"));
        tables.map(|table| self.file(table)).chain([self.folder.join("codebook.json")]).collect()
    }

    /// Returns the file of a table.
    fn file(&self, table: &str) -> PathBuf {
        self.folder.join(table).with_extension("parquet")
    }
}

/// Writes the tables and the codebook.
///
/// # Errors
/// When the database or the disk fails.
pub async fn write_research_tables(
    state: &AppState,
    school: SchoolId,
    order: &ResearchOrder,
) -> anyhow::Result<ResearchCounts> {
    let mut attempts = create_table(&order.file("attempts"), &columns_of_file(&ATTEMPTS))?;
    let mut metrics = create_table(&order.file("metrics"), &columns_of_file(&METRICS))?;
    let mut samples = order.samples.then(|| SamplesTable::new(order.file("samples")));
    let held_back = count_held_back(state.db.reader(), school).await?;
    let mut counts =
        ResearchCounts { of_guests: held_back.of_guests, of_staff: held_back.of_staff, ..ResearchCounts::default() };
    let mut after = SessionId::nil();
    loop {
        let found = list_research_attempts(state.db.reader(), school, after, AT_ONCE).await?;
        let Some(last) = found.last() else { break };
        after = last.id;
        for attempt in &found {
            attempts.write_row(&cells_of_attempt(attempt))?;
            counts.attempts += 1;
        }
        counts.metrics += write_metrics(state, school, &found, &mut metrics).await?;
        if let Some(samples) = &mut samples {
            write_samples(state, &found, samples, &mut counts).await?;
        }
    }
    attempts.finish()?;
    metrics.finish()?;
    samples.map_or(Ok(()), SamplesTable::finish)?;
    write_codebook(order, &counts)?;
    Ok(counts)
}

fn create_table(path: &Path, columns: &[Column]) -> anyhow::Result<ParquetTable> {
    let file = File::create_new(path).with_context(|| path.display().to_string())?;
    ParquetTable::new(file, columns).with_context(|| path.display().to_string())
}

fn cells_of_attempt(attempt: &ResearchAttempt) -> Vec<Cell> {
    let text = |text: &str| Cell::Text(text.to_owned());
    let double = |value: Option<f64>| value.map_or(Cell::Empty, Cell::Double);
    vec![
        Cell::Text(attempt.id.to_string()),
        Cell::Text(format::format_machine_time(attempt.started_at.to_utc())),
        text(&attempt.pseudonym),
        text(attempt.role.as_str()),
        text(&attempt.exercise_id),
        text(&attempt.exercise_sha256),
        text(attempt.state.word()),
        double(attempt.score),
        attempt.passed.map_or(Cell::Empty, |passed| Cell::Whole(passed.into())),
        double(attempt.computed_score),
        Cell::Double(attempt.duration_s),
        Cell::Whole(attempt.complete.into()),
        text(&attempt.device),
        text(&attempt.simulator_version),
        attempt.uncounted.map_or(Cell::Empty, |why| text(why.word())),
    ]
}

/// Writes the metrics of some attempts, metric by metric, and returns the number of rows.
async fn write_metrics(
    state: &AppState,
    school: SchoolId,
    attempts: &[ResearchAttempt],
    table: &mut ParquetTable,
) -> anyhow::Result<u64> {
    let sessions: Vec<SessionId> = attempts.iter().map(|attempt| attempt.id).collect();
    let mut written = 0;
    for metric in scores::metrics_of_many(state.db.reader(), school, &sessions).await? {
        for found in &metric.found.0 {
            let session = sessions.get(found.0).context("a metric of an attempt that was not asked for")?;
            table.write_row(&[
                Cell::Text(session.to_string()),
                Cell::Text(metric.id.clone()),
                Cell::Whole(metric.version.into()),
                found.value().map_or(Cell::Empty, Cell::Double),
                Cell::Text(metric.unit.clone()),
                found.absent().map_or(Cell::Empty, |absent| Cell::Text(absent.words().to_owned())),
            ])?;
            written += 1;
        }
    }
    Ok(written)
}

/// Writes the samples of some attempts, one recording after the other. A missing or damaged
/// recording is counted as unread.
async fn write_samples(
    state: &AppState,
    attempts: &[ResearchAttempt],
    table: &mut SamplesTable,
    counts: &mut ResearchCounts,
) -> anyhow::Result<()> {
    for attempt in attempts {
        let recording = state.recordings.fetch(&attempt.recording_path).await;
        let before = table.rows;
        table.session = attempt.id.to_string();
        let source = recording.map_err(anyhow::Error::from).and_then(|recording| open_recording(&recording));
        let read = source.and_then(|source| Ok(read_tables(source, table)?));
        if let Some(refused) = table.refused.take() {
            return Err(refused.into());
        }
        if let Err(error) = read {
            tracing::warn!(session = %attempt.id, %error, "recording cannot be read");
            counts.unread += 1;
        }
        counts.samples += table.rows - before;
    }
    Ok(())
}

/// Opens a recording; it stays readable even if its file is deleted meanwhile.
fn open_recording(recording: &LocalRecording) -> anyhow::Result<BufReader<File>> {
    Ok(BufReader::new(File::open(recording.path())?))
}

/// The samples of every recording in one table, each with its attempt.
struct SamplesTable {
    path: PathBuf,
    /// Created at the first recording, which determines the columns.
    open: Option<ParquetTable>,
    session: String,
    rows: u64,
    /// An error in writing the table, kept apart from errors in reading a recording.
    refused: Option<io::Error>,
}

impl SamplesTable {
    const fn new(path: PathBuf) -> Self {
        Self { path, open: None, session: String::new(), rows: 0, refused: None }
    }

    fn finish(self) -> anyhow::Result<()> {
        let path = self.path.display().to_string();
        match self.open {
            Some(table) => table.finish().context(path),
            // A school without recordings gets a table without samples.
            None => create_table(&self.path, &[SESSION.of_file()])?.finish().context(path),
        }
    }

    fn keep(&mut self, done: io::Result<()>) -> io::Result<()> {
        done.map_err(|error| {
            let said = io::Error::new(error.kind(), error.to_string());
            self.refused = Some(error);
            said
        })
    }
}

impl TableSink for SamplesTable {
    fn begin(&mut self, table: Table, columns: &[Column]) -> io::Result<()> {
        if table != Table::Samples || self.open.is_some() {
            return Ok(());
        }
        let all: Vec<Column> = std::iter::once(SESSION.of_file()).chain(columns.iter().cloned()).collect();
        let created = File::create_new(&self.path).and_then(|file| ParquetTable::new(file, &all));
        let created = created.map(|table| self.open = Some(table));
        self.keep(created)
    }

    fn row(&mut self, table: Table, cells: &[Cell]) -> io::Result<()> {
        let (Table::Samples, Some(open)) = (table, &mut self.open) else { return Ok(()) };
        let own = std::iter::once(Cell::Text(self.session.clone())).chain(cells.iter().cloned()).collect::<Vec<_>>();
        let written = open.write_row(&own);
        self.rows += 1;
        self.keep(written)
    }
}

fn write_codebook(order: &ResearchOrder, counts: &ResearchCounts) -> anyhow::Result<()> {
    let path = order.folder.join("codebook.json");
    let codebook = json!({
        "made_by": concat!("web-admin ", env!("CARGO_PKG_VERSION")),
        "who": "attempts of trainees, and of staff who have agreed. Attempts of guests are in the data of their study. People have pseudonyms, as in their recordings; names, addresses and numbers are not included.",
        "counts": counts,
        "tables": {
            "attempts": describe_columns(&ATTEMPTS),
            "metrics": describe_columns(&METRICS),
            "samples": if order.samples {
                json!("session, id of the attempt; then a column for each field of /needle/sample, with its unit at the end of its name: \
                       docs/recordings.md")
            } else {
                json!("not written: --samples")
            },
        },
    });
    let file = File::create_new(&path).with_context(|| path.display().to_string())?;
    serde_json::to_writer_pretty(file, &codebook).with_context(|| path.display().to_string())
}
