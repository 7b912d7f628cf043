//! What pages look like: one struct beside each template.

pub mod error;
pub mod login;
