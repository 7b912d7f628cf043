//! The end of the audit log, told outside the database once a day: whoever cuts the log or makes it anew cannot take back what was told.
//!
//! A statement says how many rows the log had and by which hash it ended, signed by the key of certificates. It is a file in
//! `statements/` of the data folder or the bucket, one for each day, and a letter to whoever keeps them elsewhere. `web-admin verify --statement` holds the log to it.

use std::time::Duration;

use anyhow::{Context, ensure};
use model::Moment;
use model::certificate::{self, Certificate};
use model::ids::LetterId;
use serde::{Deserialize, Serialize};
use store::audit;

use crate::certificates;
use crate::mailer::Letter;
use crate::replicas::{self, Duty};
use crate::service::Service;
use crate::statement_store::StatementStore;

/// What a statement is of.
const OF: &str = "the audit log of a Stylet service";
/// Version of the layout.
const FORMAT: u32 = 1;
/// How often it is looked whether today's is made and told.
const EVERY: Duration = Duration::from_secs(3600);

/// What is stated.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AuditHead {
    /// Always the same words, by which it is told from whatever else the key signs.
    of: String,
    /// Version of this layout.
    format: u32,
    /// When, RFC 3339.
    pub made_at: String,
    /// How many rows the log had.
    pub rows: i64,
    /// Hash of the last of them, hexadecimal; 64 zeros where there was none.
    pub head: String,
}

/// Makes today's statement where there is none, and tells it where it was not told: where it is. None where both were done.
///
/// # Errors
/// When the database, the key, the disk, the bucket or the mail fails; the next look tries again.
pub async fn anchor(state: &Service) -> anyhow::Result<Option<String>> {
    let now = state.clock.now();
    let day = now.to_string().chars().take_while(|c| *c != 'T').collect::<String>();
    let store = StatementStore::of(&state.config, &state.recordings);
    let (name, told) = (format!("{day}.json"), format!("{day}.mailed"));
    let found = store.read(&name).await?;
    let made = found.is_none();
    let statement = match found {
        Some(statement) => statement,
        None => {
            let statement = sign_head(state, now).await?;
            store.keep(&name, statement.clone()).await?;
            statement
        }
    };
    if let Some(address) = &state.config.anchor_mail
        && store.read(&told).await?.is_none()
    {
        let letter = letter(&day, address, std::str::from_utf8(&statement)?);
        state
            .mailer
            .send(Letter { id: LetterId::made_at(now), ..letter }, now)
            .await
            .context("the statement was not mailed")?;
        store.keep(&told, address.clone().into_bytes()).await?;
        return Ok(Some(store.place(&name)));
    }
    Ok(made.then(|| store.place(&name)))
}

/// A signed statement of how the audit log ends now.
async fn sign_head(state: &Service, now: Moment) -> anyhow::Result<Vec<u8>> {
    let (rows, head) = audit::find_audit_head(state.db.reader()).await?;
    let head = AuditHead { of: OF.to_owned(), format: FORMAT, made_at: now.to_string(), rows, head };
    let keys_dir = state.config.keys_dir.clone();
    let key = tokio::task::spawn_blocking(move || certificates::signing_key(&keys_dir)).await??;
    Ok(serde_json::to_vec_pretty(&certificate::sign_text(&key, &serde_json::to_string(&head)?))?)
}

fn letter(day: &str, address: &str, statement: &str) -> Letter {
    Letter {
        id: LetterId::nil(),
        name: String::new(),
        email: address.to_owned(),
        subject: format!("The audit log of Stylet on {day}"),
        body: format!(
            "Keep this letter. Whoever asks later whether the audit log is whole saves the lines below as a file and runs\n\n\
             web-admin verify --statement FILE\n\n{statement}\n"
        ),
    }
}

/// Reads a statement, and checks that a key has signed it. A letter as it was mailed will do: the statement stands between braces.
///
/// # Errors
/// When it is none, of another key, or was changed.
pub fn check(file: &[u8], key: &str) -> anyhow::Result<AuditHead> {
    let text = std::str::from_utf8(file).context("not a statement")?;
    let (from, to) = (text.find('{').context("not a statement")?, text.rfind('}').context("not a statement")?);
    let signed: Certificate =
        serde_json::from_str(text.get(from..=to).unwrap_or_default()).context("not a statement")?;
    let head: AuditHead = serde_json::from_str(certificate::checked_text(&signed, key)?).context("not a statement")?;
    ensure!(head.of == OF && head.format == FORMAT, "a statement of another kind or version");
    Ok(head)
}

/// Looks once an hour, until it is dropped.
pub async fn run(state: Service) {
    loop {
        let state_it = async {
            if let Some(file) = anchor(&state).await? {
                tracing::info!(file, "the end of the audit log is stated");
            }
            Ok(())
        };
        if let Err(error) = replicas::do_duty(&state, Duty::Statements, state_it).await {
            tracing::warn!(cause = format!("{error:?}"), "the end of the audit log could not be stated");
        }
        tokio::time::sleep(EVERY).await;
    }
}
