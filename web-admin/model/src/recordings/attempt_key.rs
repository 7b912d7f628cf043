//! Key of an attempt.

use crate::ids::{SchoolId, SessionId};

/// Key of an attempt, used for its rows in other tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionKey {
    /// School.
    pub school_id: SchoolId,
    /// Session.
    pub id: SessionId,
}
