//! What the logs keep of who got in, and who did not.

use std::net::IpAddr;

use data_encoding::HEXLOWER;
use model::email::normalize_email;
use model::ids::PersonId;
use store::audit::{Actor, AuditEntry};
use store::people;

use crate::error::Error;
use crate::secret;
use crate::service::Service;

/// Writes down that somebody signed in or out.
pub async fn note_way_in(service: &Service, person: PersonId, action: &str) -> Result<(), Error> {
    let school_id = people::find_person(service.db.reader(), person).await?.map(|p| p.school_id);
    let mut tx = service.db.write().await?;
    AuditEntry::new(school_id, Actor::Person(person), action, person).append(&mut tx, service.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// Writes down that somebody did not get in: in the log with the network address, in the audit log, which keeps for ever, without.
/// An address that nobody has is told by its hash alone: passwords are typed into the wrong field. Costs the same for both.
pub async fn note_refused_sign_in(service: &Service, email: &str, from: IpAddr, action: &str) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    let person = people::find_person_by_email(&mut *tx, email).await?;
    let school_id = person.as_ref().map(|person| person.school_id);
    let hash = HEXLOWER.encode(&secret::token_sha256(&normalize_email(email)));
    let object = person.map_or_else(|| format!("address {}", &hash[..16]), |person| person.id.to_string());
    tracing::warn!(%from, action, object, "somebody did not get in");
    AuditEntry::new(school_id, Actor::Stranger, action, object).append(&mut tx, service.clock.now()).await?;
    Ok(tx.commit().await?)
}
