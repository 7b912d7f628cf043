//! `web-admin verify`: is everything still what was written?

use std::path::{Path, PathBuf};

use acts::certificates::KEY_FILE;
use acts::config::Config;
use acts::erasure_store::ErasureStore;
use acts::recording_store::RecordingStore;
use acts::verification::VerificationReport;
use acts::{anchoring, certificates, verification};
use anyhow::Context;
use clap::Args;
use store::{Database, DumpRefused, DumpedDatabase};

use super::{CommandFailure, StorageArgs, say_line};

/// What to verify.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    #[command(flatten)]
    storage: StorageArgs,
    /// A dump that pg_dump has made of the database: it is put into a database of its own on the same server, checked in place of the
    /// one that is served, with the recordings that it names, and removed again
    #[arg(long, value_name = "FILE")]
    dump: Option<PathBuf>,
    /// Hash by which the audit log once ended, as a backup or this command has told it: one that was cut since is found
    #[arg(long, value_name = "HASH", value_parser = parse_audit_head)]
    expect_head: Option<String>,
    /// A signed statement of how the audit log ended, from statements/ in the data folder or the bucket, or a letter of `serve --anchor-mail`; may be given
    /// several times
    #[arg(long, value_name = "FILE")]
    statement: Vec<PathBuf>,
    /// The key that has signed it, as the school has published it [default: this service's own]
    #[arg(long, value_name = "HEX", requires = "statement", value_parser = parse_audit_head)]
    statement_key: Option<String>,
}

fn parse_audit_head(given: &str) -> Result<String, &'static str> {
    let digits = given.len() == 64 && given.bytes().all(|digit| digit.is_ascii_hexdigit());
    if digits { Ok(given.to_ascii_lowercase()) } else { Err("allowed are 64 hexadecimal digits") }
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
        let words = "an earlier program has kept this database; run `web-admin migrate` first";
        return Err(CommandFailure::Usage(format!("{}: {words} (steps missing: {missing})", config.database)));
    }
    let store = RecordingStore::open(config)?;
    let mut report = verification::everything(&db, &store).await?;
    report.findings.extend(compare_with_told(args, config, &db).await?);
    report.findings.extend(verification::unerased(&db, &ErasureStore::of(config, &store)).await?);
    db.close().await;
    Ok(report)
}

/// Verifies what a dump holds. Whoever was erased since is in it, and is erased again by whoever serves it.
async fn verify_dump(args: &VerifyArgs, config: &Config, file: &Path) -> Result<VerificationReport, CommandFailure> {
    let refused = |error: DumpRefused| CommandFailure::Usage(format!("--dump: {error}"));
    let dumped = DumpedDatabase::restore(file, &config.database).await.map_err(refused)?;
    let looked = look_at_dump(args, config, dumped.database()).await;
    dumped.remove().await.context("the database that was made for the dump is left on the server")?;
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

/// What is wrong with the log by what was told of its end before.
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

/// What is wrong with the log by a statement, or with the statement.
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
                &"no key is here to check it with; name the published one with --statement-key",
            )));
        }
    };
    match anchoring::check(&bytes, &key) {
        Ok(head) => Ok(verification::strayed_from(db, &head).await?),
        Err(why) => Ok(Some(format!("statement {}: not genuine: {why:#}", file.display()))),
    }
}
