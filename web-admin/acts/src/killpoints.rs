//! Places at which a test ends the process as a power cut would, by name. A release passes them by.

use rustix::process::{Signal, getpid, kill_process};

/// The variable that names the place.
pub const VARIABLE: &str = "STYLET_KILL_AT";

macro_rules! kill_points {
    ($($(#[$about:meta])* $point:ident = $name:literal,)+) => {
        /// A place at which the process may end.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum KillPoint {
            $($(#[$about])* $point,)+
        }

        impl KillPoint {
            /// Every place, in the order in which an attempt comes by them.
            pub const ALL: &[Self] = &[$(Self::$point),+];

            /// Its name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$point => $name,)+
                }
            }
        }
    };
}

kill_points! {
    /// The file of an upload in pieces is there, its row is not.
    UploadMade = "upload-made",
    /// A piece is written and may not be on the disk.
    PieceWritten = "piece-written",
    /// A piece is on the disk and not counted.
    PieceSynced = "piece-synced",
    /// A piece is counted and not acknowledged.
    PieceCounted = "piece-counted",
    /// It is noted that a whole upload is about to be read.
    UploadMarked = "upload-marked",
    /// It is noted that what came at once is about to be read.
    ReadingBegun = "reading-begun",
    /// A recording was read and is not in its place.
    RecordingRead = "recording-read",
    /// A recording is in its place and no row names it.
    RecordingLinked = "recording-linked",
    /// The rows of a recording are written and not committed.
    RecordingCommitting = "recording-committing",
    /// A recording is kept and not acknowledged; it lies under its old name, too.
    RecordingCommitted = "recording-committed",
    /// An upload in pieces has become an attempt, and its file is about to go.
    UploadUnlinking = "upload-unlinking",
    /// It is noted that a job is begun.
    JobBegun = "job-begun",
    /// A recording was judged and nothing of it stored.
    JobJudged = "job-judged",
    /// A score is added, and with it the grade; what pages sum up is not.
    ScoreAdded = "score-added",
    /// Everything of a score is written and not committed.
    ScoreCommitting = "score-committing",
    /// A score is stored.
    ScoreCommitted = "score-committed",
    /// A backup has its copy of the database.
    BackupCopied = "backup-copied",
    /// A backup is whole and has not its name.
    BackupWritten = "backup-written",
    /// A backup has its name.
    BackupNamed = "backup-named",
    /// A backup is unpacked, checked, and nothing of it in its place.
    RestoreUnpacked = "restore-unpacked",
    /// The recordings are in their place, the database is not.
    RestoreMoving = "restore-moving",
    /// Everything is in its place.
    RestoreMoved = "restore-moved",
    /// A move has copied the recordings, and no row.
    MoveCopied = "move-copied",
    /// A move has carried and compared every row, and keeps none of them yet.
    MoveCarried = "move-carried",
    /// A move has kept the rows, and not said so.
    MoveKept = "move-kept",
}

impl KillPoint {
    /// Ends the process where its environment names this place: nothing is flushed, nobody is told.
    pub fn pass(self) {
        if cfg!(debug_assertions) && std::env::var_os(VARIABLE).is_some_and(|wanted| wanted == self.name()) {
            // It cannot be refused: the process is our own.
            let _ = kill_process(getpid(), Signal::KILL);
        }
    }
}
