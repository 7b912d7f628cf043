//! Uploads in pieces, resumable: the part of tus 1.0.0 that is not HTTP. A piece is acknowledged when it is on the disk,
//! and the whole goes the same way as a recording that came at once: [`crate::intake`].

mod append;
mod pieces;

pub use append::{UploadPiece, append};
use std::time::Duration;

use model::PersonKey;
use model::ids::UploadId;
use store::audit::Actor;
use store::uploads::{Unfinished, Upload, UploadOwner};
use store::{stations, tries, uploads};

use crate::config::UploadQuota;
use crate::error::{Error, tell_in_full};
use crate::holds;
use crate::intake::{self, Bearer};
use crate::killpoints::KillPoint;
use crate::recordings::Received;
use crate::room;
use crate::service::Service;
use crate::turns::Turn;

/// How often whoever brings the last piece looks whether another service still takes the upload in, ...
const LOOKS: u32 = 50;
/// ... and how long between two looks: 5 s in all.
const BETWEEN_LOOKS: Duration = Duration::from_millis(100);

/// What is said of an upload when it begins.
#[derive(Clone, Debug)]
pub struct Announced {
    /// How long it will be, in bytes.
    pub length: u64,
    /// `Upload-Metadata` as it was sent.
    pub metadata: String,
    /// How far the sender's clock is ahead of ours, in µs, where it was told.
    pub ahead_us: Option<i64>,
}

/// Begins an upload.
///
/// # Errors
/// When the disk or the database refuses.
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
    // Between the file and its row, tidying must not take the one for left over.
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
        room::ensure_person_quota(&mut *tx, state, whose, announced.length).await?;
    }
    room::ensure_room(state, announced.length).await?;
    pieces::begin(state, upload.id).await?;
    KillPoint::UploadMade.pass();
    uploads::insert_upload(&mut tx, &upload).await?;
    tx.commit().await?;
    Ok(upload)
}

/// Refuses an upload beyond a quota.
fn ensure_quota(begun: Unfinished, length: u64, quota: UploadQuota, who: &str) -> Result<(), Error> {
    let Unfinished { uploads, bytes } = begun;
    let (count, sum) = (uploads.unsigned_abs() + 1, bytes.unsigned_abs().saturating_add(length));
    if count <= quota.uploads && sum <= quota.bytes {
        return Ok(());
    }
    let UploadQuota { uploads: most, bytes: most_bytes } = quota;
    Err(Error::OverQuota(format!(
        "{who} {uploads} unfinished uploads of {bytes} bytes; with this one of {length} bytes that is more than {most} uploads or \
         {most_bytes} bytes: finish or end one of them first"
    )))
}

/// An upload that its owner may go on with.
///
/// # Errors
/// When there is none, it has expired, or its file has gone.
pub async fn find(state: &Service, owner: UploadOwner, id: UploadId) -> Result<Upload, Error> {
    let turn = take_over(state, owner, id).await?;
    // Whoever keeps the turn may just be moving the file to its place.
    look(state, owner, id, turn.is_some()).await
}

/// The turn at an upload of an owner. Whoever writes to it gives way, for the connection may be dead and nobody know it; who is taking it
/// in does not, and then there is none.
async fn take_over(state: &Service, owner: UploadOwner, id: UploadId) -> Result<Option<Turn>, Error> {
    uploads::find_upload(state.db.reader(), owner, id).await?.ok_or(Error::NotFound)?;
    Ok(state.turns.take_over(id).await)
}

/// Finds an upload; `resting` where nobody else can be moving its file.
async fn look(state: &Service, owner: UploadOwner, id: UploadId, resting: bool) -> Result<Upload, Error> {
    let upload = uploads::find_upload(state.db.reader(), owner, id).await?.ok_or(Error::NotFound)?;
    let lost = resting && upload.session_id.is_none() && pieces::is_lost(state, id).await?;
    if upload.is_set_aside() {
        return Err(Error::SetAside);
    }
    if upload.expires_at <= state.clock.now() || lost {
        return Err(Error::Gone("this upload has expired: begin another"));
    }
    Ok(upload)
}

/// Ends an upload at its owner's wish. What it has become stays.
///
/// # Errors
/// When it is being taken in, or the database fails.
pub async fn terminate(state: &Service, upload: &Upload) -> Result<(), Error> {
    let _turn = state.turns.take_over(upload.id).await.ok_or(Error::Locked)?;
    remove(state, upload).await
}

