//! The administrator's page of backups.

use std::time::Duration;

use askama::Template;
use askama_web::WebTemplate;
use time::OffsetDateTime;

use crate::{Shell, StatusWord, format};

/// Without a backup for this long, the page warns: one per night is usual, and a single failure is
/// tolerated.
const OLD: Duration = Duration::from_secs(2 * 86_400);

/// The page of backups.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "operations/backups.html")]
pub struct BackupsPage {
    /// Page frame.
    pub shell: Shell,
    /// Age of the latest successful backup.
    pub age: Option<Duration>,
    /// The latest successful backup.
    pub last: Option<BackupRow>,
    /// Recent backups including failed ones, latest first.
    pub rows: Vec<BackupRow>,
}

/// A backup.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BackupRow {
    /// Start time.
    pub at: OffsetDateTime,
    /// File name.
    pub file_name: String,
    /// Size in bytes; `None` if the backup failed.
    pub bytes: Option<i64>,
    /// Number of recordings in it; `None` if the backup failed.
    pub recordings: Option<i64>,
    /// Whether it contains the keys, encrypted.
    pub keys_sealed: bool,
    /// Why the backup failed.
    pub error: Option<String>,
}

impl BackupRow {
    fn contents(&self) -> String {
        let recordings = self.recordings.unwrap_or(0);
        trn!("the database and {n} recording", "the database and {n} recordings", recordings)
    }
}

impl BackupsPage {
    fn is_old(&self) -> bool {
        self.age.is_none_or(|age| age > OLD)
    }

    /// Returns whether the latest backup failed.
    fn has_failed(&self) -> bool {
        self.rows.first().is_some_and(|row| row.error.is_some())
    }
}

#[cfg(test)]
mod tests {
    //! A school without a recent backup must be warned, and a failed backup must not look
    //! successful.

    use model::Role;
    use time::macros::datetime;

    use super::*;
    use crate::samples;

    fn row(error: Option<&str>) -> BackupRow {
        BackupRow {
            at: datetime!(2026-11-21 01:00 UTC),
            file_name: "2026-11-21T010000.tar".to_owned(),
            bytes: error.is_none().then_some(5_230_000_000),
            recordings: error.is_none().then_some(812),
            keys_sealed: true,
            error: error.map(str::to_owned),
        }
    }

    #[test]
    fn an_old_backup_and_a_failed_one_are_said() {
        let shell = samples::shell(Role::Administrator);
        let page = BackupsPage {
            shell: shell.clone(),
            age: Some(Duration::from_secs(9 * 3600)),
            last: Some(row(None)),
            rows: vec![row(None)],
        };
        let html = samples::keep_page("backups", &page);
        assert!(
            html.contains("5.2\u{a0}GB") && html.contains("812 recordings") && !html.contains("notice bad"),
            "{html}"
        );
        let rows = vec![row(Some("the disk is full")), row(None)];
        let page = BackupsPage {
            shell: shell.clone(),
            age: Some(Duration::from_secs(3 * 86_400)),
            last: Some(row(None)),
            rows,
        };
        let html = samples::keep_page("backups-old", &page);
        assert!(html.contains("older than two days") && html.contains("the disk is full"), "{html}");
        let html = samples::keep_page("backups-none", &BackupsPage { shell, age: None, last: None, rows: vec![] });
        assert!(html.contains("There is no backup yet"), "{html}");
    }
}
