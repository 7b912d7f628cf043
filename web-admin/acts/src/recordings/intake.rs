//! Accepts a recording: stores the received file with its session row, its job and its audit entry,
//! all or nothing.

use std::time::Duration;

use data_encoding::HEXLOWER;
use model::ids::{PersonId, ReaderId, RevisionId, SchoolId, SessionId, StationId, UploadId};
use model::recordings::start_time::Claim;
use model::{Moment, PersonKey, SessionKey, Uncounted, count_i64};
use platform::fail_points::FailPoint;
use platform::keys;
use platform::recording_store::RecordingStore;
use platform::scanning::ScanVerdict;
use recording::signature;
use serde_json::{Value, json};
use store::audit::{Actor, AuditEntry};
use store::authoring::exercises;
use store::operations::schools;
use store::recordings::sessions::{Session, SessionState};
use store::recordings::{parse_attempts, sessions, uploads};
use store::scoring::jobs;
use store::stations::{self, Signer};
use store::{Connection, people};

use crate::error::Error;
use crate::recordings::{Received, duplicate_backfill, quotas};
use crate::sandbox_jobs::{RecordingFacts, SandboxRequest, SandboxResponse};
use crate::service::Service;
use crate::{leases, sandbox};

/// Maximum time in the school's queue for reading.
const PATIENCE: Duration = Duration::from_secs(20);

/// The uploader of a recording.
#[derive(Clone, Debug)]
pub struct Bearer {
    /// Their school.
    pub school_id: SchoolId,
    /// The trainee who made the attempt; if absent, the person whose pseudonym is in the recording.
    pub trainee_id: Option<PersonId>,
    /// The uploading station, if any.
    pub station_id: Option<StationId>,
    /// Actor in the audit log.
    pub actor: Actor,
    /// How far the uploader's clock is ahead of the server's, in µs, if reported.
    pub ahead_us: Option<i64>,
}

/// An accepted recording.
#[derive(Debug)]
pub enum RecordingReceipt {
    /// Stored by this upload.
    Now(Session),
    /// Stored by an earlier upload of the same bytes.
    Before(Session),
}

impl RecordingReceipt {
    /// Returns the session of the recording.
    #[must_use]
    pub const fn session(&self) -> &Session {
        match self {
            Self::Now(session) | Self::Before(session) => session,
        }
    }
}

/// Stores a recording and queues it for scoring. When this returns, file and row are durable.
///
/// # Errors
/// Fails if the file is not a recording, names an unknown trainee or conflicts with stored data, or
/// if the disk or the database fails.
pub async fn take_in(state: &Service, bearer: &Bearer, received: Received) -> Result<RecordingReceipt, Error> {
    let told = read(state, bearer, &received).await?;
    FailPoint::RecordingRead.hit();
    let session = describe(state, bearer, &received, told).await?;
    keep(state, bearer, received, session).await
}

/// Reads the metadata of a recording in a helper process, in the school's queue.
async fn read(state: &Service, bearer: &Bearer, received: &Received) -> Result<RecordingFacts, Error> {
    let school = bearer.school_id;
    let _place = state.helpers.enter(school, PATIENCE).await?;
    scan(state, bearer, received).await?;
    match received.upload {
        // A resumable upload counts its attempts in its own row.
        Some(_) => have_read(state, received).await,
        None => read_counted(state, school, received).await,
    }
}

/// Scans the file, if a scanner is configured, before anything parses it. Malware is recorded in
/// the audit log, and the recording is rejected.
async fn scan(state: &Service, bearer: &Bearer, received: &Received) -> Result<(), Error> {
    let Some(scanner) = &state.config.scanner else { return Ok(()) };
    let ScanVerdict::Found(found) = scanner.scan(received.path()).await.map_err(Error::Unscanned)? else {
        return Ok(());
    };
    tracing::warn!(school = %bearer.school_id, sha256 = received.sha256, found, "malware found; recording rejected");
    let mut tx = state.db.write().await?;
    AuditEntry::new(bearer.school_id, bearer.actor.clone(), "recording.infected", &received.sha256)
        .with(json!({ "found": found, "size": received.size }))
        .append(&mut tx, state.clock.now())
        .await?;
    tx.commit().await?;
    Err(Error::Unprocessable(format!("the malware scanner has found {found} in this recording: it was discarded")))
}

