//! The learning platforms of a school, set up by its administrators.

use model::CurrentPerson;
use model::auth::lti::{NumberClaim, PlatformSettings};
use model::ids::PlatformId;
use serde_json::json;
use store::audit::AuditEntry;
use store::auth::lti::platforms;
use store::auth::lti::platforms::NewPlatform;

use crate::error::Error;
use crate::service::Service;

/// Maximum number of learning platforms of a school.
const MOST: usize = 20;

/// Adds a learning platform.
///
/// # Errors
/// Returns [`Error::Unprocessable`] for invalid settings, or a second registration with the same
/// issuer and client id.
pub async fn add_platform(
    service: &Service,
    by: &CurrentPerson,
    settings: &PlatformSettings,
) -> Result<PlatformId, Error> {
    check_room(service, by).await?;
    let id = PlatformId::made_at(service.clock.now());
    put(service, by, NewPlatform { id, school_id: by.school_id, settings }, "platform.added").await?;
    Ok(id)
}

/// Checks that the school may register one more learning platform.
pub(super) async fn check_room(service: &Service, by: &CurrentPerson) -> Result<(), Error> {
    if platforms::list_platforms(service.db.reader(), by.school_id).await?.len() >= MOST {
        return Err(Error::Unprocessable(tr!("at most {most} learning platforms are allowed", most = MOST)));
    }
    Ok(())
}

/// Changes a learning platform.
///
/// # Errors
/// As [`add_platform`], and if there is no such platform.
pub async fn change_platform(
    service: &Service,
    by: &CurrentPerson,
    id: PlatformId,
    settings: &PlatformSettings,
) -> Result<(), Error> {
    platforms::find_platform(service.db.reader(), by.school_id, id).await?.ok_or(Error::NotFound)?;
    put(service, by, NewPlatform { id, school_id: by.school_id, settings }, "platform.changed").await
}

/// Checks the settings of a learning platform, and its addresses.
pub(super) fn check_settings(service: &Service, settings: &PlatformSettings) -> Result<(), Error> {
    settings.check().map_err(Error::Unprocessable)?;
    for (field, address) in settings.addresses() {
        if let Err(why) = service.outgoing.rules().check(address) {
            return Err(Error::Unprocessable(tr!("{field}: {why}", field = field, why = why)));
        }
    }
    Ok(())
}

async fn put(service: &Service, by: &CurrentPerson, new: NewPlatform<'_>, action: &str) -> Result<(), Error> {
    let settings = new.settings;
    check_settings(service, settings)?;
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    if platforms::is_registered(&mut *tx, new).await? {
        let why = tr!("a learning platform with the same issuer and client id is registered already");
        return Err(Error::Unprocessable(why.to_owned()));
    }
    if !platforms::put_platform(&mut tx, new, now).await? {
        return Err(Error::NotFound);
    }
    AuditEntry::by(by, action, new.id)
        .with(json!({
            "issuer": settings.issuer,
            "client_id": settings.client_id,
            "number_claim": settings.number_claim.map(NumberClaim::word),
            "creates_trainees": settings.creates_trainees,
        }))
        .append(&mut tx, now)
        .await?;
    Ok(tx.commit().await?)
}

/// Disables a learning platform, or enables it again.
///
/// # Errors
/// Fails if there is no such platform, or the database fails.
pub async fn set_disabled(service: &Service, by: &CurrentPerson, id: PlatformId, disabled: bool) -> Result<(), Error> {
    let now = service.clock.now();
    platforms::find_platform(service.db.reader(), by.school_id, id).await?.ok_or(Error::NotFound)?;
    let mut tx = service.db.write().await?;
    if platforms::set_platform_disabled(&mut tx, by.school_id, id, disabled.then_some(now)).await? {
        let action = if disabled { "platform.disabled" } else { "platform.enabled" };
        AuditEntry::by(by, action, id).append(&mut tx, now).await?;
    }
    Ok(tx.commit().await?)
}

/// Admits a deployment whose launches were refused.
///
/// # Errors
/// Fails if no such deployment waits, or the database fails.
pub async fn admit_deployment(
    service: &Service,
    by: &CurrentPerson,
    id: PlatformId,
    deployment: &str,
) -> Result<(), Error> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    if !platforms::admit_deployment(&mut tx, by.school_id, id, deployment, now).await? {
        return Err(Error::NotFound);
    }
    AuditEntry::by(by, "platform.deployment_admitted", id)
        .with(json!({ "deployment": deployment }))
        .append(&mut tx, now)
        .await?;
    Ok(tx.commit().await?)
}
