//! `/admin/backups`: the time and content of the latest backups.

use axum::extract::State;
use pages::operations::backups::{BackupRow, BackupsPage};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::auth::{Administrator, Csrf};
use routes_base::error::PageError;
use store::operations::backups;
use store::operations::backups::NotedBackup;

/// Number of backups listed.
const LISTED: u32 = 30;

pub(super) async fn show_backups(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
) -> Result<BackupsPage, PageError> {
    let reader = state.db.reader();
    let listed = backups::list_latest_backups(reader, LISTED).await?;
    let last = backups::find_last_backup(reader).await?;
    Ok(BackupsPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Administration),
        age: last.as_ref().map(|last| state.clock.now().duration_since(last.made_at)),
        last: last.map(make_backup_row),
        rows: listed.into_iter().map(make_backup_row).collect(),
    })
}

fn make_backup_row(noted: NotedBackup) -> BackupRow {
    BackupRow {
        at: noted.made_at.to_utc(),
        file_name: noted.file_name,
        bytes: noted.bytes,
        recordings: noted.recordings,
        keys_sealed: noted.keys_sealed,
        error: noted.error,
    }
}
