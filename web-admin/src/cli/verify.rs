//! `web-admin verify`: is everything still what was written?

use anyhow::Context;

use super::{Failure, Storage, say};
use crate::storage::Database;
use crate::verification::{self, Report};

pub(super) async fn run(storage: &Storage) -> Result<(), Failure> {
    let config = storage.config()?;
    let db = Database::open_existing(&config.database_url).await.context("cannot open the database")?;
    let report = verification::everything(&db, &config.recordings_dir).await?;
    db.close().await;
    let Report { recordings, audit_rows, audit_head, findings } = report;
    findings.iter().for_each(say);
    let counts = format!("{recordings} recordings and {audit_rows} audit rows checked");
    say(format_args!("{counts}, {} findings; the audit log ends in {audit_head}", findings.len()));
    if findings.is_empty() { Ok(()) } else { Err(Failure::Found) }
}
