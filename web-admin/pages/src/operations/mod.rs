//! Operation of the service.

pub mod admin;
pub mod backups;
pub mod origins;
pub mod papers;
pub mod service;
pub mod settings;
