//! Operation of the service.

pub mod backup;
pub mod fixtures;
pub mod inspection;
pub mod key_files;
pub mod moving;
pub mod schools;
pub mod upkeep;
pub mod verification;
