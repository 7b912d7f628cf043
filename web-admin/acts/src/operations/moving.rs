//! Moves a school from SQLite to PostgreSQL or back, optionally with its recordings.
//!
//! Recordings are copied first, while the school is served: they are the bulk of the data and
//! immutable. Then the source is locked, newer recordings are copied, all rows are copied in one
//! transaction, and everything is compared before the commit. The source is left unchanged.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Context;
use futures::{StreamExt, TryStreamExt};
use model::Moment;
use platform::config::Config;
use platform::fail_points::FailPoint;
use platform::files::hash_file;
use platform::locks::{hold_folder, name_holder};
use platform::recording_store::RecordingStore;
use store::audit;
use store::locks::{FileLock, LockError};
use store::operations::moving::{CarriedTable, DatabaseMove, MoveLock};
use store::privacy::texts::ErasedRecording;
use store::recordings::sessions::RecordingFile;

use crate::audit::checkpoint_store::STATEMENTS;
use crate::operations::key_files::KEYS;
use crate::operations::verification;
use crate::privacy::erasure_store::ErasureStore;

/// Number of recordings copied concurrently, to hide the latency of remote stores.
const AT_ONCE: usize = 4;

/// A move in progress, holding a lock on the target.
#[derive(Debug)]
pub struct SchoolMove {
    databases: DatabaseMove,
    from: Config,
    to: Config,
    source: RecordingStore,
    target: RecordingStore,
    /// Whether the recordings stay where they are.
    stays: bool,
    /// SHA-256 of each recording that has been verified in the target.
    checked: BTreeMap<String, String>,
    _target: EndLock,
}

/// Lock on the source or the target of a move, held until dropped.
#[derive(Debug)]
pub struct EndLock {
    _database: MoveLock,
    _folder: Option<FileLock>,
}

/// Result of copying recordings.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CopiedRecordings {
    /// Number of recordings that the source refers to.
    pub named: usize,
    /// Number of recordings copied by this call; the others were in the target already.
    pub copied: usize,
    /// Problems found, as text.
    pub findings: Vec<String>,
}

/// Result of a move. If there is any finding, nothing has been committed to the target's database.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MoveReport {
    /// Recordings, each verified against the hash in its row.
    pub recordings: CopiedRecordings,
    /// Tables, each identical on both sides.
    pub tables: Vec<CarriedTable>,
    /// Rows of the audit log.
    pub audit_rows: usize,
    /// Hash of its last row, hexadecimal.
    pub audit_head: String,
    /// Number of unfinished uploads dropped; clients start them again.
    pub forgotten_uploads: u64,
    /// Files in the source's data folder that are not moved.
    pub left_behind: Vec<String>,
    /// All problems found, as text.
    pub findings: Vec<String>,
}

impl SchoolMove {
    /// Locks the target and checks that the source can be moved there. Of the configurations only
    /// the data folder and the recordings are used; `databases` names the databases.
    ///
    /// # Errors
    /// Fails if the target is locked or not empty, the source has another schema version, or one of
    /// them does not respond.
    pub async fn begin(databases: DatabaseMove, from: Config, to: Config, now: Moment) -> anyhow::Result<Self> {
        let holder = name_holder("web-admin move", now);
        // A folder shared by both is locked by the source's service, which may still be running.
        let is_own = from.recordings_dir != to.recordings_dir;
        let folder = is_own.then(|| hold_folder(&to, &holder)).transpose()?;
        let held = EndLock { _database: databases.hold_target(&holder).await?, _folder: folder };
        databases.prepare().await?;
        let (source, target) = (RecordingStore::open(&from)?, RecordingStore::open(&to)?);
        for config in [&from, &to].into_iter().filter(|config| config.bucket.is_some()) {
            std::fs::create_dir_all(config.uploads_dir())?;
        }
        for store in [&source, &target] {
            store.check().await.with_context(|| store.place())?;
        }
        let stays = source.place() == target.place();
        Ok(Self { databases, from, to, source, target, stays, checked: BTreeMap::new(), _target: held })
    }

    /// Returns the source and target of the recordings as text; `None` if they stay.
    #[must_use]
    pub fn recording_places(&self) -> Option<[String; 2]> {
        (!self.stays).then(|| [self.source.place(), self.target.place()])
    }

    /// Locks the source: from now on nothing serves it or writes to it.
    ///
    /// # Errors
    /// Fails if it is locked by another process, or cannot be locked.
    pub async fn hold_source(&self, now: Moment) -> Result<EndLock, LockError> {
        let holder = name_holder("web-admin move", now);
        let database = self.databases.hold_source(&holder).await?;
        Ok(EndLock { _database: database, _folder: Some(hold_folder(&self.from, &holder)?) })
    }

