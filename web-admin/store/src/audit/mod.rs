//! Audit log: an append-only hash chain in which each row contains the hash of the previous row.

pub mod search;

use std::collections::BTreeMap;

use data_encoding::{HEXLOWER, HEXLOWER_PERMISSIVE};
use futures::TryStreamExt;
use model::ids::{PersonId, SchoolId, SessionId};
use model::{CurrentPerson, Moment};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use sqlx::FromRow;

use crate::{Connection, Executor, Result, engine};

/// An entry to be appended to the audit log.
#[derive(Clone, Debug)]
pub struct AuditEntry<'a> {
    /// School, if the action belongs to one.
    school_id: Option<SchoolId>,
    /// Person or system component that acted.
    actor: Actor,
    /// Action, for example `session.uploaded`.
    action: &'a str,
    /// Object of the action: an id, never a name.
    object: String,
    /// Additional details, as JSON.
    details: Value,
}

/// Person or system component that acted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Actor {
    /// A person, in the browser or through the API.
    Person(PersonId),
    /// A training station.
    Station(String),
    /// An administrator who runs the command line on the server.
    CommandLine,
    /// A directory, by SCIM.
    Directory,
    /// The scoring worker.
    Worker,
    /// A survey respondent. The entry does not identify the person, so that answers stay anonymous.
    Respondent,
    /// A visitor who failed to sign in.
    Stranger,
}

impl std::fmt::Display for Actor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Person(id) => write!(f, "{id}"),
            Self::Station(name) => write!(f, "station {name}"),
            Self::CommandLine => f.write_str("command line"),
            Self::Directory => f.write_str("directory"),
            Self::Worker => f.write_str("worker"),
            Self::Respondent => f.write_str("respondent"),
            Self::Stranger => f.write_str("stranger"),
        }
    }
}

#[derive(FromRow)]
struct AuditRow {
    seq: i64,
    at: Moment,
    school_id: Option<SchoolId>,
    actor: String,
    action: String,
    object: String,
    details: String,
    prev_hash: Vec<u8>,
    hash: Vec<u8>,
}

impl AuditRow {
    /// Returns `sha256(prev_hash ‖ row)` with the row as a JSON array. JSON escaping makes the
    /// encoding unambiguous for any field contents.
    fn seal(&self) -> Vec<u8> {
        let canonical = serde_json::json!([
            self.seq,
            self.at.micros(),
            self.school_id,
            self.actor,
            self.action,
            self.object,
            self.details
        ]);
        Sha256::new().chain_update(&self.prev_hash).chain_update(canonical.to_string()).finalize().to_vec()
    }
}

impl<'a> AuditEntry<'a> {
    /// Makes an entry without details.
    pub fn new(
        school_id: impl Into<Option<SchoolId>>,
        actor: Actor,
        action: &'a str,
        object: impl Into<String>,
    ) -> Self {
        let (school_id, object, details) = (school_id.into(), object.into(), json!({}));
        Self { school_id, actor, action, object, details }
    }

    /// Makes an entry for an action of a signed-in person in their school.
    pub fn by(person: &CurrentPerson, action: &'a str, object: impl Into<String>) -> Self {
        Self::new(person.school_id, Actor::Person(person.id), action, object)
    }

    /// Adds details.
    #[must_use]
    pub fn with(self, details: Value) -> Self {
        Self { details, ..self }
    }

    /// Appends the entry. Call it in the transaction of the recorded change, so that both are
    /// committed or neither.
    pub async fn append(self, writer: &mut Connection, now: Moment) -> Result<()> {
        // Reading the last row first is safe: only one transaction writes at a time.
        let last: Option<(i64, Vec<u8>)> = sqlx::query_as("SELECT seq, hash FROM audit_log ORDER BY seq DESC LIMIT 1")
            .fetch_optional(&mut *writer)
            .await?;
        let (last_seq, prev_hash) = last.unwrap_or_else(|| (0, vec![0; 32]));
        let mut row = AuditRow {
            seq: last_seq + 1,
            at: now,
            school_id: self.school_id,
            actor: self.actor.to_string(),
            action: self.action.to_owned(),
            object: self.object,
            details: self.details.to_string(),
            prev_hash,
            hash: Vec::new(),
        };
        row.hash = row.seal();
        insert_audit_entry(writer, &row).await
    }
}

