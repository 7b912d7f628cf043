//! The attempt that something belongs to.

use uuid::Uuid;

use crate::ids::SchoolId;

/// The attempt that something belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionKey {
    /// School.
    pub school_id: SchoolId,
    /// Session.
    pub id: Uuid,
}