    /// Copies recordings that are missing in the target and verifies those that exist: when this
    /// returns, each has been verified there once. A finding may be due to a recording erased in
    /// the meantime, as long as the source is being served.
    ///
    /// # Errors
    /// Fails if the target contains recordings of another school, does not respond or is full.
    pub async fn copy_recordings(&mut self) -> anyhow::Result<CopiedRecordings> {
        let named = self.databases.list_recordings().await?;
        let list = self.target.list().await.with_context(|| self.target.place())?;
        let there: BTreeSet<&str> = list.iter().map(String::as_str).collect();
        self.refuse_strangers(&named, &there)?;
        let is_new = |r: &&RecordingFile| self.checked.get(&r.recording_path) != Some(&r.recording_sha256);
        // Generated attempts share files; copy each file once.
        let new = named.iter().filter(is_new).map(|r| ((&*r.recording_path, &*r.recording_sha256), r));
        let new: Vec<_> = new.collect::<BTreeMap<_, _>>().into_values().collect();
        let bar = indicatif::ProgressBar::new(new.len() as u64);
        let brought = futures::stream::iter(&new).map(async |recording| {
            let brought = self.bring(recording, there.contains(&*recording.recording_path)).await;
            bar.inc(1);
            brought
        });
        let brought: Vec<Brought> = brought.buffered(AT_ONCE).try_collect().await?;
        bar.finish_and_clear();
        let mut copied = CopiedRecordings { named: named.len(), ..CopiedRecordings::default() };
        for (recording, brought) in new.iter().zip(brought) {
            copied.copied += usize::from(matches!(brought, Brought::Copied));
            match brought {
                Brought::Lost(why) => copied.findings.push(why),
                Brought::Copied | Brought::There => {
                    self.checked.insert(recording.recording_path.clone(), recording.recording_sha256.clone());
                }
            }
        }
        Ok(copied)
    }

    /// Rejects a target that contains recordings that the source does not refer to.
    fn refuse_strangers(&self, named: &[RecordingFile], there: &BTreeSet<&str>) -> anyhow::Result<()> {
        let named: BTreeSet<&str> = named.iter().map(|recording| &*recording.recording_path).collect();
        let stranger = there.iter().find(|path| !named.contains(*path) && !self.checked.contains_key(**path));
        match stranger {
            Some(path) if !self.stays => anyhow::bail!(
                "{}: unexpected {path}, not listed in {}; allowed: an empty place, or the copies of an earlier move",
                self.target.place(),
                self.databases.source()
            ),
            _ => Ok(()),
        }
    }

    /// Ensures that an intact copy of a recording is in the target.
    async fn bring(&self, recording: &RecordingFile, is_there: bool) -> anyhow::Result<Brought> {
        let RecordingFile { id, recording_path: path, recording_sha256: sha256, .. } = recording;
        let lost = |why: &dyn std::fmt::Display| Ok(Brought::Lost(format!("recording of session {id}: {path}: {why}")));
        let is_whole = is_there && self.target.hash(path).await.is_ok_and(|(found, _)| found == *sha256);
        if is_whole {
            return Ok(Brought::There);
        }
        let file = match self.source.fetch(path).await {
            Ok(file) => file,
            Err(error) => return lost(&error),
        };
        match hash_file(file.path()) {
            Ok((found, _)) if found == *sha256 => {}
            Ok(_) => return lost(&"the bytes do not match the stored hash"),
            Err(error) => return lost(&error),
        }
        if self.stays {
            return Ok(Brought::There);
        }
        let kept = self.target.keep_copy(file.path(), path, sha256).await;
        kept.with_context(|| format!("{}/{path}", self.target.place()))?;
        Ok(Brought::Copied)
    }

    /// Removes copies from the target whose recordings have been erased in the source since.
    async fn remove_erased(&self) -> anyhow::Result<()> {
        let named = self.databases.list_recordings().await?;
        let named: BTreeSet<&str> = named.iter().map(|recording| &*recording.recording_path).collect();
        let gone = self.checked.iter().filter(|(path, _)| !self.stays && !named.contains(path.as_str()));
        let gone = gone
            .map(|(path, sha256)| ErasedRecording { recording_path: path.clone(), recording_sha256: sha256.clone() });
        self.target.remove(&self.to, gone.collect()).await.with_context(|| self.target.place())
    }

    /// Copies newer recordings and all rows, compares everything, and commits if there is no
    /// finding.
    ///
    /// # Errors
    /// Fails if a database or a store does not respond or is full; the target's database is
    /// unchanged then.
    pub async fn finish(mut self, _source: &EndLock) -> anyhow::Result<MoveReport> {
        let recordings = self.copy_recordings().await?;
        self.remove_erased().await?;
        FailPoint::MoveCopied.hit();
        let mut rows = self.databases.carry().await?;
        let chain = audit::check_audit_chain(&mut *rows.target()).await?;
        let contradictions = verification::contradictions(rows.target()).await?;
        let report = MoveReport {
            findings: [&recordings.findings[..], rows.findings(), &chain.findings, &contradictions].concat(),
            recordings,
            tables: rows.tables().to_vec(),
            audit_rows: chain.rows,
            audit_head: chain.head,
            forgotten_uploads: rows.forgotten_uploads(),
            left_behind: self.list_left_behind(),
        };
        FailPoint::MoveCarried.hit();
        if report.findings.is_empty() {
            // Before the rows, so that no service runs without the erasure list.
            let erased = ErasureStore::of(&self.from, &self.source).read().await?;
            ErasureStore::of(&self.to, &self.target).merge(&erased).await?;
            rows.keep().await.with_context(|| self.databases.target())?;
            FailPoint::MoveKept.hit();
        }
        Ok(report)
    }

    /// Lists the files that the source has and the target lacks, and that must be copied by hand.
    fn list_left_behind(&self) -> Vec<String> {
        let names = KEYS.iter().map(|key| key.name).chain([STATEMENTS, "mail"]);
        let is_left = |name: &&str| self.from.data_dir.join(name).exists() && !self.to.data_dir.join(name).exists();
        let files = names.filter(is_left).map(|name| self.from.data_dir.join(name).display().to_string());
        let in_bucket = self.from.bucket.as_ref().filter(|_| !self.stays);
        files.chain(in_bucket.map(|bucket| format!("{bucket}/{STATEMENTS}"))).collect()
    }
}

/// Result for one recording.
enum Brought {
    /// It was in the target already.
    There,
    /// It was copied.
    Copied,
    /// It is missing or damaged in the source; contains the reason.
    Lost(String),
}
