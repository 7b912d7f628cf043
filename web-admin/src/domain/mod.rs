//! What the service knows, free of storage and pages.

pub mod curve;
pub mod progress;
