//! Summary of a cohort.

use crate::ids::CohortId;

/// Summary of a cohort.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct CohortSummary {
    /// Id.
    pub id: CohortId,
    /// Name.
    pub name: String,
    /// Number of trainees.
    pub trainees: i64,
    /// Number of scored attempts.
    pub attempts: i64,
    /// Number of passed attempts.
    pub passes: i64,
}
