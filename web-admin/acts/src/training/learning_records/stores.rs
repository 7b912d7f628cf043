//! The learning record store of a school, and consents to it.

use model::ids::RecordStoreId;
use model::training::learning_records::RecordStoreSettings;
use model::{CurrentPerson, PersonKey};
use platform::sealing;
use serde_json::json;
use store::audit::AuditEntry;
use store::training::learning_records;
use store::training::learning_records::RecordStore;

use crate::error::Error;
use crate::service::Service;

/// Maximum length of a password, in bytes.
const LONGEST_PASSWORD: usize = 1000;

/// Sets the store of a school. An empty password keeps the stored one. If statements go elsewhere
/// or contain more than before, it is another store: consents to the previous one do not hold for
/// it, and what was not sent is deleted.
///
/// # Errors
/// Returns [`Error::Unprocessable`] for invalid settings.
pub async fn put_store(
    service: &Service,
    by: &CurrentPerson,
    settings: RecordStoreSettings,
    password: &str,
) -> Result<(), Error> {
    settings.check().map_err(Error::Unprocessable)?;
    if let Err(why) = service.outgoing.rules().check(&settings.endpoint) {
        return Err(Error::Unprocessable(tr!("endpoint: {why}", why = why)));
    }
    let now = service.clock.now();
    let known = learning_records::find_record_store(service.db.reader(), by.school_id).await?;
    let kept = known.as_ref().filter(|known| !settings.asks_for_more(&known.settings));
    let id = kept.map_or_else(|| RecordStoreId::made_at(now), |kept| kept.id);
    let sealed_password = match (password, kept) {
        ("", Some(kept)) => kept.sealed_password.clone(),
        ("", None) => return Err(Error::Unprocessable(tr!("password: empty; it is required").to_owned())),
        (typed, _) if typed.len() > LONGEST_PASSWORD => {
            return Err(Error::Unprocessable(tr!("password: longer than {most} bytes", most = LONGEST_PASSWORD)));
        }
        (typed, _) => sealing::seal(&service.config.keys_dir, id.uuid().as_bytes(), typed.as_bytes())?,
    };
    let details = json!({
        "endpoint": settings.endpoint,
        "version": settings.version,
        "by_consent": settings.ground.is_none(),
        "names": settings.names,
    });
    let new = RecordStore { id, school_id: by.school_id, settings, sealed_password, refusal: None };
    let mut tx = service.db.write().await?;
    if let Some(known) = known.filter(|known| known.id != id) {
        learning_records::disable_record_store(&mut tx, by.school_id, known.id, now).await?;
    }
    learning_records::put_record_store(&mut tx, &new, now).await?;
    AuditEntry::by(by, "record_store.set", id).with(details).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

/// Ends the use of the store. What was not sent is deleted.
///
/// # Errors
/// Returns [`Error::NotFound`] if the school uses none.
pub async fn disable_store(service: &Service, by: &CurrentPerson) -> Result<(), Error> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    let known = learning_records::find_record_store(&mut *tx, by.school_id).await?.ok_or(Error::NotFound)?;
    learning_records::disable_record_store(&mut tx, by.school_id, known.id, now).await?;
    AuditEntry::by(by, "record_store.disabled", known.id).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

/// Makes the statements that were not sent due, even those that the store has refused.
///
/// # Errors
/// Returns [`Error::NotFound`] if the school uses no store.
pub async fn retry(service: &Service, by: &CurrentPerson) -> Result<(), Error> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    let known = learning_records::find_record_store(&mut *tx, by.school_id).await?.ok_or(Error::NotFound)?;
    learning_records::set_refusal(&mut tx, known.id, None, now).await?;
    learning_records::retry_statements(&mut tx, known.id, now).await?;
    AuditEntry::by(by, "record_store.retried", known.id).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

/// Records that a person consents to the store of their school, with the wording shown.
///
/// # Errors
/// Returns [`Error::Conflict`] if the school does not ask for consent.
pub async fn give_consent(service: &Service, by: &CurrentPerson, wording: &str) -> Result<(), Error> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    let asked = learning_records::find_record_store(&mut *tx, by.school_id).await?;
    let Some(asked) = asked.filter(|asked| asked.settings.ground.is_none()) else {
        return Err(Error::Conflict(tr!("your school does not ask for this consent").to_owned()));
    };
    if learning_records::add_consent(&mut tx, key_of(by), asked.id, wording, now).await? {
        AuditEntry::by(by, "records.consented", by.id).with(json!({ "store": asked.id })).append(&mut tx, now).await?;
    }
    Ok(tx.commit().await?)
}

/// Withdraws the consent of a person. What was not sent is deleted.
///
/// # Errors
/// Fails if the database fails.
pub async fn withdraw_consent(service: &Service, by: &CurrentPerson) -> Result<(), Error> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    if learning_records::withdraw_consents(&mut tx, key_of(by), now).await? {
        AuditEntry::by(by, "records.consent_withdrawn", by.id).append(&mut tx, now).await?;
    }
    Ok(tx.commit().await?)
}

const fn key_of(person: &CurrentPerson) -> PersonKey {
    PersonKey { school_id: person.school_id, person_id: person.id }
}
