//! Resumable uploads in chunks: the part of tus 1.0.0 that does not depend on HTTP. A chunk is
//! acknowledged once it is durable; a complete upload is processed like a recording uploaded in a
//! single request: [`crate::recordings::intake`].

mod append;
mod pieces;

use std::time::Duration;

pub use append::{UploadPiece, append};
use model::PersonKey;
use model::ids::UploadId;
use platform::config::UploadQuota;
use platform::fail_points::FailPoint;
use platform::upload_locks::UploadLock;
use store::audit::Actor;
use store::recordings::uploads::{Unfinished, Upload, UploadOwner};
use store::recordings::{parse_attempts, uploads};
use store::stations;

use crate::error::{Error, error_chain};
use crate::leases;
use crate::recordings::intake::Bearer;
use crate::recordings::{Received, intake, quotas};
use crate::service::Service;

/// Number of attempts of the request with the last chunk to lease an upload that another replica is
/// processing.
const LOOKS: u32 = 50;
/// Delay between two such attempts; 5 s in total.
const BETWEEN_LOOKS: Duration = Duration::from_millis(100);

/// Properties of an upload, announced when it begins.
#[derive(Clone, Debug)]
pub struct Announced {
    /// Total length, in bytes.
    pub length: u64,
    /// Value of `Upload-Metadata`.
    pub metadata: String,
    /// How far the sender's clock is ahead of the server's, in µs, if reported.
    pub ahead_us: Option<i64>,
}

/// Begins an upload.
///
/// # Errors
/// Fails if a quota is exceeded, the disk is full, or the disk or the database fails.
pub async fn begin(state: &Service, owner: UploadOwner, announced: Announced) -> Result<Upload, Error> {
    let now = state.clock.now();
    let upload = Upload {
        id: UploadId::made_at(now),
        school_id: owner.school_id,
        person_id: owner.person_id,
        station_id: owner.station_id,
        length: i64::try_from(announced.length).map_err(anyhow::Error::from)?,
        received: 0,
        metadata: announced.metadata,
        expires_at: now.plus_s(state.config.upload_lifetime_s),
        session_id: None,
        clock_offset_us: announced.ahead_us,
        deaths: 0,
    };
    // Lock the upload before its row exists, so that `tidy` does not delete the new file as a
    // leftover.
    let _turn = state.turns.take(upload.id);
    let mut tx = state.db.write().await?;
    let whole_school = UploadOwner { person_id: None, station_id: None, ..owner };
    let counted =
        [(owner, state.config.owner_quota, "you have"), (whole_school, state.config.school_quota, "this school has")];
    for (whose, quota, who) in counted {
        ensure_quota(uploads::count_unfinished_uploads(&mut *tx, whose).await?, announced.length, quota, who)?;
    }
    if let Some(person) = owner.person_id {
        let whose = PersonKey { school_id: owner.school_id, person_id: person };
        quotas::ensure_person_quota(&mut *tx, state, whose, announced.length).await?;
    }
    quotas::ensure_room(state, announced.length).await?;
    pieces::begin(state, upload.id).await?;
    FailPoint::UploadMade.hit();
    uploads::insert_upload(&mut tx, &upload).await?;
    tx.commit().await?;
    Ok(upload)
}

/// Rejects an upload beyond a quota.
fn ensure_quota(begun: Unfinished, length: u64, quota: UploadQuota, who: &str) -> Result<(), Error> {
    let Unfinished { uploads, bytes } = begun;
    let (count, sum) = (uploads.unsigned_abs() + 1, bytes.unsigned_abs().saturating_add(length));
    if count <= quota.uploads && sum <= quota.bytes {
        return Ok(());
    }
    let UploadQuota { uploads: most, bytes: most_bytes } = quota;
    Err(Error::OverQuota(format!(
        "{who} {uploads} unfinished uploads of {bytes} bytes; with this one of {length} bytes the limit of {most} uploads or {most_bytes} bytes is exceeded: finish or cancel one first"
    )))
}

