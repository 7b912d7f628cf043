//! Checks the integrity of the database at start-up: its pages table by table, and the audit log
//! row by row. Start-up waits for a limited time, so that a school's database has been checked
//! before requests are served; a longer check continues in the background.
//!
//! Damage is recorded in the data folder. The next start then waits for the whole check, and
//! refuses to serve a database that is still damaged.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use anyhow::Context;
use platform::config::Config;
use platform::files::remove_if_there;
use store::{Database, audit};

/// Advice shown with a finding.
const ADVICE: &str = "the database is damaged and cannot be served; restore a backup with web-admin restore";

/// Progress of an integrity check.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct InspectionState {
    /// Number of tables.
    pub tables: usize,
    /// Number of tables whose pages have been read.
    pub tables_read: usize,
    /// Rows of the audit log when the check began.
    pub audit_rows: i64,
    /// Rows of the audit log that have been verified.
    pub audit_rows_read: usize,
    /// Whether the check is running.
    pub going: bool,
    /// Findings, each naming the damaged place.
    pub findings: Vec<String>,
}

/// An integrity check whose progress can be queried.
#[derive(Debug, Default)]
pub struct Inspection(Mutex<InspectionState>);

impl Inspection {
    /// Returns the current progress.
    #[must_use]
    pub fn state(&self) -> InspectionState {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn change(&self, change: impl FnOnce(&mut InspectionState)) {
        change(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner));
    }

    fn find(&self, findings: impl IntoIterator<Item = String>) {
        self.change(|state| {
            for finding in findings {
                tracing::error!(%finding, "the database is damaged");
                state.findings.push(finding);
            }
        });
    }
}

/// Starts the check and waits for up to `patience`. Waits until its end if an earlier check found
/// damage, or if migrations are pending, since a damaged file must not be written to. A missing
/// database passes.
///
/// # Errors
/// Fails if damage is found while waiting, with one line that describes it and what to do.
pub async fn begin_inspection(config: &Config, patience: Duration) -> anyhow::Result<Arc<Inspection>> {
    let inspection = Arc::new(Inspection::default());
    let Some(db) = Database::open_if_there(&config.database).await.context(ADVICE)? else {
        return Ok(inspection);
    };
    inspection.change(|state| state.going = true);
    let mark = damage_mark(config);
    let patience = if mark.exists() || is_migration_due(&db).await { Duration::MAX } else { patience };
    let look = tokio::spawn(look_and_mark(db, Arc::clone(&inspection), mark));
    match tokio::time::timeout(patience, look).await {
        Ok(looked) => looked.context("the database was not checked")?,
        Err(_elapsed) => tracing::info!("database check still running; serving meanwhile"),
    }
    match &inspection.state().findings[..] {
        [] => Ok(inspection),
        [first, rest @ ..] => anyhow::bail!("{ADVICE}: {first} ({} more findings)", rest.len()),
    }
}

/// Returns the path of the file that records damage for the next start.
fn damage_mark(config: &Config) -> PathBuf {
    config.data_dir.join("damaged")
}

/// Returns whether migrations may be pending; true also if the database cannot report which have
/// run.
async fn is_migration_due(db: &Database) -> bool {
    !matches!(db.count_missing_migrations().await, Ok(0))
}

async fn look_and_mark(db: Database, inspection: Arc<Inspection>, mark: PathBuf) {
    if let Err(error) = look_through(&db, &inspection).await {
        inspection.find([format!("{error:#}")]);
    }
    db.close().await;
    let findings = inspection.state().findings;
    let marked = match &findings[..] {
        [] => remove_if_there(&mark),
        findings => std::fs::write(&mark, findings.join("\n") + "\n"),
    };
    if let Err(error) = marked {
        tracing::warn!(cause = %error, mark = %mark.display(), "failed to store the result of the database check for the next start");
    }
    inspection.change(|state| state.going = false);
    if findings.is_empty() {
        tracing::info!(audit_rows = inspection.state().audit_rows_read, "database check passed");
    } else {
        tracing::error!("{ADVICE} from the next start on");
    }
}

async fn look_through(db: &Database, inspection: &Inspection) -> store::Result<()> {
    let tables = db.list_tables().await?;
    let audit_rows =
        if audit::is_entry_kept(db.reader()).await? { audit::find_audit_head(db.reader()).await?.0 } else { 0 };
    inspection.change(|state| {
        state.tables = tables.len();
        state.audit_rows = audit_rows;
    });
    for table in &tables {
        inspection.find(db.damaged_pages(table).await?);
        inspection.change(|state| state.tables_read += 1);
    }
    if audit_rows > 0 && inspection.state().findings.is_empty() {
        let walked = |rows| inspection.change(|state| state.audit_rows_read = rows);
        inspection.find(audit::walk_audit_chain(db.reader(), walked).await?.findings);
    }
    Ok(())
}
