//! Learning record stores of schools, consents to them, and statements that are sent to them.

use model::ids::{OverrideId, PersonId, RecordStoreId, SchoolId, ScoreId};
use model::training::learning_records::RecordStoreSettings;
use model::{Moment, PersonKey, Role, SessionKey, count_u32};
use serde_json::Value;
use sqlx::FromRow;
use uuid::Uuid;

use crate::{Connection, Executor, Json, Result};

/// A learning record store.
#[derive(Clone, Debug)]
pub struct RecordStore {
    /// Id.
    pub id: RecordStoreId,
    /// School.
    pub school_id: SchoolId,
    /// Settings.
    pub settings: RecordStoreSettings,
    /// Password, encrypted.
    pub sealed_password: Vec<u8>,
    /// Why it refuses this service; then nothing is sent.
    pub refusal: Option<String>,
}

#[derive(FromRow)]
struct StoreRow {
    id: RecordStoreId,
    school_id: SchoolId,
    endpoint: String,
    user_name: String,
    password_sealed: Vec<u8>,
    version: String,
    ground: Option<String>,
    names: bool,
    refusal: Option<String>,
}

impl From<StoreRow> for RecordStore {
    fn from(row: StoreRow) -> Self {
        let StoreRow { endpoint, user_name, version, ground, names, .. } = row;
        Self {
            id: row.id,
            school_id: row.school_id,
            settings: RecordStoreSettings { endpoint, user_name, version, ground, names },
            sealed_password: row.password_sealed,
            refusal: row.refusal,
        }
    }
}

macro_rules! select_stores {
    ($rest:literal) => {
        concat!(
            "SELECT id, school_id, endpoint, user_name, password_sealed, version, ground, names, refusal
             FROM record_stores ",
            $rest
        )
    };
}

/// Returns the store that a school uses.
pub async fn find_record_store(executor: impl Executor<'_>, school: SchoolId) -> Result<Option<RecordStore>> {
    let row: Option<StoreRow> = sqlx::query_as(select_stores!("WHERE school_id = $1 AND disabled_at IS NULL"))
        .bind(school)
        .fetch_optional(executor)
        .await?;
    Ok(row.map(RecordStore::from))
}

/// Returns the stores of all schools that have due statements and do not refuse this service.
pub async fn list_due_stores(executor: impl Executor<'_>, now: Moment) -> Result<Vec<RecordStore>> {
    let rows: Vec<StoreRow> = sqlx::query_as(select_stores!(
        "r WHERE r.disabled_at IS NULL AND r.refused_at IS NULL AND EXISTS (SELECT 1 FROM statements s
           WHERE s.store_id = r.id AND s.state = 'waiting' AND s.next_run_at <= $1) ORDER BY r.id"
    ))
    .bind(now)
    .fetch_all(executor)
    .await?;
    Ok(rows.into_iter().map(RecordStore::from).collect())
}

