//! The attempt that something belongs to.

use crate::ids::{SchoolId, SessionId};

/// The attempt that something belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionKey {
    /// School.
    pub school_id: SchoolId,
    /// Session.
    pub id: SessionId,
}