/// Returns an upload that its owner may continue.
///
/// # Errors
/// Fails if it does not exist, has expired, lost its file, or is quarantined.
pub async fn find(state: &Service, owner: UploadOwner, id: UploadId) -> Result<Upload, Error> {
    let turn = take_over(state, owner, id).await?;
    // A request that does not release the lock may be moving the file to its place.
    look(state, owner, id, turn.is_some()).await
}

/// Takes the lock on an owner's upload. A request that is writing to it aborts, since its
/// connection may be dead without anyone noticing; one that is processing the complete upload does
/// not, and then there is no lock.
async fn take_over(state: &Service, owner: UploadOwner, id: UploadId) -> Result<Option<UploadLock>, Error> {
    uploads::find_upload(state.db.reader(), owner, id).await?.ok_or(Error::NotFound)?;
    Ok(state.turns.take_over(id).await)
}

/// Finds an upload; `resting` means that no other request can be moving its file.
async fn look(state: &Service, owner: UploadOwner, id: UploadId, resting: bool) -> Result<Upload, Error> {
    let upload = uploads::find_upload(state.db.reader(), owner, id).await?.ok_or(Error::NotFound)?;
    let lost = resting && upload.session_id.is_none() && pieces::is_lost(state, id).await?;
    if upload.is_set_aside() {
        return Err(Error::Quarantined);
    }
    if upload.expires_at <= state.clock.now() || lost {
        return Err(Error::Gone("this upload has expired: start another"));
    }
    Ok(upload)
}

/// Terminates an upload at its owner's request. An attempt that it has already become is kept.
///
/// # Errors
/// Fails if it is being processed, or the database fails.
pub async fn terminate(state: &Service, upload: &Upload) -> Result<(), Error> {
    let _turn = state.turns.take_over(upload.id).await.ok_or(Error::Locked)?;
    remove(state, upload).await
}

/// Turns a complete upload into an attempt. A rejected upload is deleted, since a retry cannot
/// succeed. The caller holds the upload's lock. `looks` is the number of attempts to lease an
/// upload that another replica is processing.
///
/// # Errors
/// Fails if another replica keeps processing it, the recording is rejected, or the disk or the
/// database fails; in the last case, [`tidy`] retries.
async fn complete(state: &Service, upload: Upload, looks: u32) -> Result<Upload, Error> {
    let id = upload.id;
    // Before the upload is marked as being read: a crash while collecting it is not the recording's
    // fault.
    let received = pieces::collect(state, &upload).await;
    let upload = hold_patiently(state, id, looks).await?;
    FailPoint::UploadMarked.hit();
    let taken = match (upload.session_id, received) {
        (Some(_), _) => Ok(upload),
        (None, Ok(received)) => take_in(state, upload, received).await,
        (None, Err(error)) => Err(error),
    };
    let (service, died) = (state.clone(), matches!(taken, Err(Error::WorkerCrashed(_))));
    let released = leases::release("an upload", move || {
        let service = service.clone();
        async move { release(&service, id, died).await }
    });
    if let Err(error) = released.await {
        tracing::warn!(upload = %id, cause = error_chain(&error), "failed to release the lease of an upload");
    }
    taken
}

/// Leases an upload, waiting while another replica holds it: one that found it complete at
/// start-up, or one that crashed and will soon be marked dead.
async fn hold_patiently(state: &Service, id: UploadId, looks: u32) -> Result<Upload, Error> {
    for _ in 1..looks {
        match hold(state, id).await {
            Err(Error::Locked) => tokio::time::sleep(BETWEEN_LOOKS).await,
            done => return done,
        }
    }
    hold(state, id).await
}

/// Leases an upload to read it, and returns its current row.
async fn hold(state: &Service, id: UploadId) -> Result<Upload, Error> {
    let mut tx = state.db.write().await?;
    let upload = uploads::find_upload_by_id(&mut *tx, id).await?.ok_or(Error::NotFound)?;
    if !parse_attempts::hold_upload(&mut tx, id, state.replica).await? {
        return Err(Error::Locked);
    }
    tx.commit().await?;
    Ok(upload)
}

