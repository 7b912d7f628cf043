//! Operation of the service.

pub mod monitoring;
