//! Recordings of attempts.

#[cfg(feature = "replicas")]
pub(crate) mod buckets;
pub(crate) mod crashed_uploads;
pub(crate) mod crashing_recordings;
pub(crate) mod oblique;
pub(crate) mod proof;
pub(crate) mod quotas;
pub(crate) mod replay;
pub(crate) mod scanning;
pub(crate) mod tus;
pub(crate) mod uploads;
