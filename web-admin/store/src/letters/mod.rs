//! Mail and notices.

pub mod mails;
pub mod notices;
