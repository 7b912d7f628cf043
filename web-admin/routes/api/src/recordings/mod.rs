//! Recordings of attempts.

pub(crate) mod comments;
pub(crate) mod cors;
pub(crate) mod replay;
pub(crate) mod sessions;
pub(crate) mod tus;
pub(crate) mod upload;
