//! Operation of the service.

pub mod backups;
pub mod fixtures;
pub mod logos;
pub mod moving;
pub mod origins;
pub mod schools;
pub mod service;
