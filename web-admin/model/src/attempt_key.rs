//! The attempt that something belongs to.

use uuid::Uuid;

/// The attempt that something belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionKey {
    /// School.
    pub school_id: Uuid,
    /// Session.
    pub id: Uuid,
}