/// Reads a recording uploaded in a single request. The attempt is recorded before the file is
/// opened, so that a crash counts against it.
async fn read_counted(state: &Service, school: SchoolId, received: &Received) -> Result<RecordingFacts, Error> {
    let mut tx = state.db.write().await?;
    let begun =
        parse_attempts::begin_reading(&mut tx, school, &received.sha256, state.replica, state.clock.now()).await?;
    if begun.deaths >= parse_attempts::MAX_CRASHES {
        // Dropping the transaction undoes the attempt.
        return Err(Error::Quarantined);
    }
    tx.commit().await?;
    FailPoint::ReadingBegun.hit();
    let told = have_read(state, received).await;
    let (service, died) = (state.clone(), matches!(told, Err(Error::WorkerCrashed(_))));
    let ended = leases::release("a recording that came at once", move || {
        let service = service.clone();
        async move { end_reading(&service, begun.reader, died).await }
    });
    ended.await?;
    told
}

async fn end_reading(state: &Service, reader: ReaderId, died: bool) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    parse_attempts::end_reading(&mut tx, reader, died).await?;
    Ok(tx.commit().await?)
}

async fn have_read(state: &Service, received: &Received) -> Result<RecordingFacts, Error> {
    match sandbox::ask(state, SandboxRequest::Arrival(received.path().to_owned())).await? {
        SandboxResponse::Metadata(reported) => Ok(RecordingFacts::try_from(*reported)?),
        SandboxResponse::Permanent(why) => Err(Error::Unprocessable(why)),
        SandboxResponse::Died(how) => Err(Error::WorkerCrashed(how)),
        SandboxResponse::Passing(why) => Err(anyhow::anyhow!(why).context("a recording that has just arrived").into()),
        other => Err(anyhow::anyhow!("unexpected answer to a request to read a recording: {other:?}").into()),
    }
}

async fn describe(
    state: &Service,
    bearer: &Bearer,
    received: &Received,
    told: RecordingFacts,
) -> Result<Session, Error> {
    let (school_id, received_at) = (bearer.school_id, state.clock.now());
    let trainee_id = trainee(state, bearer, &told.session.trainee).await?;
    refuse_unwanted(state, PersonKey { school_id, person_id: trainee_id }).await?;
    let revision_id = exercises::by_documents(state.db.reader(), school_id, &told.session).await?;
    let signer = signer(state, school_id, &told).await?;
    let RecordingFacts { session: named, duration_s, complete, hashes, .. } = told;
    let claim = Claim {
        began: Moment::from(named.started_at),
        duration_s,
        ahead_us: bearer.ahead_us.filter(|_| may_set_clock(bearer, signer.as_ref())),
        paired_at: signer.as_ref().map(|station| station.created_at),
    };
    let started_at = claim.believed(received_at);
    let is_given = match revision_id {
        Some(revision) => was_given(state, school_id, revision, started_at).await?,
        None => false,
    };
    Ok(Session {
        id: SessionId::from_uuid(named.session_id),
        school_id,
        trainee_id,
        exercise_id: named.exercise_id,
        exercise_sha256: named.exercise_sha256,
        scene_sha256: named.scene_sha256,
        revision_id,
        started_at,
        claimed_started_at: Some(claim.began).filter(|began| *began != started_at),
        received_at,
        duration_s,
        complete,
        device: named.device,
        simulator_version: named.simulator_version,
        seed: named.seed.to_string(),
        state: SessionState::Pending,
        refusal: None,
        recording_path: state.recordings.name_recording(
            school_id,
            SessionId::from_uuid(named.session_id),
            &received.sha256,
        ),
        recording_sha256: received.sha256.clone(),
        recording_size: count_i64(received.size),
        verify_deviation_n: None,
        verify_event_differences: None,
        verify_flagged: None,
        uncounted: (!is_given).then_some(Uncounted::Unpublished),
        motion_sha256: hashes.map(|hashes| HEXLOWER.encode(&hashes.motion)),
        repeats: None,
        signed_by: signer.map(|station| station.id),
        recording_erased_at: None,
    })
}

