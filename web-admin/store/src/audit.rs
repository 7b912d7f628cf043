//! Who did what, when: a log that only grows, each row sealed with the hash of the one before.

use std::collections::BTreeMap;

use data_encoding::{HEXLOWER, HEXLOWER_PERMISSIVE};
use futures::TryStreamExt;
use model::ids::{PersonId, SchoolId, SessionId};
use model::{CurrentPerson, Moment};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use sqlx::FromRow;

use super::{Connection, Executor, Result, engine};

/// Something that was done.
#[derive(Clone, Debug)]
pub struct AuditEntry<'a> {
    /// In which school, where there is one.
    school_id: Option<SchoolId>,
    /// By whom.
    actor: Actor,
    /// What, for example `session.uploaded`.
    action: &'a str,
    /// To what: an id, never a name.
    object: String,
    /// What else is worth knowing.
    details: Value,
}

/// Who did it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Actor {
    /// A person, in the browser or through the API.
    Person(PersonId),
    /// A training station.
    Station(String),
    /// Whoever may run this program on the server.
    CommandLine,
    /// The scoring worker.
    Worker,
    /// Whoever answers a survey: the log must not tell who.
    Respondent,
    /// Whoever did not get in.
    Stranger,
}

impl std::fmt::Display for Actor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Person(id) => write!(f, "{id}"),
            Self::Station(name) => write!(f, "station {name}"),
            Self::CommandLine => f.write_str("command line"),
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
    /// sha256(prev ‖ the row as a JSON array): JSON keeps the fields apart whatever they hold.
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
    /// What `actor` did in a school to `object`, without details.
    pub fn new(
        school_id: impl Into<Option<SchoolId>>,
        actor: Actor,
        action: &'a str,
        object: impl Into<String>,
    ) -> Self {
        let (school_id, object, details) = (school_id.into(), object.into(), json!({}));
        Self { school_id, actor, action, object, details }
    }

    /// What somebody who is signed in did in their school.
    pub fn by(person: &CurrentPerson, action: &'a str, object: impl Into<String>) -> Self {
        Self::new(person.school_id, Actor::Person(person.id), action, object)
    }

    /// The same, with what else is worth knowing.
    #[must_use]
    pub fn with(self, details: Value) -> Self {
        Self { details, ..self }
    }

    /// Adds it to the log, in the transaction of what it tells of: neither happens without the other.
    pub async fn append(self, writer: &mut Connection, now: Moment) -> Result<()> {
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

/// The scores of every attempt that the log tells of, in order, 0–100; none yet where it was only uploaded.
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

/// What a walk along the chain found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AuditChain {
    /// Rows walked.
    pub rows: usize,
    /// Hash of the last row, in hexadecimal: written down elsewhere, it also shows a log that was cut short.
    pub head: String,
    /// Rows that are not what was written, each in words.
    pub findings: Vec<String>,
}

/// True where the database has an audit log: one that was never migrated has none.
pub async fn is_entry_kept(executor: impl Executor<'_>) -> Result<bool> {
    engine::is_table_there(executor, "audit_log").await
}

/// Whether a row of the log has this hash, in hexadecimal.
pub async fn holds_hash(executor: impl Executor<'_>, hash: &str) -> Result<bool> {
    sqlx::query_scalar("SELECT count(*) > 0 FROM audit_log WHERE hash = $1")
        .bind(HEXLOWER_PERMISSIVE.decode(hash.as_bytes()).unwrap_or_default())
        .fetch_one(executor)
        .await
}

/// How many rows the log has, and the hash of the last, in hexadecimal; zeros where there is none.
pub async fn find_audit_head(executor: impl Executor<'_>) -> Result<(i64, String)> {
    let last: Option<(i64, Vec<u8>)> =
        sqlx::query_as("SELECT seq, hash FROM audit_log ORDER BY seq DESC LIMIT 1").fetch_optional(executor).await?;
    Ok(last.map_or_else(|| (0, "0".repeat(64)), |(rows, hash)| (rows, HEXLOWER.encode(&hash))))
}

/// Whether a row of the log has this number and hash, in hexadecimal.
pub async fn holds_hash_at(executor: impl Executor<'_>, row: i64, hash: &str) -> Result<bool> {
    sqlx::query_scalar("SELECT count(*) > 0 FROM audit_log WHERE seq = $1 AND hash = $2")
        .bind(row)
        .bind(HEXLOWER_PERMISSIVE.decode(hash.as_bytes()).unwrap_or_default())
        .fetch_one(executor)
        .await
}

/// Walks the chain from the first row.
pub async fn check_audit_chain(executor: impl Executor<'_>) -> Result<AuditChain> {
    walk_audit_chain(executor, |_| {}).await
}

/// As [`check_audit_chain`], telling after each row how many were walked.
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