/// Releases the lease on an upload; `died` records a crash.
async fn release(state: &Service, id: UploadId, died: bool) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    parse_attempts::release_upload(&mut tx, id, state.replica, died).await?;
    Ok(tx.commit().await?)
}

async fn take_in(state: &Service, mut upload: Upload, received: Received) -> Result<Upload, Error> {
    let bearer = bearer(state, &upload).await?;
    match intake::take_in(state, &bearer, received).await {
        Ok(kept) => {
            upload.session_id = Some(kept.session().id);
            FailPoint::UploadUnlinking.hit();
            throw_away(state, upload.id).await;
            Ok(upload)
        }
        Err(
            fault @ (Error::Internal(_)
            | Error::NoRoom(_)
            | Error::Busy { .. }
            | Error::WorkerCrashed(_)
            | Error::StoreUnavailable(_)
            | Error::DatabaseUnavailable(_)
            | Error::Unscanned(_)),
        ) => Err(fault),
        Err(refused) => {
            remove(state, &upload).await?;
            Err(refused)
        }
    }
}

/// Returns the uploader. A person's uploads are their own attempts; a station's belong to the
/// trainee named in the recording.
async fn bearer(state: &Service, upload: &Upload) -> Result<Bearer, Error> {
    let actor = match (upload.person_id, upload.station_id) {
        (Some(person), _) => Actor::Person(person),
        (None, Some(station)) => {
            let name = stations::find_station_name(state.db.reader(), upload.school_id, station).await?;
            Actor::Station(name.unwrap_or_default())
        }
        (None, None) => return Err(anyhow::anyhow!("an upload without an owner").into()),
    };
    let (trainee_id, ahead_us) = (upload.person_id, upload.clock_offset_us);
    Ok(Bearer { school_id: upload.school_id, trainee_id, station_id: upload.station_id, actor, ahead_us })
}

/// Removes expired uploads, uploads without a file and files without an upload; processes uploads
/// that were complete when the service stopped.
///
/// # Errors
/// Fails if the disk or the database fails.
pub async fn tidy(state: &Service) -> Result<(), Error> {
    for id in uploads::list_uploads(state.db.reader()).await? {
        let Some(_turn) = state.turns.take(id) else { continue };
        let Some(upload) = uploads::find_upload_by_id(state.db.reader(), id).await? else { continue };
        if upload.is_set_aside() {
            continue;
        }
        let is_lost = upload.session_id.is_none() && pieces::is_lost(state, id).await?;
        if upload.expires_at <= state.clock.now() || is_lost {
            remove(state, &upload).await?;
        } else if upload.whole() && upload.session_id.is_none() {
            match complete(state, upload, 1).await {
                Ok(_) => tracing::info!(upload = %id, "accepted a complete upload that was left over"),
                Err(Error::Locked) => tracing::debug!(upload = %id, "another replica is accepting the upload"),
                Err(error) => {
                    tracing::warn!(upload = %id, cause = error_chain(&error), "complete upload not accepted")
                }
            }
        }
    }
    pieces::clear_unknown(state).await
}

/// Removes an upload. The file goes first, which frees space for the database on a full disk. A
/// client that returns gets the response that the upload has expired.
async fn remove(state: &Service, upload: &Upload) -> Result<(), Error> {
    throw_away(state, upload.id).await;
    let mut tx = state.db.write().await?;
    uploads::remove_upload(&mut tx, upload.school_id, upload.id).await?;
    Ok(tx.commit().await?)
}

/// Deletes the bytes of an upload. A failure is only logged; they are deleted later.
async fn throw_away(state: &Service, id: UploadId) {
    if let Err(error) = pieces::remove(state, id).await {
        tracing::warn!(upload = %id, cause = error_chain(&error), "failed to delete the bytes of a finished upload");
    }
}
