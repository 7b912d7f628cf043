//! A school moves from SQLite to PostgreSQL or back, and its recordings to another place with it.
//!
//! Recordings go first, while the school is served: they are most of it, and never change. Then the source is held, what has come
//! meanwhile is copied, every row is carried in one transaction, and all of it is compared before it is kept. The source stays as it is.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Context;
use futures::{StreamExt, TryStreamExt};
use model::Moment;
use store::audit;
use store::locks::{FileLock, LockError};
use store::moving::{CarriedTable, DatabaseMove, MoveLock};
use store::sessions::RecordingFile;
use store::texts::ErasedRecording;

use crate::config::Config;
use crate::erasure_store::ErasureStore;
use crate::key_files::KEYS;
use crate::killpoints::KillPoint;
use crate::locks::{hold_folder, name_holder};
use crate::recording_files::hash_file;
use crate::recording_store::RecordingStore;
use crate::statement_store::STATEMENTS;
use crate::verification;

/// Recordings that are copied at once: a store in the network takes longer to answer than to take one.
const AT_ONCE: usize = 4;

/// A school on its way. Whoever has this has the target.
#[derive(Debug)]
pub struct SchoolMove {
    databases: DatabaseMove,
    from: Config,
    to: Config,
    source: RecordingStore,
    target: RecordingStore,
    /// Recordings stay where they are.
    stays: bool,
    /// SHA-256 of each recording that was seen to be in the target whole.
    checked: BTreeMap<String, String>,
    _target: EndLock,
}

/// One end of a move, held by this process until it is dropped.
#[derive(Debug)]
pub struct EndLock {
    _database: MoveLock,
    _folder: Option<FileLock>,
}

/// What became of recordings.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CopiedRecordings {
    /// Those that the source names.
    pub named: usize,
    /// Those of them that were copied now; the others were there.
    pub copied: usize,
    /// What is wrong with the others, each in words.
    pub findings: Vec<String>,
}

/// What was moved, and what is wrong with it: where anything is, nothing is in the target's database.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MoveReport {
    /// Recordings, each with the hash that its row says.
    pub recordings: CopiedRecordings,
    /// Tables, each the same on both sides.
    pub tables: Vec<CarriedTable>,
    /// Rows of the audit log.
    pub audit_rows: usize,
    /// Hash of its last row, in hexadecimal.
    pub audit_head: String,
    /// Uploads that whoever sends them begins again.
    pub forgotten_uploads: u64,
    /// Files of the source's data folder that are no part of this.
    pub left_behind: Vec<String>,
    /// What is wrong, each in words.
    pub findings: Vec<String>,
}

