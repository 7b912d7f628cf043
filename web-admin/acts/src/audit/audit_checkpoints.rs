//! Audit checkpoints: publishes the head of the audit log outside the database once a day, so that
//! truncating or rewriting the log can be detected.
//!
//! A checkpoint (here: statement) holds the number of rows and the hash of the last row, signed by
//! the certificate key. Each day's is stored as a file in `statements/` of the data folder or the
//! bucket and, if configured, mailed to an external address. `web-admin verify --statement` checks
//! the log against it.

use std::time::Duration;

use anyhow::{Context, ensure};
use model::Moment;
use model::ids::LetterId;
use model::training::certificate;
use model::training::certificate::Certificate;
use platform::mailer::Letter;
use serde::{Deserialize, Serialize};
use store::audit;

use crate::audit::checkpoint_store::StatementStore;
use crate::replicas::{self, Duty};
use crate::service::Service;
use crate::training::certificates;

/// Purpose field of a statement.
const OF: &str = "the audit log of a Stylet service";
/// Version of the statement format.
const FORMAT: u32 = 1;
/// Interval between checks that today's statement has been made and mailed.
const EVERY: Duration = Duration::from_secs(3600);

/// Content of a statement: the head of the audit log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AuditHead {
    /// Always `OF`; distinguishes a statement from other texts signed by the same key.
    of: String,
    /// Version of the statement format.
    format: u32,
    /// Creation time, RFC 3339.
    pub made_at: String,
    /// Number of rows in the log.
    pub rows: i64,
    /// Hash of the last row, hexadecimal; 64 zeros if the log is empty.
    pub head: String,
}

/// Makes today's statement if it is missing, and mails it if it has not been mailed. Returns its
/// location, or `None` if there was nothing to do.
///
/// # Errors
/// Fails if the database, the key, the disk, the bucket or the mail server fails; the next run
/// retries.
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
            .context("could not email the audit checkpoint")?;
        store.keep(&told, address.clone().into_bytes()).await?;
        return Ok(Some(store.place(&name)));
    }
    Ok(made.then(|| store.place(&name)))
}

/// Signs the current head of the audit log.
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
            "Keep this email. To check later whether the audit log is complete and unchanged, save the lines below as a file and run\n\nweb-admin verify --statement FILE\n\n{statement}\n"
        ),
    }
}

/// Reads a statement and checks its signature. Also accepts the whole mail: everything between the
/// first and the last brace is read.
///
/// # Errors
/// Fails if the file is not a statement, was signed by another key, or was changed.
pub fn check(file: &[u8], key: &str) -> anyhow::Result<AuditHead> {
    let text = std::str::from_utf8(file).context("not a statement")?;
    let (from, to) = (text.find('{').context("not a statement")?, text.rfind('}').context("not a statement")?);
    let signed: Certificate =
        serde_json::from_str(text.get(from..=to).unwrap_or_default()).context("not a statement")?;
    let head: AuditHead = serde_json::from_str(certificate::checked_text(&signed, key)?).context("not a statement")?;
    ensure!(head.of == OF && head.format == FORMAT, "an audit checkpoint of an unknown kind or version");
    Ok(head)
}

/// Runs [`anchor`] once an hour until the future is dropped.
pub async fn run(state: Service) {
    loop {
        let state_it = async {
            if let Some(file) = anchor(&state).await? {
                tracing::info!(file, "published audit checkpoint");
            }
            Ok(())
        };
        if let Err(error) = replicas::do_duty(&state, Duty::Statements, state_it).await {
            tracing::warn!(cause = format!("{error:?}"), "failed to publish audit checkpoint");
        }
        tokio::time::sleep(EVERY).await;
    }
}
