//! Audit of research exports.

use model::ids::SchoolId;
use serde_json::json;
use store::audit::{Actor, AuditEntry};

use crate::error::Error;
use crate::service::Service;

/// Numbers of exported and withheld items.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct ResearchCounts {
    /// Exported attempts.
    pub attempts: u64,
    /// Exported metric values.
    pub metrics: u64,
    /// Exported samples of recordings.
    pub samples: u64,
    /// Attempts whose recording could not be read.
    pub unread: u64,
    /// Withheld attempts of guests, which belong to their studies.
    pub of_guests: i64,
    /// Withheld attempts of staff who have not consented.
    pub of_staff: i64,
}

/// Records in the audit log that a school's attempts were exported for research.
///
/// # Errors
/// Fails if the database fails.
pub async fn note_research_export(service: &Service, school: SchoolId, counts: &ResearchCounts) -> Result<(), Error> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    AuditEntry::new(school, Actor::CommandLine, "school.exported", school)
        .with(json!(counts))
        .append(&mut tx, now)
        .await?;
    Ok(tx.commit().await?)
}
