//! What a school settles for itself. Each act is an administrator's, and the audit log keeps it.

use model::{CurrentPerson, FactorRule, Needed};
use serde_json::{Value, json};
use store::audit::AuditEntry;
use store::retention::{self, Settings};
use store::{Write, origins, schools, second_factors};

use crate::error::Error;
use crate::service::Service;

/// Notes in the audit log what was settled, and ends the transaction.
async fn settle(
    service: &Service,
    mut tx: Write,
    by: &CurrentPerson,
    action: &str,
    settled: Value,
) -> Result<(), Error> {
    AuditEntry::by(by, action, by.school_id).with(settled).append(&mut tx, service.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// Sets the time zone in which days are said. What was assigned before keeps the one in which it was said.
pub async fn set_time_zone(service: &Service, by: &CurrentPerson, zone: &str) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    schools::set_time_zone(&mut tx, by.school_id, zone).await?;
    settle(service, tx, by, "school.time_zone_set", json!({ "time_zone": zone })).await
}

/// Sets from which origins browsers may read what the school publishes.
pub async fn set_origins(service: &Service, by: &CurrentPerson, allowed: &[String]) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    origins::replace_origins(&mut tx, by.school_id, allowed).await?;
    settle(service, tx, by, "school.origins_set", json!({ "origins": allowed })).await
}

/// Sets of whom a second factor is asked.
pub async fn set_second_factor_rule(service: &Service, by: &CurrentPerson, rule: FactorRule) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    second_factors::set_factor_rule(&mut tx, by.school_id, rule).await?;
    settle(service, tx, by, "school.second_factor_set", json!({ "asked_of": rule.word() })).await
}

/// Sets what must be proved of an attempt for it to count towards a certificate.
pub async fn set_certificate_needs(service: &Service, by: &CurrentPerson, needed: Needed) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    schools::set_certificate_needs(&mut tx, by.school_id, needed).await?;
    settle(service, tx, by, "school.certificate_needs_set", json!({ "needed": needed.word() })).await
}

/// Sets how long people are kept who do nothing any more.
pub async fn set_retention(service: &Service, by: &CurrentPerson, settings: Settings) -> Result<(), Error> {
    let told = json!({
        "months": settings.months,
        "warn_days": settings.warn_days,
        "texts": settings.texts,
        "recordings": settings.recordings,
    });
    let mut tx = service.db.write().await?;
    retention::set_retention_rule(&mut tx, by.school_id, settings).await?;
    settle(service, tx, by, "retention.set", told).await
}
