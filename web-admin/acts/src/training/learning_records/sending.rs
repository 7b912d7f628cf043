//! Sends statements to learning record stores, at most 50 in a request. A store that receives a
//! statement twice keeps it once, so that a request is repeated after a crash.

use data_encoding::BASE64;
use model::sending::{retry_delay_s, shorten_answer};
use platform::outgoing::{Answer, Call, CallFailed, Content};
use platform::sealing;
use serde_json::Value;
use store::training::learning_records::{self, RecordStore, StatementResult, WaitingStatement};
use uuid::Uuid;

use crate::error::{Error, error_chain};
use crate::replicas::{self, Duty};
use crate::service::Service;

/// Maximum number of statements in a request.
const BATCH: u32 = 50;

/// Sends due statements until the future is dropped, which may happen at any time.
pub async fn run(service: Service) {
    loop {
        if let Err(error) = replicas::do_duty(&service, Duty::LearningRecords, send_due(&service)).await {
            tracing::warn!(cause = error_chain(&error), "failed to send statements");
        }
        tokio::time::sleep(service.db.listening_period()).await;
    }
}

/// Sends all due statements.
///
/// # Errors
/// Fails if the database or the key fails. What a store answers is no error.
pub async fn send_due(service: &Service) -> Result<(), Error> {
    let stores = learning_records::list_due_stores(service.db.reader(), service.clock.now()).await?;
    for store in stores {
        loop {
            let now = service.clock.now();
            let due = learning_records::list_due_statements(service.db.reader(), store.id, now, BATCH).await?;
            if due.is_empty() || !send_batch(service, &store, due).await? {
                break;
            }
        }
    }
    Ok(())
}

/// Sends statements in one request, and in halves what is refused. Returns false if the store is not
/// to be asked again for now.
async fn send_batch(service: &Service, store: &RecordStore, due: Vec<WaitingStatement>) -> Result<bool, Error> {
    let mut batches = vec![due];
    while let Some(mut batch) = batches.pop() {
        let answer = post(service, store, &batch).await?;
        if matches!(answer, Err(CallFailed::TooMany)) {
            // Nothing was tried.
            return Ok(false);
        }
        let outcome = BatchOutcome::of(answer);
        if matches!(outcome, BatchOutcome::Refused(_)) && batch.len() > 1 {
            batches.push(batch.split_off(batch.len() / 2));
            batches.push(batch);
            continue;
        }
        settle(service, store, &batch, &outcome).await?;
        if matches!(outcome, BatchOutcome::Again(_) | BatchOutcome::NotAdmitted(_)) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// What a store has answered to a request.
#[derive(Debug, PartialEq, Eq)]
enum BatchOutcome {
    /// It has the statements.
    Taken,
    /// It refuses at least one of the statements.
    Refused(String),
    /// It may take them later.
    Again(String),
    /// It refuses this service, or is no learning record store.
    NotAdmitted(String),
}

impl BatchOutcome {
    fn of(answer: Result<Answer, CallFailed>) -> Self {
        match answer {
            Err(why) => Self::Again(why.to_string()),
            Ok(answer) => {
                let text = format!("{} {}", answer.status, shorten_answer(&answer.body));
                match answer.status {
                    200..300 => Self::Taken,
                    400 | 409 | 413 | 422 => Self::Refused(text),
                    300..400 | 401..=407 | 410 => Self::NotAdmitted(text),
                    _ => Self::Again(text),
                }
            }
        }
    }
}

async fn post(
    service: &Service,
    store: &RecordStore,
    batch: &[WaitingStatement],
) -> Result<Result<Answer, CallFailed>, Error> {
    let password = sealing::open(&service.config.keys_dir, store.id.uuid().as_bytes(), &store.sealed_password)?;
    let user = format!("{}:", store.settings.user_name);
    let credentials = [user.as_bytes(), &password].concat();
    let statements: Vec<&Value> = batch.iter().map(|statement| &statement.body.0).collect();
    let content =
        Content { media_type: "application/json", body: serde_json::to_vec(&statements).map_err(anyhow::Error::from)? };
    let address = format!("{}/statements", store.settings.endpoint.trim_end_matches('/'));
    let url = match service.outgoing.rules().check(&address) {
        Ok(url) => url,
        Err(why) => return Ok(Err(why)),
    };
    if let Err(why) = service.outgoing.count_service_request(store.school_id, &url) {
        return Ok(Err(why));
    }
    let call = Call::post(url, content)
        .with_authorization(Some(format!("Basic {}", BASE64.encode(&credentials))))
        .with_header("X-Experience-API-Version", store.settings.version.clone());
    Ok(service.outgoing.send(call).await)
}

async fn settle(
    service: &Service,
    store: &RecordStore,
    batch: &[WaitingStatement],
    outcome: &BatchOutcome,
) -> Result<(), Error> {
    let now = service.clock.now();
    let ids: Vec<Uuid> = batch.iter().map(|statement| statement.id).collect();
    let tries = batch.iter().map(|statement| statement.tries).max().unwrap_or_default();
    let result = match outcome {
        BatchOutcome::Taken => StatementResult::Sent,
        BatchOutcome::Refused(answer) => StatementResult::Refused(answer),
        BatchOutcome::Again(answer) => match retry_delay_s(tries + 1) {
            Some(delay_s) => StatementResult::Again(now.plus_s(delay_s), answer),
            None => StatementResult::Refused(answer),
        },
        BatchOutcome::NotAdmitted(answer) => StatementResult::Again(now, answer),
    };
    let mut tx = service.db.write().await?;
    learning_records::settle_statements(&mut tx, store.id, &ids, result, now).await?;
    if let BatchOutcome::NotAdmitted(answer) = outcome {
        learning_records::set_refusal(&mut tx, store.id, Some(answer), now).await?;
    }
    tx.commit().await?;
    tracing::info!(store = %store.id, statements = ids.len(), outcome = ?outcome, "statements sent");
    Ok(())
}
