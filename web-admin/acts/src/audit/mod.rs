//! The audit log.

pub mod audit_checkpoints;
pub mod checkpoint_store;
