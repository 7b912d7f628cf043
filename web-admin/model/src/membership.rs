//! What is done about a place in a cohort.

use crate::ids::{CohortId, PersonId};
use crate::{Moment, Role};

/// What was done about somebody's place in a cohort.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum MembershipAct {
    /// They were asked for.
    Asked,
    /// They, or an administrator, said no, or whoever had asked took it back.
    Declined,
    /// They joined.
    Joined,
    /// They left, or were taken out.
    Left,
}

/// What was done about somebody's place in a cohort.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct MembershipEvent {
    /// The cohort's name.
    pub cohort: String,
    /// What.
    pub act: MembershipAct,
    /// The name of whoever did it; absent on the command line.
    pub by: Option<String>,
    /// When.
    pub done_at: Moment,
}

/// Somebody is asked for, and nobody has answered yet.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct MembershipRequest {
    /// The cohort.
    pub cohort_id: CohortId,
    /// Its name.
    pub cohort: String,
    /// Who is asked for.
    pub person_id: PersonId,
    /// Their name.
    pub person: String,
    /// What they would be in it.
    pub role: Role,
    /// The name of whoever asks.
    pub asked_by: String,
    /// When.
    pub asked_at: Moment,
}
