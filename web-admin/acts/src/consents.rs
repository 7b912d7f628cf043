//! Consents of experts to have their attempts shown as a corridor.

use model::ids::PersonId;
use model::{CurrentPerson, PersonKey};
use serde_json::json;
use store::audit::AuditEntry;
use store::experts::{self, NewDeclaration};

use crate::error::Error;
use crate::service::Service;

/// Keeps a consent that somebody gave outside, on paper or in words, and was typed by another.
///
/// # Errors
/// [`Error::Conflict`] when one stands already; else when the database fails.
pub async fn record_consent(
    service: &Service,
    by: &CurrentPerson,
    person: PersonId,
    new: NewDeclaration<'_>,
) -> Result<(), Error> {
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    if !experts::record_consent(&mut tx, PersonKey { school_id: by.school_id, person_id: person }, new, now).await? {
        return Err(Error::Conflict(tr!("a consent stands already; it is taken back first").to_owned()));
    }
    let told = json!({ "wording": new.wording, "given_at": new.given_at.to_string() });
    AuditEntry::by(by, "expert.consented", person).with(told).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

/// Gives one's own consent, in the words that were shown; where one stands already, it goes on standing.
pub async fn give_own_consent(service: &Service, by: &CurrentPerson, wording: &str) -> Result<(), Error> {
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    let new = NewDeclaration { wording, how: "given by themselves, signed in", given_at: now, recorded_by: by.id };
    if experts::record_consent(&mut tx, PersonKey { school_id: by.school_id, person_id: by.id }, new, now).await? {
        AuditEntry::by(by, "expert.consented", by.id).append(&mut tx, now).await?;
    }
    Ok(tx.commit().await?)
}

/// Takes back the consent of `person`, where one stands.
pub async fn withdraw_consent(service: &Service, by: &CurrentPerson, person: PersonId) -> Result<(), Error> {
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    if experts::withdraw_consent(&mut tx, PersonKey { school_id: by.school_id, person_id: person }, by.id, now).await? {
        AuditEntry::by(by, "expert.consent_withdrawn", person).append(&mut tx, now).await?;
    }
    Ok(tx.commit().await?)
}
