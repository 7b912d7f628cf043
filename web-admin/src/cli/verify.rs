//! `web-admin verify`: is everything still what was written?

use anyhow::Context;
use clap::Args;

use super::{Failure, Storage, say};
use crate::storage::Database;
use crate::verification::{self, Report};

/// What to verify.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    #[command(flatten)]
    storage: Storage,
    /// Hash by which the audit log once ended, as a backup or this command has told it: one that was cut since is found
    #[arg(long, value_name = "HASH", value_parser = head)]
    expect_head: Option<String>,
}

fn head(given: &str) -> Result<String, &'static str> {
    let digits = given.len() == 64 && given.bytes().all(|digit| digit.is_ascii_hexdigit());
    if digits { Ok(given.to_ascii_lowercase()) } else { Err("allowed are 64 hexadecimal digits") }
}

pub(super) async fn run(args: &VerifyArgs) -> Result<(), Failure> {
    let config = args.storage.config()?;
    let db = Database::open_existing(&config.database_url).await.context("cannot open the database")?;
    let mut report = verification::everything(&db, &config.recordings_dir).await?;
    if let Some(head) = &args.expect_head {
        report.findings.extend(verification::cut_tail(&db, head).await?);
    }
    db.close().await;
    let Report { recordings, audit_rows, audit_head, findings } = report;
    findings.iter().for_each(say);
    let counts = format!("{recordings} recordings and {audit_rows} audit rows checked");
    say(format_args!("{counts}, {} findings; the audit log ends in {audit_head}", findings.len()));
    if findings.is_empty() { Ok(()) } else { Err(Failure::Found) }
}
