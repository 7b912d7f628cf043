//! Mail and notices.

pub(crate) mod notices;
pub(crate) mod waiting;
