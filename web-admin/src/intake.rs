//! Taking a recording in: from a file that has arrived to a row, a job and an audit entry, all or nothing.

use recording::ReadError;
use serde_json::json;
use sqlx::SqliteConnection;
use uuid::Uuid;

use crate::AppState;
use crate::domain::Moment;
use crate::error::Error;
use crate::recordings::{self, Received};
use crate::storage::audit::{Actor, Entry};
use crate::storage::scores::SessionKey;
use crate::storage::sessions::{self, Session, SessionState};
use crate::storage::{exercises, jobs, people, uploads};

/// Who brings a recording.
#[derive(Clone, Debug)]
pub struct Bearer {
    /// Their school.
    pub school_id: Uuid,
    /// Whose attempt it is; where absent, whoever the recording names by pseudonym.
    pub trainee_id: Option<Uuid>,
    /// For the audit log.
    pub actor: Actor,
}

/// A recording that is kept.
#[derive(Debug)]
pub enum Kept {
    /// Since now.
    Now(Session),
    /// Since before: these were the same bytes.
    Before(Session),
}

impl Kept {
    /// The session that it is.
    #[must_use]
    pub const fn session(&self) -> &Session {
        match self {
            Self::Now(session) | Self::Before(session) => session,
        }
    }
}

/// Keeps a recording and queues it. When this returns, file and row are on the disk.
///
/// # Errors
/// When it is no recording, names a trainee who does not exist, contradicts what is stored, or the disk refuses.
pub async fn take_in(state: &AppState, bearer: &Bearer, received: Received) -> Result<Kept, Error> {
    let told = read(state, &received).await?;
    let session = describe(state, bearer, &received, told).await?;
    keep(state, bearer, received, session).await
}

/// What a recording says of itself.
struct Told {
    session: recording::Session,
    duration_s: f64,
    complete: bool,
}

async fn read(state: &AppState, received: &Received) -> Result<Told, Error> {
    let told = recordings::with(state, received.path().to_owned(), |recording| Told {
        duration_s: recording.samples.last().map_or(0.0, |sample| sample.t_s),
        complete: recording.complete,
        session: recording.session,
    });
    told.await?.map_err(|error| match error {
        ReadError::Io(error) => error.into(),
        unreadable => Error::Unprocessable(unreadable.to_string()),
    })
}

async fn describe(state: &AppState, bearer: &Bearer, received: &Received, told: Told) -> Result<Session, Error> {
    let Told { session: named, duration_s, complete } = told;
    let (reader, school_id) = (state.db.reader(), bearer.school_id);
    let trainee_id = match bearer.trainee_id {
        Some(id) => id,
        None => by_pseudonym(state, school_id, &named.trainee).await?,
    };
    let revision_id = exercises::by_documents(reader, school_id, &named.exercise_sha256, &named.scene_sha256).await?;
    Ok(Session {
        id: named.session_id,
        school_id,
        trainee_id,
        exercise_id: named.exercise_id,
        exercise_sha256: named.exercise_sha256,
        scene_sha256: named.scene_sha256,
        revision_id,
        started_at: Moment::from(named.started_at),
        received_at: state.clock.now(),
        duration_s,
        complete,
        device: named.device,
        simulator_version: named.simulator_version,
        seed: named.seed.to_string(),
        state: SessionState::Pending,
        refusal: None,
        recording_path: format!("{school_id}/{}.mcap", named.session_id),
        recording_sha256: received.sha256.clone(),
        recording_size: i64::try_from(received.size).unwrap_or(i64::MAX),
        verify_deviation_n: None,
        verify_event_differences: None,
        verify_flagged: None,
    })
}

async fn by_pseudonym(state: &AppState, school: Uuid, pseudonym: &str) -> Result<Uuid, Error> {
    let named = people::by_pseudonym(state.db.reader(), school, pseudonym).await?;
    named.map(|person| person.id).ok_or_else(|| {
        Error::Unprocessable(format!("trainee: \"{pseudonym}\"; nobody in this school has this pseudonym"))
    })
}

/// Puts the file into its place and stores what tells of it; only then does it go from where it arrived. The write lock is
/// held across both, so that of two uploads under one id the second finds the first.
async fn keep(state: &AppState, bearer: &Bearer, received: Received, session: Session) -> Result<Kept, Error> {
    let mut tx = state.db.write().await?;
    let upload = received.upload;
    if let Some(existing) = sessions::find(&mut *tx, session.school_id, session.id).await? {
        let kept = same(existing, &session).map(Kept::Before)?;
        note_upload(&mut tx, upload, &session).await?;
        tx.commit().await?;
        return Ok(kept);
    }
    let place = state.config.recordings_dir.join(&session.recording_path);
    let received = tokio::task::spawn_blocking(move || received.place(&place).map(|()| received)).await??;
    sessions::insert(&mut tx, &session).await?;
    jobs::enqueue(&mut tx, SessionKey { school_id: session.school_id, id: session.id }, session.received_at).await?;
    Entry::new(session.school_id, bearer.actor.clone(), "session.uploaded", session.id)
        .with(json!({ "sha256": session.recording_sha256, "complete": session.complete }))
        .append(&mut tx, session.received_at)
        .await?;
    note_upload(&mut tx, upload, &session).await?;
    tx.commit().await?;
    drop(received);
    state.jobs.notify_one();
    tracing::info!(session = %session.id, size_bytes = session.recording_size, "recording kept");
    Ok(Kept::Now(session))
}

/// Says in the row of an upload in pieces what it has become, in the transaction that makes it so.
async fn note_upload(tx: &mut SqliteConnection, upload: Option<Uuid>, session: &Session) -> Result<(), Error> {
    match upload {
        Some(id) => Ok(uploads::finish(tx, session.school_id, id, session.id).await?),
        None => Ok(()),
    }
}

/// The stored session, when the new upload is the very same.
fn same(existing: Session, new: &Session) -> Result<Session, Error> {
    if existing.recording_sha256 != new.recording_sha256 {
        return Err(Error::Conflict(format!("session {} was uploaded before with other bytes", new.id)));
    }
    if existing.trainee_id != new.trainee_id {
        return Err(Error::Conflict(format!("session {} was uploaded before by another trainee", new.id)));
    }
    Ok(existing)
}
