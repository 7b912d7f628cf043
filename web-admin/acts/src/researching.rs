//! What is noted when a school's attempts leave it for research.

use model::ids::SchoolId;
use serde_json::json;
use store::audit::{Actor, AuditEntry};

use crate::error::Error;
use crate::service::Service;

/// How much was written, and how much was held back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct ResearchCounts {
    /// Attempts.
    pub attempts: u64,
    /// Values of metrics.
    pub metrics: u64,
    /// Samples of recordings.
    pub samples: u64,
    /// Attempts whose recording could not be read.
    pub unread: u64,
    /// Attempts of guests: they are in their studies.
    pub of_guests: i64,
    /// Attempts of staff who have not agreed.
    pub of_staff: i64,
}

/// Notes in the audit log that a school's attempts were written for research.
///
/// # Errors
/// When the database fails.
pub async fn note_research_export(service: &Service, school: SchoolId, counts: &ResearchCounts) -> Result<(), Error> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    AuditEntry::new(school, Actor::CommandLine, "school.exported", school)
        .with(json!(counts))
        .append(&mut tx, now)
        .await?;
    Ok(tx.commit().await?)
}
