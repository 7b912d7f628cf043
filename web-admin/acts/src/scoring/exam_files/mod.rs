//! Freezes an attempt for an exam board: one signed file, which later re-gradings, ratings and
//! decisions do not change.

mod gathering;

use std::fs::File;
use std::io::Read;

use bytes::Bytes;
use data_encoding::HEXLOWER;
use futures::{StreamExt, stream};
use model::ids::ExamFileId;
use model::scoring::exam_file::{ExamRecording, write_head, write_tail};
use model::training::progress::Mastery;
use model::{CurrentPerson, Needed, PersonKey, count_i64};
use serde_json::json;
use sha2::{Digest, Sha256};
use store::audit::AuditEntry;
use store::recordings::sessions::Session;
use store::scoring::exam_files;
use store::scoring::exam_files::NewExamFile;
use store::scoring::exams::{self, Sitting};

use crate::error::Error;
use crate::recordings;
use crate::recordings::Chunks;
use crate::recordings::quotas::ensure_database_room;
use crate::service::Service;
use crate::training::certificates;

/// Maximum number of exam files of one attempt.
const MOST_FILES: usize = 20;

/// Sentences of the manifest, in English.
#[derive(Clone, Copy, Debug)]
pub struct ExamWords {
    /// Describes a mastery rule.
    pub rule: fn(&Mastery) -> String,
    /// Describes the proofs that a school needs.
    pub needed: fn(Needed) -> &'static str,
}

/// Freezes a scored attempt. Returns the id of its exam file.
///
/// # Errors
/// Returns [`Error::Forbidden`] for one's own attempt, [`Error::Gone`] if the recording was erased,
/// [`Error::Conflict`] if the attempt is not scored, has too many exam files, or if the person has
/// to rate it first.
pub async fn freeze_attempt(
    service: &Service,
    by: &CurrentPerson,
    session: &Session,
    words: ExamWords,
) -> Result<ExamFileId, Error> {
    if session.trainee_id == by.id {
        return Err(Error::Forbidden(tr!("you cannot freeze your own attempt")));
    }
    refuse_open_rating(service, by, session).await?;
    ensure_database_room(service)?;
    if exam_files::list_exam_files(service.db.reader(), session.key()).await?.len() >= MOST_FILES {
        return Err(Error::Conflict(tr!("this attempt has been frozen {n} times, the maximum", n = MOST_FILES)));
    }
    let now = service.clock.now();
    let id = ExamFileId::made_at(now);
    let gathered = gathering::gather(service, by, session, words).await?;
    let manifest = gathering::manifest_of(&gathered, id, now);
    let key = certificates::signing_key(&service.config.keys_dir)?;
    let recording = ExamRecording { sha256: &session.recording_sha256, bytes: session.recording_size.unsigned_abs() };
    let head = write_head(&key, manifest, &gathered.entries, recording)?;
    let (sha256, bytes) = hash_whole(service, session, &head).await?;
    let mut tx = service.db.write().await?;
    let new = NewExamFile { id, made_by: by.id, sha256: &sha256, bytes: count_i64(bytes), head: &head };
    exam_files::add_exam_file(&mut tx, session, new, now).await?;
    let details = json!({ "exam_file": id, "sha256": sha256, "bytes": bytes });
    AuditEntry::by(by, "session.frozen", session.id).with(details).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(id)
}

/// Returns SHA-256 and length of a whole file, and checks the recording in it.
async fn hash_whole(service: &Service, session: &Session, head: &[u8]) -> Result<(String, u64), Error> {
    let recording = recordings::fetch(service, session).await?;
    let mut whole = Sha256::new_with_prefix(head);
    let (whole, own, bytes) = tokio::task::spawn_blocking(move || {
        let (mut file, mut own, mut bytes) = (File::open(recording.path())?, Sha256::new(), 0);
        let mut piece = vec![0; 1 << 16];
        loop {
            match file.read(&mut piece)? {
                0 => return std::io::Result::Ok((whole, own, bytes)),
                read => {
                    whole.update(&piece[..read]);
                    own.update(&piece[..read]);
                    bytes += read as u64;
                }
            }
        }
    })
    .await??;
    let is_whole = bytes == session.recording_size.unsigned_abs();
    if !is_whole || HEXLOWER.encode(&own.finalize()) != session.recording_sha256 {
        return Err(anyhow::anyhow!("the recording of {} does not match its stored hash", session.id).into());
    }
    let tail = write_tail(bytes);
    let bytes = head.len() as u64 + bytes + tail.len() as u64;
    Ok((HEXLOWER.encode(&whole.chain_update(tail).finalize()), bytes))
}

/// An exam file to be sent.
pub struct OpenedExamFile {
    /// Length, in bytes.
    pub bytes: u64,
    /// The content.
    pub chunks: Chunks,
}

/// Opens an exam file of an attempt.
///
/// # Errors
/// Returns [`Error::NotFound`] if the attempt has no such file, [`Error::Gone`] if its content or the
/// recording was erased, [`Error::Conflict`] if the person has to rate the attempt first.
pub async fn open_exam_file(
    service: &Service,
    by: &CurrentPerson,
    session: &Session,
    id: ExamFileId,
) -> Result<OpenedExamFile, Error> {
    let head = exam_files::find_head(service.db.reader(), session.key(), id).await?.ok_or(Error::NotFound)?;
    refuse_open_rating(service, by, session).await?;
    if head.is_empty() {
        return Err(Error::Gone(tr!("this exam file was erased with its person")));
    }
    let size = session.recording_size.unsigned_abs();
    let recording = recordings::find(service, session).await?.read_whole().await?;
    let tail = write_tail(size);
    let bytes = head.len() as u64 + size + tail.len() as u64;
    let around = |bytes: Vec<u8>| stream::once(async move { Ok(Bytes::from(bytes)) });
    Ok(OpenedExamFile { bytes, chunks: around(head).chain(recording).chain(around(tail)).boxed() })
}

/// Hides the ratings of others from a person who has to rate the attempt first: in a round, or as the second rater of
/// an exam, also before the second rating is requested.
async fn refuse_open_rating(service: &Service, by: &CurrentPerson, session: &Session) -> Result<(), Error> {
    let reader = service.db.reader();
    let candidate = PersonKey { school_id: session.school_id, person_id: session.trainee_id };
    let sittings = exams::list_sittings_of_attempt(reader, candidate, session.id).await?;
    let awaits = |sitting: &Sitting| sitting.second_rater_id == Some(by.id) && sitting.second_finished_at.is_none();
    if sittings.iter().any(awaits) || exam_files::has_open_rating(reader, session.key(), by.id).await? {
        let why = tr!("an exam file contains all ratings: finish your own rating of this attempt first");
        return Err(Error::Conflict(why.to_owned()));
    }
    Ok(())
}
