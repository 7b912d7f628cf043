//! Operation of the service.

pub(crate) mod backups;
pub(crate) mod commands;
pub(crate) mod crowd;
pub(crate) mod dumps;
pub(crate) mod earlier_school;
pub(crate) mod engines;
pub(crate) mod fail_points;
pub(crate) mod faults;
pub(crate) mod logos;
pub(crate) mod moving;
pub(crate) mod plans;
pub(crate) mod replicas;
pub(crate) mod schema;
pub(crate) mod settings;
#[cfg(feature = "replicas")]
pub(crate) mod telemetry;
