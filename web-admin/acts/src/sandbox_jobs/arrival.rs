//! Metadata of an uploaded recording.

use std::collections::BTreeMap;

use anyhow::Context;
use recording::{AttemptHashes, Recording, Session, Signature};
use serde::{Deserialize, Serialize};

/// Metadata of an uploaded recording.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingFacts {
    /// The session described in its header.
    pub session: Session,
    /// Duration, in s.
    pub duration_s: f64,
    /// Whether the recording was ended properly.
    pub complete: bool,
    /// Hashes of the motion and of the conditions; `None` without samples.
    pub hashes: Option<AttemptHashes>,
    /// Signature of a station, if any.
    pub signature: Option<Signature>,
}

impl From<Recording> for RecordingFacts {
    fn from(recording: Recording) -> Self {
        let last = recording.samples.last();
        Self {
            duration_s: last.map_or(0.0, |sample| sample.t_s),
            complete: recording.complete,
            hashes: last.map(|_| recording.hashes()),
            signature: recording.signature,
            session: recording.session,
        }
    }
}

/// The same in the form that is passed between processes: session and signature as text fields, as
/// in the file.
#[derive(Debug, Serialize, Deserialize)]
pub struct ReportedRecording {
    session: BTreeMap<String, String>,
    duration_s: f64,
    complete: bool,
    hashes: Option<AttemptHashes>,
    signature: Option<BTreeMap<String, String>>,
}

impl TryFrom<&RecordingFacts> for ReportedRecording {
    type Error = anyhow::Error;

    fn try_from(told: &RecordingFacts) -> anyhow::Result<Self> {
        Ok(Self {
            session: told.session.to_text().context("metadata that were just read")?,
            duration_s: told.duration_s,
            complete: told.complete,
            hashes: told.hashes,
            signature: told.signature.as_ref().map(Signature::to_text),
        })
    }
}

impl TryFrom<ReportedRecording> for RecordingFacts {
    type Error = anyhow::Error;

    fn try_from(reported: ReportedRecording) -> anyhow::Result<Self> {
        Ok(Self {
            session: Session::from_text(&reported.session)?,
            duration_s: reported.duration_s,
            complete: reported.complete,
            hashes: reported.hashes,
            signature: reported.signature.as_ref().map(Signature::from_text).transpose()?,
        })
    }
}
