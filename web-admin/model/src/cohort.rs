//! A cohort at a glance.

use crate::ids::CohortId;

/// A cohort at a glance.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct CohortSummary {
    /// Its id.
    pub id: CohortId,
    /// Its name.
    pub name: String,
    /// Trainees in it.
    pub trainees: i64,
    /// Their scored attempts.
    pub attempts: i64,
    /// Of them, those that passed.
    pub passes: i64,
}
