//! Retention of study data.

use model::Moment;
use model::ids::{SchoolId, StudyId};

use super::{Study, study};
use crate::{Connection, Executor, Result};

/// Returns the closed studies of a school whose data have not been erased.
pub async fn list_kept_studies(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<Study>> {
    sqlx::query_as(study!(
        "WHERE u.school_id = $1 AND u.closed_at IS NOT NULL AND u.erased_at IS NULL ORDER BY u.closed_at, u.id"
    ))
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Records that the erasure of a study's data was announced, by the clock and by the uptime of the
/// service.
pub async fn announce_study_erasure(writer: &mut Connection, study: &Study, now: Moment) -> Result<()> {
    sqlx::query(
        "UPDATE studies SET told_at = $3, told_observed_s = (SELECT observed_s FROM service_time)
         WHERE school_id = $1 AND id = $2",
    )
    .bind(study.school_id)
    .bind(study.id)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Withdraws the announcement.
pub async fn call_off_study_erasure(writer: &mut Connection, school: SchoolId, study: StudyId) -> Result<()> {
    sqlx::query("UPDATE studies SET told_at = NULL, told_observed_s = NULL WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(study)
        .execute(writer)
        .await
        .map(drop)
}

/// Records that the data of a study were erased.
pub async fn mark_study_erased(writer: &mut Connection, study: &Study, now: Moment) -> Result<()> {
    sqlx::query("UPDATE studies SET erased_at = $3 WHERE school_id = $1 AND id = $2")
        .bind(study.school_id)
        .bind(study.id)
        .bind(now)
        .execute(writer)
        .await
        .map(drop)
}
