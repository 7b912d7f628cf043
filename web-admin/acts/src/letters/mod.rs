//! Mail and notices.

pub mod mailing;
pub mod notices;