/// Returns whether a revision was current at the given time, or had been replaced within the
/// school's grace period before it.
async fn was_given(state: &Service, school: SchoolId, revision: RevisionId, at: Moment) -> Result<bool, Error> {
    const DAY_S: i64 = 24 * 3600;
    let reader = state.db.reader();
    let Some(replaced_at) = exercises::find_replacement_time(reader, school, revision).await? else { return Ok(true) };
    let grace_days = schools::find_school_settings(reader, school).await?.replaced_grace_days;
    Ok(at <= replaced_at.plus_s(i64::from(grace_days) * DAY_S))
}

/// Returns whether the uploader's clock may correct the start time. The time of a signed recording
/// is trusted far into the past, so only the station that signed it may do so.
fn may_set_clock(bearer: &Bearer, signer: Option<&Signer>) -> bool {
    signer.is_none_or(|signer| bearer.station_id == Some(signer.id))
}

/// Returns the trainee of an attempt. A recording with a pseudonym belongs to that person, and no
/// one else may upload it as their own.
async fn trainee(state: &Service, bearer: &Bearer, named: &str) -> Result<PersonId, Error> {
    let Some(id) = bearer.trainee_id else { return by_pseudonym(state, bearer.school_id, named).await };
    let own = people::find_person(state.db.reader(), id).await?.ok_or(Error::NotFound)?.pseudonym;
    if named.is_empty() || named == own {
        return Ok(id);
    }
    Err(Error::Conflict(format!(
        "trainee: \"{named}\"; this attempt belongs to another person: your pseudonym is \"{own}\""
    )))
}

/// Rejects a recording that must not be kept. The status code makes the station delete it.
async fn refuse_unwanted(state: &Service, trainee: PersonKey) -> Result<(), Error> {
    let consent = people::find_recording_consent(state.db.reader(), trainee).await?;
    if consent.is_erased {
        return Err(Error::Unwanted(
            "the person who made this attempt was erased: delete the recording, it is not accepted",
        ));
    }
    if consent.is_missing {
        let why = "this guest has not agreed to take part in a study, or has withdrawn: delete the recording, it is not accepted";
        return Err(Error::Unwanted(why));
    }
    Ok(())
}

/// Returns the station that signed a recording, if it is currently paired with this school and its
/// signature is valid. A signature over a recording without a trainee is ignored: any trainee could
/// upload that recording.
async fn signer(state: &Service, school: SchoolId, told: &RecordingFacts) -> Result<Option<Signer>, Error> {
    let (Some(signature), Some(hashes)) = (&told.signature, &told.hashes) else { return Ok(None) };
    if told.session.trainee.is_empty() {
        return Ok(None);
    }
    let station =
        stations::find_station_signer(state.db.reader(), school, StationId::from_uuid(signature.station)).await?;
    let signed = signature::signed_statement(&told.session, signature.station, hashes);
    Ok(station.filter(|station| keys::is_signed(&station.public_key, &signed, &signature.ed25519)))
}

async fn by_pseudonym(state: &Service, school: SchoolId, pseudonym: &str) -> Result<PersonId, Error> {
    let named = people::by_pseudonym(state.db.reader(), school, pseudonym).await?;
    named.map(|person| person.id).ok_or_else(|| {
        Error::Unprocessable(format!("trainee: \"{pseudonym}\"; nobody in this school has this pseudonym"))
    })
}

/// Uploads a new recording to the bucket, if there is one, and returns whether it did. Runs before
/// the write lock is taken, because it may take long. Two different recordings under one id get
/// different object names, and the database accepts one of them.
async fn send_ahead(state: &Service, received: &Received, session: &Session) -> Result<bool, Error> {
    let RecordingStore::Bucket(bucket) = &state.recordings else { return Ok(false) };
    if sessions::find_session(state.db.reader(), session.school_id, session.id).await?.is_some() {
        return Ok(false);
    }
    bucket.keep_recording(received.path(), &session.recording_path, &received.sha256).await?;
    Ok(true)
}

/// Moves the file to its place in the folder, if recordings are stored in one.
async fn place_file(state: &Service, received: Received, session: &Session, sent: bool) -> Result<Received, Error> {
    match &state.recordings {
        RecordingStore::Folder(folder) => {
            let place = folder.join(&session.recording_path);
            Ok(tokio::task::spawn_blocking(move || received.place(&place).map(|()| received)).await??)
        }
        RecordingStore::Bucket(_) if sent => Ok(received),
        // `send_ahead` had found the session.
        RecordingStore::Bucket(_) => Err(anyhow::anyhow!("session {} was deleted meanwhile", session.id).into()),
    }
}

