//! `web-admin verify`: checks that all stored data are intact.

use std::path::{Path, PathBuf};

use acts::audit::audit_checkpoints;
use acts::operations::verification;
use acts::operations::verification::VerificationReport;
use acts::privacy::erasure_store::ErasureStore;
use acts::training::certificates;
use acts::training::certificates::KEY_FILE;
use anyhow::Context;
use clap::Args;
use platform::config::Config;
use platform::recording_store::RecordingStore;
use store::{Database, DumpRefused, DumpedDatabase};

use super::{CommandFailure, StorageArgs, say_line};

/// Options of `web-admin verify`.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    #[command(flatten)]
    storage: StorageArgs,
    /// A dump of the database made by pg_dump: it is restored into a temporary database on the same
    /// server and checked in place of the served one, with the recordings that it names
    #[arg(long, value_name = "FILE")]
    dump: Option<PathBuf>,
    /// Last hash of the audit log as printed by an earlier backup or verification; finds a log that
    /// was truncated since
    #[arg(long, value_name = "HASH", value_parser = parse_audit_head)]
    expect_head: Option<String>,
    /// A signed checkpoint of the audit log, from statements/ in the data folder or the bucket, or
    /// from an email of `serve --anchor-mail`; may be repeated
    #[arg(long, value_name = "FILE")]
    statement: Vec<PathBuf>,
    /// The public key of the checkpoint's signature, as published by the school [default: this
    /// service's own]
    #[arg(long, value_name = "HEX", requires = "statement", value_parser = parse_audit_head)]
    statement_key: Option<String>,
}

fn parse_audit_head(given: &str) -> Result<String, &'static str> {
    let digits = given.len() == 64 && given.bytes().all(|digit| digit.is_ascii_hexdigit());
    if digits { Ok(given.to_ascii_lowercase()) } else { Err("allowed: 64 hexadecimal digits") }
}

pub(super) async fn run_verify(args: &VerifyArgs) -> Result<(), CommandFailure> {
    let config = args.storage.config()?;
    let report = match &args.dump {
        Some(file) => verify_dump(args, &config, file).await?,
        None => verify_database(args, &config).await?,
    };
    let VerificationReport { recordings, audit_rows, audit_head, findings } = report;
    findings.iter().for_each(say_line);
    let counts = format!("{recordings} recordings and {audit_rows} audit rows checked");
    say_line(format_args!("{counts}, {} findings; the audit log ends in {audit_head}", findings.len()));
    if findings.is_empty() { Ok(()) } else { Err(CommandFailure::Found) }
}

async fn verify_database(args: &VerifyArgs, config: &Config) -> Result<VerificationReport, CommandFailure> {
    let db = Database::open_existing(&config.database).await.context("cannot open the database")?;
    let missing = db.count_missing_migrations().await.context("cannot read the database")?;
    if missing > 0 {
        let words = "this database is of an earlier version; run `web-admin migrate` first";
        return Err(CommandFailure::Usage(format!("{}: {words} (missing migrations: {missing})", config.database)));
    }
    let store = RecordingStore::open(config)?;
    let mut report = verification::everything(&db, &store).await?;
    report.findings.extend(compare_with_told(args, config, &db).await?);
    report.findings.extend(verification::unerased(&db, &ErasureStore::of(config, &store)).await?);
    db.close().await;
    Ok(report)
}

/// Verifies a dump. People erased since it was made are still in it, which is no finding: the
/// service erases them again when it serves the dump.
async fn verify_dump(args: &VerifyArgs, config: &Config, file: &Path) -> Result<VerificationReport, CommandFailure> {
    let refused = |error: DumpRefused| CommandFailure::Usage(format!("--dump: {error}"));
    let dumped = DumpedDatabase::restore(file, &config.database).await.map_err(refused)?;
    let looked = look_at_dump(args, config, dumped.database()).await;
    dumped.remove().await.context("the temporary database for the dump remains on the server")?;
    looked
}

async fn look_at_dump(args: &VerifyArgs, config: &Config, db: &Database) -> Result<VerificationReport, CommandFailure> {
    let served = Database::open_if_there(&config.database).await.context("cannot open the database")?;
    let mut report = verification::copy(db, served.as_ref(), &RecordingStore::open(config)?).await?;
    if let Some(served) = served {
        served.close().await;
    }
    report.findings.extend(compare_with_told(args, config, db).await?);
    Ok(report)
}

/// Compares the audit log with hashes and checkpoints recorded earlier, and returns the findings.
async fn compare_with_told(args: &VerifyArgs, config: &Config, db: &Database) -> Result<Vec<String>, CommandFailure> {
    let mut findings = Vec::new();
    if let Some(head) = &args.expect_head {
        findings.extend(verification::cut_tail(db, head).await?);
    }
    for file in &args.statement {
        findings.extend(compare_with_statement(db, config, file, args.statement_key.as_deref()).await?);
    }
    Ok(findings)
}

/// Compares the audit log with a checkpoint; a checkpoint that is not genuine is a finding, too.
async fn compare_with_statement(
    db: &Database,
    config: &Config,
    file: &Path,
    key: Option<&str>,
) -> Result<Option<String>, CommandFailure> {
    let named = |why: &dyn std::fmt::Display| format!("--statement: {}: {why}", file.display());
    let bytes = std::fs::read(file).map_err(|error| CommandFailure::Usage(named(&error)))?;
    let key = match key {
        Some(key) => key.to_owned(),
        None if config.keys_dir.join(KEY_FILE).exists() => certificates::public_key(&config.keys_dir)?,
        None => {
            return Err(CommandFailure::Usage(named(
                &"no key to check it with; give the published one with --statement-key",
            )));
        }
    };
    match audit_checkpoints::check(&bytes, &key) {
        Ok(head) => Ok(verification::strayed_from(db, &head).await?),
        Err(why) => Ok(Some(format!("statement {}: not genuine: {why:#}", file.display()))),
    }
}