/// Makes an attempt of an upload that is whole. One that is refused is forgotten: its bytes will never be better.
/// Whoever calls has the upload's turn, and says how often it is looked whether another service still does so.
///
/// # Errors
/// When another service does so all the while, the recording is refused, or the disk or the database fails; then it is tried again by [`tidy`].
async fn complete(state: &Service, upload: Upload, looks: u32) -> Result<Upload, Error> {
    let id = upload.id;
    // Before it counts as begun: who dies on the way to it has not died of it.
    let received = pieces::collect(state, &upload).await;
    let upload = hold_patiently(state, id, looks).await?;
    KillPoint::UploadMarked.pass();
    let taken = match (upload.session_id, received) {
        (Some(_), _) => Ok(upload),
        (None, Ok(received)) => take_in(state, upload, received).await,
        (None, Err(error)) => Err(error),
    };
    let (service, died) = (state.clone(), matches!(taken, Err(Error::Deadly(_))));
    let released = holds::let_go("an upload", move || {
        let service = service.clone();
        async move { release(&service, id, died).await }
    });
    if let Err(error) = released.await {
        tracing::warn!(upload = %id, cause = tell_in_full(&error), "an upload still counts as being read");
    }
    taken
}

/// Holds an upload once no other service does: one that has found it whole at its start, or one that died over it and is buried soon.
async fn hold_patiently(state: &Service, id: UploadId, looks: u32) -> Result<Upload, Error> {
    for _ in 1..looks {
        match hold(state, id).await {
            Err(Error::Locked) => tokio::time::sleep(BETWEEN_LOOKS).await,
            done => return done,
        }
    }
    hold(state, id).await
}

/// Writes down that an upload is about to be read; what has become of it by now.
async fn hold(state: &Service, id: UploadId) -> Result<Upload, Error> {
    let mut tx = state.db.write().await?;
    let upload = uploads::find_upload_by_id(&mut *tx, id).await?.ok_or(Error::NotFound)?;
    if !tries::hold_upload(&mut tx, id, state.replica).await? {
        return Err(Error::Locked);
    }
    tx.commit().await?;
    Ok(upload)
}

/// Writes down that nobody reads an upload any more; where `died`, whoever did has died of it.
async fn release(state: &Service, id: UploadId, died: bool) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    tries::release_upload(&mut tx, id, state.replica, died).await?;
    Ok(tx.commit().await?)
}

async fn take_in(state: &Service, mut upload: Upload, received: Received) -> Result<Upload, Error> {
    let bearer = bearer(state, &upload).await?;
    match intake::take_in(state, &bearer, received).await {
        Ok(kept) => {
            upload.session_id = Some(kept.session().id);
            KillPoint::UploadUnlinking.pass();
            throw_away(state, upload.id).await;
            Ok(upload)
        }
        Err(
            fault @ (Error::Internal(_)
            | Error::NoRoom(_)
            | Error::Busy { .. }
            | Error::Deadly(_)
            | Error::StoreAway(_)
            | Error::DatabaseAway(_)
            | Error::Unscanned(_)),
        ) => Err(fault),
        Err(refused) => {
            remove(state, &upload).await?;
            Err(refused)
        }
    }
}

/// Who brought it. A person's attempts are their own; a station's belong to whoever the recording names.
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

/// Removes expired uploads, uploads without a file and files without an upload; takes in uploads that were complete when the service stopped.
///
/// # Errors
/// When the disk or the database fails.
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
                Ok(_) => tracing::info!(upload = %id, "an upload that was left whole has been taken in"),
                Err(Error::Locked) => tracing::debug!(upload = %id, "another service takes it in"),
                Err(error) => {
                    tracing::warn!(upload = %id, cause = tell_in_full(&error), "an upload that is whole was not taken in")
                }
            }
        }
    }
    pieces::clear_unknown(state).await
}

/// Removes an upload. The file goes first, which frees space for the database on a full disk. A client that returns is answered that the
/// upload has expired.
async fn remove(state: &Service, upload: &Upload) -> Result<(), Error> {
    throw_away(state, upload.id).await;
    let mut tx = state.db.write().await?;
    uploads::remove_upload(&mut tx, upload.school_id, upload.id).await?;
    Ok(tx.commit().await?)
}

/// Removes the bytes of an upload that nobody needs. Where they stay, they are thrown away later.
async fn throw_away(state: &Service, id: UploadId) {
    if let Err(error) = pieces::remove(state, id).await {
        tracing::warn!(upload = %id, cause = tell_in_full(&error), "the bytes of an upload that is over are still there");
    }
}
