//! Changes to cohort memberships.

use crate::ids::{CohortId, PersonId};
use crate::{Moment, Role};

/// Kind of change to a cohort membership.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum MembershipAct {
    /// The membership was requested.
    Asked,
    /// The request was declined by the person or an administrator, or withdrawn.
    Declined,
    /// The person joined.
    Joined,
    /// The person left or was removed.
    Left,
}

/// A change to a cohort membership.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct MembershipEvent {
    /// Name of the cohort.
    pub cohort: String,
    /// Kind of change.
    pub act: MembershipAct,
    /// Name of the person who made the change; `None` on the command line.
    pub by: Option<String>,
    /// Time of the change.
    pub done_at: Moment,
}

/// A pending membership request.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct MembershipRequest {
    /// Cohort.
    pub cohort_id: CohortId,
    /// Name of the cohort.
    pub cohort: String,
    /// Requested person.
    pub person_id: PersonId,
    /// Name of the requested person.
    pub person: String,
    /// Role in the cohort.
    pub role: Role,
    /// Name of the person who made the request.
    pub asked_by: String,
    /// Time of the request.
    pub asked_at: Moment,
}