/// Adds a store, or changes the one with this id. The school must use no other one.
pub async fn put_record_store(writer: &mut Connection, store: &RecordStore, now: Moment) -> Result<()> {
    let RecordStoreSettings { endpoint, user_name, version, ground, names } = &store.settings;
    sqlx::query(
        "INSERT INTO record_stores (id, school_id, endpoint, user_name, password_sealed, version, ground, names, made_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9)
         ON CONFLICT (id) DO UPDATE SET endpoint = excluded.endpoint, user_name = excluded.user_name,
           password_sealed = excluded.password_sealed, version = excluded.version, ground = excluded.ground,
           names = excluded.names, refused_at = NULL, refusal = NULL
         WHERE record_stores.school_id = excluded.school_id",
    )
    .bind(store.id)
    .bind(store.school_id)
    .bind(endpoint)
    .bind(user_name)
    .bind(&store.sealed_password)
    .bind(version)
    .bind(ground)
    .bind(names)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Stops using a store, and deletes the statements that were not sent.
pub async fn disable_record_store(
    writer: &mut Connection,
    school: SchoolId,
    id: RecordStoreId,
    now: Moment,
) -> Result<()> {
    sqlx::query("DELETE FROM statements WHERE school_id = $1 AND store_id = $2 AND state <> 'sent'")
        .bind(school)
        .bind(id)
        .execute(&mut *writer)
        .await?;
    sqlx::query("UPDATE record_stores SET disabled_at = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .bind(now)
        .execute(writer)
        .await
        .map(drop)
}

/// Records that a store refuses this service; with `None`, that it is to be tried again.
pub async fn set_refusal(writer: &mut Connection, id: RecordStoreId, refusal: Option<&str>, now: Moment) -> Result<()> {
    sqlx::query("UPDATE record_stores SET refusal = $2, refused_at = $3 WHERE id = $1")
        .bind(id)
        .bind(refusal)
        .bind(refusal.map(|_| now))
        .execute(writer)
        .await
        .map(drop)
}

/// Returns whether statements about a person may be sent to a store: the school names a legal
/// ground, or the person has consented. Only trainees are sent.
pub async fn may_send(executor: impl Executor<'_>, store: &RecordStore, person: PersonId) -> Result<bool> {
    sqlx::query_scalar(
        "SELECT EXISTS (SELECT 1 FROM people p WHERE p.school_id = $1 AND p.id = $2 AND p.role = $3 AND p.erased_at IS NULL
           AND ($4 OR EXISTS (SELECT 1 FROM record_consents c WHERE c.school_id = $1 AND c.person_id = $2
             AND c.store_id = $5 AND c.withdrawn_at IS NULL)))",
    )
    .bind(store.school_id)
    .bind(person)
    .bind(Role::Trainee)
    .bind(store.settings.ground.is_some())
    .bind(store.id)
    .fetch_one(executor)
    .await
}

/// Records that a person consents to a store. Has no effect if they have consented already.
pub async fn add_consent(
    writer: &mut Connection,
    person: PersonKey,
    store: RecordStoreId,
    wording: &str,
    now: Moment,
) -> Result<bool> {
    sqlx::query(
        "INSERT INTO record_consents (id, school_id, person_id, store_id, wording, given_at)
         VALUES ($1, $2, $3, $4, $5, $6) ON CONFLICT DO NOTHING",
    )
    .bind(model::ids::new_id(now))
    .bind(person.school_id)
    .bind(person.person_id)
    .bind(store)
    .bind(wording)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Withdraws all consents of a person, and deletes their statements that were not sent. Returns
/// whether there was a consent.
pub async fn withdraw_consents(writer: &mut Connection, person: PersonKey, now: Moment) -> Result<bool> {
    delete_unsent_statements(writer, person).await?;
    sqlx::query(
        "UPDATE record_consents SET withdrawn_at = $3 WHERE school_id = $1 AND person_id = $2 AND withdrawn_at IS NULL",
    )
    .bind(person.school_id)
    .bind(person.person_id)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() > 0)
}

/// Deletes the statements about a person that were not sent.
pub async fn delete_unsent_statements(writer: &mut Connection, person: PersonKey) -> Result<()> {
    sqlx::query("DELETE FROM statements WHERE school_id = $1 AND person_id = $2 AND state <> 'sent'")
        .bind(person.school_id)
        .bind(person.person_id)
        .execute(writer)
        .await
        .map(drop)
}

/// Counts the statements about a person that were sent.
pub async fn count_sent_statements(executor: impl Executor<'_>, person: PersonKey) -> Result<u32> {
    let sent: i64 = sqlx::query_scalar(
        "SELECT count(*) FROM statements WHERE school_id = $1 AND person_id = $2 AND state = 'sent'",
    )
    .bind(person.school_id)
    .bind(person.person_id)
    .fetch_one(executor)
    .await?;
    Ok(count_u32(sent))
}

/// Marks the statements about a person as those of an erased person. Returns their number.
pub async fn mark_erased(writer: &mut Connection, person: PersonKey) -> Result<u64> {
    sqlx::query("UPDATE statements SET person_erased = TRUE WHERE school_id = $1 AND person_id = $2")
        .bind(person.school_id)
        .bind(person.person_id)
        .execute(writer)
        .await
        .map(|done| done.rows_affected())
}

/// Returns the ids of the statements about erased people that were sent, oldest first.
pub async fn list_statements_of_erased(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<Uuid>> {
    sqlx::query_scalar("SELECT id FROM statements WHERE school_id = $1 AND person_erased ORDER BY made_at, id")
        .bind(school)
        .fetch_all(executor)
        .await
}

/// A statement to be sent.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct WaitingStatement {
    /// Id.
    pub id: Uuid,
    /// The statement.
    pub body: Json<Value>,
    /// Number of tries so far.
    #[sqlx(try_from = "i64")]
    pub tries: u32,
}

/// Queues a statement, unless it was queued before.
pub async fn add_statement(
    writer: &mut Connection,
    store: RecordStoreId,
    person: PersonKey,
    statement: &Value,
    now: Moment,
) -> Result<()> {
    let id = statement["id"].as_str().and_then(|id| id.parse::<Uuid>().ok()).unwrap_or_default();
    sqlx::query(
        "INSERT INTO statements (store_id, id, school_id, person_id, body, state, next_run_at, made_at)
         VALUES ($1, $2, $3, $4, $5, 'waiting', $6, $6) ON CONFLICT DO NOTHING",
    )
    .bind(store)
    .bind(id)
    .bind(person.school_id)
    .bind(person.person_id)
    .bind(Json(statement))
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns whether a statement was queued for a store.
pub async fn is_queued(executor: impl Executor<'_>, store: RecordStoreId, id: Uuid) -> Result<bool> {
    sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM statements WHERE store_id = $1 AND id = $2)")
        .bind(store)
        .bind(id)
        .fetch_one(executor)
        .await
}

/// Returns the next due statements of a store.
pub async fn list_due_statements(
    executor: impl Executor<'_>,
    store: RecordStoreId,
    now: Moment,
    most: u32,
) -> Result<Vec<WaitingStatement>> {
    sqlx::query_as(
        "SELECT id, body, tries FROM statements WHERE store_id = $1 AND state = 'waiting' AND next_run_at <= $2
         ORDER BY next_run_at LIMIT $3",
    )
    .bind(store)
    .bind(now)
    .bind(i64::from(most))
    .fetch_all(executor)
    .await
}

/// What became of a try to send a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatementResult<'a> {
    /// The store has it.
    Sent,
    /// The store refuses it, with this answer.
    Refused(&'a str),
    /// It is tried again at a time, after this answer.
    Again(Moment, &'a str),
}

/// Records what became of statements. Those that were deleted in the meantime are left out.
pub async fn settle_statements(
    writer: &mut Connection,
    store: RecordStoreId,
    ids: &[Uuid],
    result: StatementResult<'_>,
    now: Moment,
) -> Result<()> {
    let (state, answer, next) = match result {
        StatementResult::Sent => ("sent", None, now),
        StatementResult::Refused(answer) => ("stopped", Some(answer), now),
        StatementResult::Again(at, answer) => ("waiting", Some(answer), at),
    };
    for id in ids {
        sqlx::query(
            "UPDATE statements SET state = $3, body = CASE WHEN $6 IS NULL THEN body END, tries = tries + 1,
               next_run_at = $4, last_answer = $5, sent_at = $6
             WHERE store_id = $1 AND id = $2 AND state = 'waiting'",
        )
        .bind(store)
        .bind(id)
        .bind(state)
        .bind(next)
        .bind(answer)
        .bind((result == StatementResult::Sent).then_some(now))
        .execute(&mut *writer)
        .await?;
    }
    Ok(())
}

/// Makes all unsent statements of a store due.
pub async fn retry_statements(writer: &mut Connection, store: RecordStoreId, now: Moment) -> Result<()> {
    sqlx::query(
        "UPDATE statements SET state = 'waiting', next_run_at = $2, tries = 0 WHERE store_id = $1 AND state <> 'sent'",
    )
    .bind(store)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Number of statements of a store in a state.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct StatementCount {
    /// `waiting`, `sent` or `stopped`.
    pub state: String,
    /// Number.
    pub number: i64,
}

/// Counts the statements of a store by state.
pub async fn count_statements(executor: impl Executor<'_>, store: &RecordStore) -> Result<Vec<StatementCount>> {
    sqlx::query_as(
        "SELECT state, count(*) AS number FROM statements WHERE school_id = $1 AND store_id = $2 GROUP BY state",
    )
    .bind(store.school_id)
    .bind(store.id)
    .fetch_all(executor)
    .await
}

/// A statement that a store refuses.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct StoppedStatement {
    /// Id.
    pub id: Uuid,
    /// Last answer of the store.
    pub last_answer: String,
    /// Time at which it was queued.
    pub made_at: Moment,
}

/// Returns the newest stopped statements of a store.
pub async fn list_stopped_statements(
    executor: impl Executor<'_>,
    store: &RecordStore,
    most: u32,
) -> Result<Vec<StoppedStatement>> {
    sqlx::query_as(
        "SELECT id, coalesce(last_answer, '') AS last_answer, made_at FROM statements
         WHERE school_id = $1 AND store_id = $2 AND state = 'stopped' ORDER BY made_at DESC LIMIT $3",
    )
    .bind(store.school_id)
    .bind(store.id)
    .bind(i64::from(most))
    .fetch_all(executor)
    .await
}

/// Facts about an attempt, for its statements.
#[derive(Clone, Debug, FromRow)]
pub struct AttemptFacts {
    /// The trainee.
    pub trainee_id: PersonId,
    /// Pseudonym of the trainee.
    pub pseudonym: String,
    /// Name of the trainee.
    pub display_name: String,
    /// Exercise.
    pub exercise_id: String,
    /// SHA-256 of the exercise.
    pub exercise_sha256: String,
    /// Title of the exercise, if it is published.
    pub title: Option<String>,
    /// Start time.
    pub started_at: Moment,
    /// Length of the recording, in s.
    pub duration_s: f64,
    /// Whether the recording was finished.
    pub complete: bool,
    /// Whether the attempt counts.
    pub counts: bool,
}

/// Returns the facts about an attempt.
pub async fn find_attempt_facts(executor: impl Executor<'_>, session: SessionKey) -> Result<AttemptFacts> {
    sqlx::query_as(
        "SELECT s.trainee_id, p.pseudonym, p.display_name, s.exercise_id, s.exercise_sha256, r.title, s.started_at,
           s.duration_s, s.complete, s.uncounted IS NULL AS counts
         FROM sessions s JOIN people p ON p.school_id = s.school_id AND p.id = s.trainee_id
         LEFT JOIN exercise_revisions r ON r.school_id = s.school_id AND r.id = s.revision_id
         WHERE s.school_id = $1 AND s.id = $2",
    )
    .bind(session.school_id)
    .bind(session.id)
    .fetch_one(executor)
    .await
}

/// Returns the first score of an attempt.
pub async fn find_first_score(executor: impl Executor<'_>, session: SessionKey) -> Result<Option<ScoreId>> {
    sqlx::query_scalar(
        "SELECT id FROM scores WHERE school_id = $1 AND session_id = $2 ORDER BY computed_at, id LIMIT 1",
    )
    .bind(session.school_id)
    .bind(session.id)
    .fetch_optional(executor)
    .await
}

/// Returns the override that an entry of an attempt replaces or withdraws, if there is one.
pub async fn find_override_before(
    executor: impl Executor<'_>,
    session: SessionKey,
    entry: OverrideId,
) -> Result<Option<OverrideId>> {
    sqlx::query_scalar(
        "SELECT o.id FROM (SELECT id, score FROM score_overrides WHERE school_id = $1 AND session_id = $2 AND id <> $3
           ORDER BY made_at DESC, id DESC LIMIT 1) o WHERE o.score IS NOT NULL",
    )
    .bind(session.school_id)
    .bind(session.id)
    .bind(entry)
    .fetch_optional(executor)
    .await
}
