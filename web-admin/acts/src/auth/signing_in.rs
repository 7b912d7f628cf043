//! Logging of successful and refused sign-ins.

use std::net::IpAddr;

use data_encoding::HEXLOWER;
use model::ids::{PersonId, SchoolId};
use model::people::email::normalize_email;
use platform::secret;
use serde_json::json;
use store::audit::{Actor, AuditEntry};
use store::auth::rate_limits;
use store::people;

use crate::error::Error;
use crate::service::Service;

/// Records in the audit log that a person signed in or out.
pub async fn note_way_in(service: &Service, person: PersonId, action: &str) -> Result<(), Error> {
    let school_id = people::find_person(service.db.reader(), person).await?.map(|p| p.school_id);
    let mut tx = service.db.write().await?;
    AuditEntry::new(school_id, Actor::Person(person), action, person).append(&mut tx, service.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// Records a refused sign-in: in the log with the network address, in the audit log without.
/// Attempts with an unknown email address are only counted, by the hour; [`note_unknown_sign_ins`]
/// writes the counts to the audit log.
pub async fn note_refused_sign_in(service: &Service, email: &str, from: IpAddr, action: &str) -> Result<(), Error> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    let people = people::list_people_by_email(&mut *tx, email).await?;
    for person in &people {
        AuditEntry::new(person.school_id, Actor::Stranger, action, person.id).append(&mut tx, now).await?;
    }
    if people.is_empty() {
        rate_limits::count_unknown_sign_in(&mut tx, now).await?;
    }
    tx.commit().await?;
    // The field may hold a password by mistake, so only its hash is logged.
    let hash = HEXLOWER.encode(&secret::token_sha256(&normalize_email(email)));
    let object = match &*people {
        [] => format!("address {}", &hash[..16]),
        people => people.iter().map(|person| person.id.to_string()).collect::<Vec<_>>().join(" "),
    };
    tracing::warn!(%from, action, object, "sign-in failed");
    Ok(())
}

/// Writes the number of sign-in attempts with unknown email addresses of each past hour to the
/// audit log.
pub async fn note_unknown_sign_ins(service: &Service) -> Result<(), Error> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    for hour in rate_limits::take_unknown_sign_ins(&mut tx, now).await? {
        AuditEntry::new(None::<SchoolId>, Actor::Worker, "sign_in.unknown_failed", hour.begins_at.to_string())
            .with(json!({ "tries": hour.tries }))
            .append(&mut tx, now)
            .await?;
    }
    Ok(tx.commit().await?)
}
