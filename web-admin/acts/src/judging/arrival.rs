//! What a recording that has just arrived says of itself.

use std::collections::BTreeMap;

use anyhow::Context;
use recording::{AttemptHashes, Recording, Session, Signature};
use serde::{Deserialize, Serialize};

/// What a recording says of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingFacts {
    /// Its metadata.
    pub session: Session,
    /// How long it is, in s.
    pub duration_s: f64,
    /// It is whole.
    pub complete: bool,
    /// Hashes of what the hand did and under which conditions; absent without samples.
    pub hashes: Option<AttemptHashes>,
    /// A station's signature, where there is one.
    pub signature: Option<Signature>,
}

impl From<Recording> for RecordingFacts {
    fn from(recording: Recording) -> Self {
        let last = recording.samples.last();
        Self {
            duration_s: last.map_or(0.0, |sample| sample.t_s),
            complete: recording.complete,
            hashes: last.map(|_| AttemptHashes::of_attempt(&recording.samples, &recording.events)),
            signature: recording.signature,
            session: recording.session,
        }
    }
}

/// The same as it goes from one process to the other: metadata and signature as they stand in the file.
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
