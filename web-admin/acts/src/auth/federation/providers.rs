//! The providers of a school, set up by its administrators.

use model::CurrentPerson;
use model::auth::federation::{ClientAuthentication, LocalPasswords, ProviderSettings};
use model::auth::sign_in_refusal::SignInRefusal;
use model::ids::ProviderId;
use model::single_line_text;
use platform::sealing;
use serde_json::json;
use store::audit::AuditEntry;
use store::auth::federation::providers;
use store::auth::federation::providers::{NewProvider, SignInProvider};

use super::client_keys;
use super::documents::{self, DocumentError};
use crate::error::Error;
use crate::service::Service;

/// Maximum number of providers of a school.
const MOST: usize = 20;
/// Maximum length of a client secret, in bytes.
const LONGEST_SECRET: usize = 1000;

/// Adds a provider, after its discovery document was read.
///
/// # Errors
/// Returns [`Error::Unprocessable`] for invalid settings, a provider that does not answer as its
/// issuer, or a second one with the same issuer and client id.
pub async fn add_provider(
    service: &Service,
    by: &CurrentPerson,
    settings: &ProviderSettings,
    secret: &str,
) -> Result<ProviderId, Error> {
    if providers::list_providers(service.db.reader(), by.school_id).await?.len() >= MOST {
        return Err(Error::Unprocessable(tr!("at most {most} providers are allowed", most = MOST)));
    }
    let id = ProviderId::made_at(service.clock.now());
    let sealed = seal_secret(service, id, NewSecret { settings, typed: secret, stored: &[] })?;
    put(service, by, NewProvider { id, school_id: by.school_id, settings, sealed_secret: &sealed }, "provider.added")
        .await?;
    Ok(id)
}

/// Changes a provider; an empty secret keeps the stored one.
///
/// # Errors
/// As [`add_provider`], and if there is no such provider.
pub async fn change_provider(
    service: &Service,
    by: &CurrentPerson,
    known: &SignInProvider,
    settings: &ProviderSettings,
    secret: &str,
) -> Result<(), Error> {
    let secret = NewSecret { settings, typed: secret, stored: &known.sealed_secret };
    let sealed = seal_secret(service, known.id, secret)?;
    let new = NewProvider { id: known.id, school_id: by.school_id, settings, sealed_secret: &sealed };
    put(service, by, new, "provider.changed").await
}

/// The secret of a provider that is added or changed.
struct NewSecret<'a> {
    settings: &'a ProviderSettings,
    typed: &'a str,
    /// Encrypted; empty for a new provider, and for one that authenticates by the key.
    stored: &'a [u8],
}

/// Returns the encrypted secret; empty if this service authenticates by its key.
fn seal_secret(service: &Service, id: ProviderId, secret: NewSecret<'_>) -> Result<Vec<u8>, Error> {
    if secret.settings.authentication == ClientAuthentication::Key {
        return Ok(Vec::new());
    }
    match (secret.typed, secret.stored) {
        ("", []) => Err(Error::Unprocessable(tr!("client secret: empty; it is required").to_owned())),
        ("", stored) => Ok(stored.to_vec()),
        (typed, _) if typed.len() > LONGEST_SECRET => {
            Err(Error::Unprocessable(tr!("client secret: longer than {most} characters", most = LONGEST_SECRET)))
        }
        (typed, _) => Ok(sealing::seal(&service.config.keys_dir, id.uuid().as_bytes(), typed.as_bytes())?),
    }
}

async fn put(service: &Service, by: &CurrentPerson, new: NewProvider<'_>, action: &str) -> Result<(), Error> {
    let settings = new.settings;
    settings.check().map_err(Error::Unprocessable)?;
    match documents::read_discovery(service, by.school_id, &settings.issuer, true).await {
        Ok(discovery) if discovery.find_authentication(settings.authentication).is_some() => {}
        Ok(_) => {
            let why = match settings.authentication {
                ClientAuthentication::Secret => tr!("the provider does not accept a secret; use the key"),
                ClientAuthentication::Key => tr!("the provider does not accept a key (private_key_jwt with RS256)"),
            };
            return Err(Error::Unprocessable(why.to_owned()));
        }
        Err(DocumentError::Service(error)) => return Err(error),
        Err(DocumentError::Provider(SignInRefusal::Issuer, named)) => {
            return Err(Error::Unprocessable(tr!(
                "issuer: the provider calls itself “{named}”; enter exactly that",
                named = single_line_text::on_one_line(&named).chars().take(200).collect::<String>()
            )));
        }
        Err(DocumentError::Provider(_, why)) => {
            let why = tr!("the provider’s description cannot be read (technical reason, in English: {why})", why = why);
            return Err(Error::Unprocessable(why));
        }
    }
    if settings.authentication == ClientAuthentication::Key {
        // Creates the first key.
        client_keys::read_signing_key(service).await?;
    }
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    if !providers::put_provider(&mut tx, new, now).await? {
        let why = tr!("this school has a provider with the same issuer and client id");
        return Err(Error::Unprocessable(why.to_owned()));
    }
    AuditEntry::by(by, action, new.id)
        .with(json!({
            "issuer": settings.issuer,
            "authentication": settings.authentication.word(),
            "addresses_verified": settings.addresses_verified,
            "second_factor_trusted": settings.second_factor_trusted,
            "second_factor_acr": settings.second_factor_acr,
            "creates_trainees": settings.creates_trainees,
            "role_map": settings.role_map,
        }))
        .append(&mut tx, now)
        .await?;
    Ok(tx.commit().await?)
}

/// Disables a provider, or enables it again.
///
/// # Errors
/// Fails if there is no such provider, or the database fails.
pub async fn set_disabled(service: &Service, by: &CurrentPerson, id: ProviderId, disabled: bool) -> Result<(), Error> {
    let now = service.clock.now();
    providers::find_provider(service.db.reader(), by.school_id, id).await?.ok_or(Error::NotFound)?;
    let mut tx = service.db.write().await?;
    if providers::set_provider_disabled(&mut tx, by.school_id, id, disabled.then_some(now)).await? {
        let action = if disabled { "provider.disabled" } else { "provider.enabled" };
        AuditEntry::by(by, action, id).append(&mut tx, now).await?;
    }
    Ok(tx.commit().await?)
}

/// Sets who may sign in with a password of this service.
///
/// # Errors
/// Returns [`Error::Unprocessable`] if only administrators could sign in, because no provider
/// is enabled.
pub async fn set_local_passwords(service: &Service, by: &CurrentPerson, rule: LocalPasswords) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    let known = providers::list_providers(&mut *tx, by.school_id).await?;
    if rule == LocalPasswords::Administrators && known.iter().all(|provider| provider.disabled_at.is_some()) {
        let why = tr!("without an enabled provider only administrators could sign in: add one first");
        return Err(Error::Unprocessable(why.to_owned()));
    }
    providers::set_local_passwords(&mut tx, by.school_id, rule).await?;
    AuditEntry::by(by, "school.local_passwords_set", by.school_id)
        .with(json!({ "rule": rule.word() }))
        .append(&mut tx, service.clock.now())
        .await?;
    Ok(tx.commit().await?)
}
