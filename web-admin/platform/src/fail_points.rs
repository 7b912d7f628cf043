//! Fail points: named places at which a test kills the process, as a power cut would. Release
//! builds ignore them.

use rustix::process::{Signal, getpid, kill_process};

/// Environment variable that names the active fail point.
pub const VARIABLE: &str = "STYLET_KILL_AT";

macro_rules! fail_points {
    ($($(#[$about:meta])* $point:ident = $name:literal,)+) => {
        /// A fail point.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum FailPoint {
            $($(#[$about])* $point,)+
        }

        impl FailPoint {
            /// All fail points, in the order in which an attempt passes them.
            pub const ALL: &[Self] = &[$(Self::$point),+];

            /// Returns its name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$point => $name,)+
                }
            }
        }
    };
}

fail_points! {
    /// The file of a resumable upload exists, its row does not.
    UploadMade = "upload-made",
    /// A chunk has been written but maybe not synced.
    PieceWritten = "piece-written",
    /// A chunk has been synced but not counted.
    PieceSynced = "piece-synced",
    /// A chunk has been counted but not acknowledged.
    PieceCounted = "piece-counted",
    /// A complete upload is marked as about to be read.
    UploadMarked = "upload-marked",
    /// A single-request upload is marked as about to be read.
    ReadingBegun = "reading-begun",
    /// A recording has been read but not moved to its place.
    RecordingRead = "recording-read",
    /// A recording is in place, but no row refers to it.
    RecordingLinked = "recording-linked",
    /// The rows of a recording have been written but not committed.
    RecordingCommitting = "recording-committing",
    /// A recording has been stored but not acknowledged; its file still exists under the old name,
    /// too.
    RecordingCommitted = "recording-committed",
    /// A resumable upload has become an attempt, and its file is about to be removed.
    UploadUnlinking = "upload-unlinking",
    /// A job is marked as started.
    JobBegun = "job-begun",
    /// A recording has been scored, but no result has been stored.
    JobJudged = "job-judged",
    /// The score and its grade have been inserted; the aggregates have not been updated.
    ScoreAdded = "score-added",
    /// All rows of a score have been written but not committed.
    ScoreCommitting = "score-committing",
    /// A score has been committed.
    ScoreCommitted = "score-committed",
    /// A backup has copied the database.
    BackupCopied = "backup-copied",
    /// A backup is complete but does not have its final name.
    BackupWritten = "backup-written",
    /// A backup has its final name.
    BackupNamed = "backup-named",
    /// A backup has been unpacked and verified, and nothing has been moved to its place.
    RestoreUnpacked = "restore-unpacked",
    /// The recordings are in place, the database is not.
    RestoreMoving = "restore-moving",
    /// Everything is in place.
    RestoreMoved = "restore-moved",
    /// A move has copied the recordings, but no rows.
    MoveCopied = "move-copied",
    /// A move has copied and compared all rows but not committed them.
    MoveCarried = "move-carried",
    /// A move has committed the rows but not reported it.
    MoveKept = "move-kept",
}

impl FailPoint {
    /// Kills the process if the environment names this fail point, without flushing or closing
    /// anything.
    pub fn hit(self) {
        if cfg!(debug_assertions) && std::env::var_os(VARIABLE).is_some_and(|wanted| wanted == self.name()) {
            // A process may always signal itself, so this cannot fail.
            let _ = kill_process(getpid(), Signal::KILL);
        }
    }
}