impl SchoolMove {
    /// Holds the target, and looks whether the source can be moved there. Of the configurations data folder and recordings count: which
    /// databases are meant the move itself says.
    ///
    /// # Errors
    /// When somebody has the target, or something is in it; when the source is no school of this version; when one does not answer.
    pub async fn begin(databases: DatabaseMove, from: Config, to: Config, now: Moment) -> anyhow::Result<Self> {
        let holder = name_holder("web-admin move", now);
        // A folder of both is the source's as long as that is served.
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

    /// Where recordings lie and where they go, in words for people; none where they stay.
    #[must_use]
    pub fn recording_places(&self) -> Option<[String; 2]> {
        (!self.stays).then(|| [self.source.place(), self.target.place()])
    }

    /// Holds the source: nobody serves it, or writes to it, from now on.
    ///
    /// # Errors
    /// When somebody has it, or it cannot be held.
    pub async fn hold_source(&self, now: Moment) -> Result<EndLock, LockError> {
        let holder = name_holder("web-admin move", now);
        let database = self.databases.hold_source(&holder).await?;
        Ok(EndLock { _database: database, _folder: Some(hold_folder(&self.from, &holder)?) })
    }

    /// Copies recordings that are not in the target, and reads those that are: each was seen whole there once when this returns. What is
    /// found wrong with the source may have been erased meanwhile, as long as it is served.
    ///
    /// # Errors
    /// When the target holds recordings of another school, does not answer or has no room.
    pub async fn copy_recordings(&mut self) -> anyhow::Result<CopiedRecordings> {
        let named = self.databases.list_recordings().await?;
        let list = self.target.list().await.with_context(|| self.target.place())?;
        let there: BTreeSet<&str> = list.iter().map(String::as_str).collect();
        self.refuse_strangers(&named, &there)?;
        let is_new = |r: &&RecordingFile| self.checked.get(&r.recording_path) != Some(&r.recording_sha256);
        // Each file once: attempts that were generated share one.
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

    /// Refuses a target with recordings that are not those of the source.
    fn refuse_strangers(&self, named: &[RecordingFile], there: &BTreeSet<&str>) -> anyhow::Result<()> {
        let named: BTreeSet<&str> = named.iter().map(|recording| &*recording.recording_path).collect();
        let stranger = there.iter().find(|path| !named.contains(*path) && !self.checked.contains_key(**path));
        match stranger {
            Some(path) if !self.stays => anyhow::bail!(
                "{}: {path} is there, which {} does not name; allowed is a place that is empty, or what an earlier move has copied",
                self.target.place(),
                self.databases.source()
            ),
            _ => Ok(()),
        }
    }

    /// Has a recording be in the target, whole.
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
            Ok(_) => return lost(&"its bytes are not those that were stored"),
            Err(error) => return lost(&error),
        }
        if self.stays {
            return Ok(Brought::There);
        }
        let kept = self.target.keep_copy(file.path(), path, sha256).await;
        kept.with_context(|| format!("{}/{path}", self.target.place()))?;
        Ok(Brought::Copied)
    }

    /// Removes from the target what was copied and has been erased in the source since.
    async fn remove_erased(&self) -> anyhow::Result<()> {
        let named = self.databases.list_recordings().await?;
        let named: BTreeSet<&str> = named.iter().map(|recording| &*recording.recording_path).collect();
        let gone = self.checked.iter().filter(|(path, _)| !self.stays && !named.contains(path.as_str()));
        let gone = gone
            .map(|(path, sha256)| ErasedRecording { recording_path: path.clone(), recording_sha256: sha256.clone() });
        self.target.remove(&self.to, gone.collect()).await.with_context(|| self.target.place())
    }

    /// Copies what recordings have come since, carries the rows, compares everything, and keeps it where nothing is found.
    ///
    /// # Errors
    /// When a database or a store does not answer, or has no room; nothing is in the target's database then.
    pub async fn finish(mut self, _source: &EndLock) -> anyhow::Result<MoveReport> {
        let recordings = self.copy_recordings().await?;
        self.remove_erased().await?;
        KillPoint::MoveCopied.pass();
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
        KillPoint::MoveCarried.pass();
        if report.findings.is_empty() {
            // Before the rows: whoever serves them has the list.
            let erased = ErasureStore::of(&self.from, &self.source).read().await?;
            ErasureStore::of(&self.to, &self.target).merge(&erased).await?;
            rows.keep().await.with_context(|| self.databases.target())?;
            KillPoint::MoveKept.pass();
        }
        Ok(report)
    }

    /// What the source has, the target has not, and nothing but a copy by hand brings there.
    fn list_left_behind(&self) -> Vec<String> {
        let names = KEYS.iter().map(|key| key.name).chain([STATEMENTS, "mail"]);
        let is_left = |name: &&str| self.from.data_dir.join(name).exists() && !self.to.data_dir.join(name).exists();
        let files = names.filter(is_left).map(|name| self.from.data_dir.join(name).display().to_string());
        let in_bucket = self.from.bucket.as_ref().filter(|_| !self.stays);
        files.chain(in_bucket.map(|bucket| format!("{bucket}/{STATEMENTS}"))).collect()
    }
}

/// What became of a recording.
enum Brought {
    /// It was in the target.
    There,
    /// It is now.
    Copied,
    /// It is not, in words: the source has not the bytes that it should have.
    Lost(String),
}
