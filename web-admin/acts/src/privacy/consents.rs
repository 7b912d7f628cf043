//! Consents of experts to publish their attempts as a reference corridor.

use model::ids::PersonId;
use model::{CurrentPerson, PersonKey};
use serde_json::json;
use store::audit::AuditEntry;
use store::privacy::experts;
use store::privacy::experts::NewDeclaration;

use crate::error::Error;
use crate::service::Service;

/// Records a consent that a person gave offline, on paper or orally, entered by another person.
///
/// # Errors
/// Returns [`Error::Conflict`] if the person has already consented; fails if the database fails.
pub async fn record_consent(
    service: &Service,
    by: &CurrentPerson,
    person: PersonId,
    new: NewDeclaration<'_>,
) -> Result<(), Error> {
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    if !experts::record_consent(&mut tx, PersonKey { school_id: by.school_id, person_id: person }, new, now).await? {
        return Err(Error::Conflict(tr!("this person has already given consent; withdraw it first").to_owned()));
    }
    let told = json!({ "wording": new.wording, "given_at": new.given_at.to_string() });
    AuditEntry::by(by, "expert.consented", person).with(told).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

/// Records a person's own consent, with the wording shown. Has no effect if they have already
/// consented.
pub async fn give_own_consent(service: &Service, by: &CurrentPerson, wording: &str) -> Result<(), Error> {
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    let new = NewDeclaration { wording, how: "given by themselves, signed in", given_at: now, recorded_by: by.id };
    if experts::record_consent(&mut tx, PersonKey { school_id: by.school_id, person_id: by.id }, new, now).await? {
        AuditEntry::by(by, "expert.consented", by.id).append(&mut tx, now).await?;
    }
    Ok(tx.commit().await?)
}

/// Withdraws the consent of `person`, if there is one.
pub async fn withdraw_consent(service: &Service, by: &CurrentPerson, person: PersonId) -> Result<(), Error> {
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    if experts::withdraw_consent(&mut tx, PersonKey { school_id: by.school_id, person_id: person }, by.id, now).await? {
        AuditEntry::by(by, "expert.consent_withdrawn", person).append(&mut tx, now).await?;
    }
    Ok(tx.commit().await?)
}