/// Moves the file to its place and stores its rows; the received file is deleted only afterwards.
/// The write lock is held across both, so that of two uploads under one id the second finds the
/// first.
async fn keep(
    state: &Service,
    bearer: &Bearer,
    received: Received,
    mut session: Session,
) -> Result<RecordingReceipt, Error> {
    let sent = send_ahead(state, &received, &session).await?;
    let mut tx = state.db.write().await?;
    let upload = received.upload;
    if let Some(existing) = sessions::find_session(&mut *tx, session.school_id, session.id).await? {
        let kept = same(existing, &session).map(RecordingReceipt::Before)?;
        note_upload(&mut tx, upload, &session).await?;
        tx.commit().await?;
        return Ok(kept);
    }
    let whose = PersonKey { school_id: session.school_id, person_id: session.trainee_id };
    quotas::ensure_person_quota(&mut *tx, state, whose, received.size).await?;
    find_repeated(state, &mut tx, &mut session).await?;
    let received = place_file(state, received, &session, sent).await?;
    FailPoint::RecordingLinked.hit();
    sessions::insert_session(&mut tx, &session).await?;
    jobs::enqueue_job(&mut tx, SessionKey { school_id: session.school_id, id: session.id }, session.received_at)
        .await?;
    AuditEntry::new(session.school_id, bearer.actor.clone(), "session.uploaded", session.id)
        .with(noted(&session))
        .append(&mut tx, session.received_at)
        .await?;
    note_upload(&mut tx, upload, &session).await?;
    FailPoint::RecordingCommitting.hit();
    tx.commit().await?;
    FailPoint::RecordingCommitted.hit();
    drop(received);
    state.jobs.notify_one();
    tracing::info!(session = %session.id, size_bytes = session.recording_size, "recording kept");
    Ok(RecordingReceipt::Now(session))
}

/// Looks for a counted attempt with the same motion. One of the two becomes a duplicate: the later
/// one, or an unsigned copy of a signed attempt. Attempts that do not count are not compared.
async fn find_repeated(state: &Service, tx: &mut Connection, session: &mut Session) -> Result<(), Error> {
    let Some(motion) = session.motion_sha256.as_deref().filter(|_| session.uncounted.is_none()) else { return Ok(()) };
    let Some(first) = sessions::find_session_of_motion(&mut *tx, session.school_id, motion).await? else {
        return Ok(());
    };
    if session.signed_by.is_some() {
        let first = sessions::find_session(&mut *tx, session.school_id, first).await?.ok_or(Error::NotFound)?;
        if first.signed_by.is_none() {
            return Ok(duplicate_backfill::mark_duplicate(state, tx, session.key(), &first).await?);
        }
    }
    (session.uncounted, session.repeats) = (Some(Uncounted::Duplicate), Some(first));
    Ok(())
}

/// Returns the audit details of an attempt.
fn noted(session: &Session) -> Value {
    let mut told = json!({ "sha256": session.recording_sha256, "complete": session.complete });
    let more = [
        ("uncounted", session.uncounted.map(|why| why.word().to_owned())),
        ("repeats", session.repeats.map(|first| first.to_string())),
        ("signed_by", session.signed_by.map(|station| station.to_string())),
        ("claimed_started_at", session.claimed_started_at.map(|claimed| claimed.to_string())),
    ];
    for (key, value) in more {
        if let Some(value) = value {
            told[key] = value.into();
        }
    }
    told
}

/// Links a resumable upload to its session, in the transaction that creates the session.
async fn note_upload(tx: &mut Connection, upload: Option<UploadId>, session: &Session) -> Result<(), Error> {
    match upload {
        Some(id) => Ok(uploads::finish_upload(tx, session.school_id, id, session.id).await?),
        None => Ok(()),
    }
}

/// Returns the stored session if the new upload is identical to it.
fn same(existing: Session, new: &Session) -> Result<Session, Error> {
    if existing.recording_sha256 != new.recording_sha256 {
        return Err(Error::Conflict(format!("session {} was already uploaded with different bytes", new.id)));
    }
    if existing.trainee_id != new.trainee_id {
        return Err(Error::Conflict(format!("session {} was already uploaded by another trainee", new.id)));
    }
    Ok(existing)
}
