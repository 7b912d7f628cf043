//! Mail and notices.

pub mod mail;
pub mod notice;
