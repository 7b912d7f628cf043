//! The systems of a school that confirm who its users are.

use model::auth::federation::IdentityKind;
use model::auth::sign_in_refusal::SignInRefusal;
use model::ids::{PlatformId, ProviderId, SchoolId};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use store::audit::{Actor, AuditEntry};
use store::auth::federation::providers::{self, SignInProvider};
use store::auth::lti::platforms::{self, Platform};

use super::documents::DocumentError;
use crate::error::Error;
use crate::service::Service;

/// Id of a provider or a learning platform.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum IdentitySourceId {
    /// A provider.
    Provider(ProviderId),
    /// A learning platform.
    Platform(PlatformId),
}

impl IdentitySourceId {
    /// Returns the protocol.
    #[must_use]
    pub const fn kind(self) -> IdentityKind {
        match self {
            Self::Provider(_) => IdentityKind::Oidc,
            Self::Platform(_) => IdentityKind::Lti,
        }
    }

    /// Returns the details of an audit entry: the id by its kind, and a further value.
    pub(super) fn details(self, name: &str, value: impl Into<Value>) -> Value {
        match self {
            Self::Provider(id) => json!({ "provider": id, name: value.into() }),
            Self::Platform(id) => json!({ "platform": id, name: value.into() }),
        }
    }
}

/// A system of a school that confirms who its users are: a provider or a learning platform.
#[derive(Clone, Debug)]
pub struct IdentitySource {
    /// Id.
    pub id: IdentitySourceId,
    /// School.
    pub school_id: SchoolId,
    /// Name.
    pub name: String,
    /// Unknown people get a new account as trainees.
    pub creates_trainees: bool,
    /// Whether it is disabled.
    pub is_disabled: bool,
}

impl From<&SignInProvider> for IdentitySource {
    fn from(provider: &SignInProvider) -> Self {
        Self {
            id: IdentitySourceId::Provider(provider.id),
            school_id: provider.school_id,
            name: provider.settings.name.clone(),
            creates_trainees: provider.settings.creates_trainees,
            is_disabled: provider.disabled_at.is_some(),
        }
    }
}

impl From<&Platform> for IdentitySource {
    fn from(platform: &Platform) -> Self {
        Self {
            id: IdentitySourceId::Platform(platform.id),
            school_id: platform.school_id,
            name: platform.settings.name.clone(),
            creates_trainees: platform.settings.creates_trainees,
            is_disabled: platform.disabled_at.is_some(),
        }
    }
}

/// Returns a source of any school.
///
/// # Errors
/// Fails if there is no such source, or the database fails.
pub async fn find_source(service: &Service, id: IdentitySourceId) -> Result<IdentitySource, Error> {
    let reader = service.db.reader();
    let found = match id {
        IdentitySourceId::Provider(id) => {
            providers::find_provider_of_any_school(reader, id).await?.as_ref().map(IdentitySource::from)
        }
        IdentitySourceId::Platform(id) => {
            platforms::find_platform_of_any_school(reader, id).await?.as_ref().map(IdentitySource::from)
        }
    };
    found.ok_or(Error::NotFound)
}

/// Converts a failure into a refusal, which is logged and recorded.
pub(in crate::auth) async fn refuse_by<T>(
    service: &Service,
    source: &IdentitySource,
    error: DocumentError,
) -> Result<Result<T, SignInRefusal>, Error> {
    match error {
        DocumentError::Service(error) => Err(error),
        DocumentError::Provider(reason, why) => {
            tracing::warn!(source = ?source.id, reason = reason.code(), why, "sign-in refused");
            refuse(service, source, reason).await
        }
    }
}

/// Records a refusal in the audit log.
pub(in crate::auth) async fn refuse<T>(
    service: &Service,
    source: &IdentitySource,
    reason: SignInRefusal,
) -> Result<Result<T, SignInRefusal>, Error> {
    note_refusal(service, source, reason).await?;
    Ok(Err(reason))
}

/// Records in the audit log that a sign-in by a provider, or a launch, was refused.
///
/// # Errors
/// Fails if the database fails.
pub async fn note_refusal(service: &Service, source: &IdentitySource, reason: SignInRefusal) -> Result<(), Error> {
    let details = source.id.details("reason", reason.code());
    let entry = match source.id {
        IdentitySourceId::Provider(id) => {
            AuditEntry::new(source.school_id, Actor::Stranger, "sign_in.provider_refused", id)
        }
        IdentitySourceId::Platform(id) => {
            AuditEntry::new(source.school_id, Actor::Stranger, "sign_in.launch_refused", id)
        }
    };
    let mut tx = service.db.write().await?;
    entry.with(details).append(&mut tx, service.clock.now()).await?;
    Ok(tx.commit().await?)
}