async fn insert_audit_entry(writer: &mut Connection, row: &AuditRow) -> Result<()> {
    sqlx::query(
        "INSERT INTO audit_log (seq, at, school_id, actor, action, object, details, prev_hash, hash)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9)",
    )
    .bind(row.seq)
    .bind(row.at)
    .bind(row.school_id)
    .bind(&row.actor)
    .bind(&row.action)
    .bind(&row.object)
    .bind(&row.details)
    .bind(&row.prev_hash)
    .bind(&row.hash)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the scores (0–100) of each attempt in the audit log, in order. An attempt that was
/// uploaded but not yet scored has an empty list.
pub async fn list_told_scores(executor: impl Executor<'_>) -> Result<BTreeMap<SessionId, Vec<f64>>> {
    let rows: Vec<(String, Option<String>)> = sqlx::query_as(
        "SELECT object, CASE action WHEN 'session.scored' THEN details ->> '$.score'
                                    WHEN 'session.regraded' THEN details ->> '$.to' END || ''
         FROM audit_log WHERE action IN ('session.uploaded', 'session.scored', 'session.regraded') ORDER BY seq",
    )
    .fetch_all(executor)
    .await?;
    let mut told: BTreeMap<SessionId, Vec<f64>> = BTreeMap::new();
    for (object, score) in rows {
        let Ok(session) = object.parse::<SessionId>() else { continue };
        let scores = told.entry(session).or_default();
        scores.extend(score.and_then(|score| score.parse::<f64>().ok()));
    }
    Ok(told)
}

/// Result of a verification of the hash chain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AuditChain {
    /// Number of rows verified.
    pub rows: usize,
    /// Hash of the last row, in hexadecimal. A copy kept elsewhere reveals a log that was
    /// truncated.
    pub head: String,
    /// Descriptions of missing or modified rows.
    pub findings: Vec<String>,
}

/// Returns whether the audit log table exists. A database that was never migrated has none.
pub async fn is_entry_kept(executor: impl Executor<'_>) -> Result<bool> {
    engine::is_table_there(executor, "audit_log").await
}

/// Returns whether a row of the log has this hash, in hexadecimal.
pub async fn holds_hash(executor: impl Executor<'_>, hash: &str) -> Result<bool> {
    sqlx::query_scalar("SELECT count(*) > 0 FROM audit_log WHERE hash = $1")
        .bind(HEXLOWER_PERMISSIVE.decode(hash.as_bytes()).unwrap_or_default())
        .fetch_one(executor)
        .await
}

/// Returns the number of rows in the log and the hash of the last row, in hexadecimal; 64 zeros if
/// the log is empty.
pub async fn find_audit_head(executor: impl Executor<'_>) -> Result<(i64, String)> {
    let last: Option<(i64, Vec<u8>)> =
        sqlx::query_as("SELECT seq, hash FROM audit_log ORDER BY seq DESC LIMIT 1").fetch_optional(executor).await?;
    Ok(last.map_or_else(|| (0, "0".repeat(64)), |(rows, hash)| (rows, HEXLOWER.encode(&hash))))
}

/// Returns whether the row with this number has this hash, in hexadecimal.
pub async fn holds_hash_at(executor: impl Executor<'_>, row: i64, hash: &str) -> Result<bool> {
    sqlx::query_scalar("SELECT count(*) > 0 FROM audit_log WHERE seq = $1 AND hash = $2")
        .bind(row)
        .bind(HEXLOWER_PERMISSIVE.decode(hash.as_bytes()).unwrap_or_default())
        .fetch_one(executor)
        .await
}

/// Verifies the hash chain from the first row.
pub async fn check_audit_chain(executor: impl Executor<'_>) -> Result<AuditChain> {
    walk_audit_chain(executor, |_| {}).await
}

/// Same as [`check_audit_chain`], and reports the number of verified rows after each row.
pub async fn walk_audit_chain(executor: impl Executor<'_>, mut walked: impl FnMut(usize)) -> Result<AuditChain> {
    let mut rows = sqlx::query_as::<_, AuditRow>(
        "SELECT seq, at, school_id, actor, action, object, details, prev_hash, hash FROM audit_log ORDER BY seq",
    )
    .fetch(executor);
    let mut chain = AuditChain { rows: 0, head: String::new(), findings: Vec::new() };
    let (mut prev, mut expected) = (vec![0; 32], 1_i64);
    while let Some(row) = rows.try_next().await? {
        if row.seq != expected {
            chain.findings.push(format!("audit log: row {expected} is missing, row {} follows", row.seq));
            break;
        }
        if row.prev_hash != prev {
            chain.findings.push(format!("audit log: row {} does not follow the row before it", row.seq));
        }
        if row.seal() != row.hash {
            chain.findings.push(format!("audit log: row {} was changed after it was written", row.seq));
        }
        chain.rows += 1;
        walked(chain.rows);
        expected += 1;
        prev = row.hash;
    }
    chain.head = HEXLOWER.encode(&prev);
    Ok(chain)
}
