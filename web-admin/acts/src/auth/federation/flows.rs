//! A sign-in at a provider: its beginning, and its end.

use std::net::IpAddr;

use model::auth::federation::{Claims, FlowPurpose, ProvenIdentity};
use model::auth::sign_in_refusal::SignInRefusal;
use model::ids::{PersonId, ProviderId};
use platform::openid::{AuthorizationRequest, FlowSecrets};
use platform::{sealing, secret};
use store::auth::federation::flows::SignInFlow;
use store::auth::federation::providers::SignInProvider;
use store::auth::federation::{flows, providers};
use store::auth::rate_limits;

use super::documents::{self, DocumentError};
use super::sources::{IdentitySource, refuse, refuse_by};
use super::tokens::IssuedCode;
use crate::error::Error;
use crate::service::Service;

/// Lifetime of a sign-in at a provider, in s.
const WAIT_S: i64 = 10 * 60;

/// Returns the address to which providers send their answers.
#[must_use]
pub fn redirect_uri(service: &Service) -> String {
    format!("{}/sign-in/callback", service.config.address())
}

/// A sign-in to begin.
#[derive(Clone, Copy, Debug)]
pub struct NewFlow<'a> {
    /// Token of the browser's cookie.
    pub browser_token: &'a str,
    /// Purpose.
    pub purpose: FlowPurpose,
    /// The signed-in person.
    pub person_id: Option<PersonId>,
    /// Path to open afterwards.
    pub next: &'a str,
}

/// Begins a sign-in and returns the address of the provider's page.
///
/// # Errors
/// Fails if the key file or the database fails. The inner error is a reason of the provider.
pub async fn begin_flow(
    service: &Service,
    provider: &SignInProvider,
    new: NewFlow<'_>,
) -> Result<Result<String, SignInRefusal>, Error> {
    if provider.disabled_at.is_some() && new.purpose != FlowPurpose::Try {
        return refuse(service, &provider.into(), SignInRefusal::Disabled).await;
    }
    let settings = &provider.settings;
    let discovery = match documents::read_discovery(service, provider.school_id, &settings.issuer, false).await {
        Ok(discovery) => discovery,
        Err(error) => return refuse_by(service, &provider.into(), error).await,
    };
    let secrets = FlowSecrets::random()?;
    let id = provider.id.uuid();
    let flow = SignInFlow {
        school_id: provider.school_id,
        provider_id: provider.id,
        browser_sha256: secret::token_sha256(new.browser_token).to_vec(),
        nonce_sha256: secret::token_sha256(&secrets.nonce).to_vec(),
        pkce_sealed: sealing::seal(&service.config.keys_dir, id.as_bytes(), secrets.code_verifier.as_bytes())?,
        purpose: new.purpose,
        person_id: new.person_id,
        next: new.next.to_owned(),
        expires_at: service.clock.now().plus_s(WAIT_S),
    };
    let mut tx = service.db.write().await?;
    flows::add_flow(&mut tx, &secret::token_sha256(&secrets.state), &flow, service.clock.now()).await?;
    tx.commit().await?;
    let request = AuthorizationRequest {
        client_id: &settings.client_id,
        redirect_uri: &redirect_uri(service),
        scopes: &settings.scopes,
        anew: matches!(new.purpose, FlowPurpose::Join | FlowPurpose::Prove),
    };
    Ok(Ok(request.address(&discovery, &secrets).to_string()))
}

/// A provider's answer, as the browser brings it.
#[derive(Clone, Copy, Debug)]
pub struct ProviderAnswer<'a> {
    /// The state of the sign-in.
    pub state: &'a str,
    /// The authorization code.
    pub code: Option<&'a str>,
    /// The issuer, if the provider names it.
    pub iss: Option<&'a str>,
    /// Error code of the provider.
    pub error: Option<&'a str>,
    /// Token of the browser's cookie, if it has one.
    pub browser_token: Option<&'a str>,
    /// Client address.
    pub from: IpAddr,
}

/// A sign-in that the provider has confirmed.
#[derive(Clone, Debug)]
pub struct FinishedFlow {
    /// The provider.
    pub provider: SignInProvider,
    /// Purpose.
    pub purpose: FlowPurpose,
    /// The person who was signed in when it was begun.
    pub person_id: Option<PersonId>,
    /// Path to open afterwards.
    pub next: String,
    /// Whom the provider has confirmed.
    pub identity: ProvenIdentity,
    /// All claims.
    pub claims: Claims,
}

/// Finishes a sign-in. The state is used up even by a refusal, which is in the audit log.
///
/// # Errors
/// Fails if the key file or the database fails. The inner error is the reason of a refusal.
pub async fn finish_flow(
    service: &Service,
    answer: ProviderAnswer<'_>,
) -> Result<Result<FinishedFlow, SignInRefusal>, Error> {
    if answer.state.is_empty() {
        return Ok(Err(SignInRefusal::NoFlow));
    }
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    let flow = flows::take_flow(&mut tx, &secret::token_sha256(answer.state)).await?;
    let browser = answer.browser_token.map(secret::token_sha256);
    let Some(flow) = flow else {
        // Anybody can send such an answer, so it is only counted.
        rate_limits::count_unknown_sign_in(&mut tx, now).await?;
        tx.commit().await?;
        tracing::warn!(from = %answer.from, "answer of a provider without its sign-in");
        return Ok(Err(SignInRefusal::NoFlow));
    };
    tx.commit().await?;
    let provider = providers::find_provider(service.db.reader(), flow.school_id, flow.provider_id).await?;
    let provider = provider.ok_or(Error::NotFound)?;
    let source = IdentitySource::from(&provider);
    if flow.expires_at <= now || browser.is_none_or(|own| own[..] != flow.browser_sha256) {
        return refuse(service, &source, SignInRefusal::NoFlow).await;
    }
    if provider.disabled_at.is_some() && flow.purpose != FlowPurpose::Try {
        return refuse(service, &source, SignInRefusal::Disabled).await;
    }
    match read_identity(service, &provider, &flow, answer).await {
        Ok((identity, claims)) => Ok(Ok(FinishedFlow {
            provider,
            purpose: flow.purpose,
            person_id: flow.person_id,
            next: flow.next,
            identity,
            claims,
        })),
        Err(error) => refuse_by(service, &source, error).await,
    }
}

async fn read_identity(
    service: &Service,
    provider: &SignInProvider,
    flow: &SignInFlow,
    answer: ProviderAnswer<'_>,
) -> Result<(ProvenIdentity, Claims), DocumentError> {
    let settings = &provider.settings;
    let discovery = documents::read_discovery(service, provider.school_id, &settings.issuer, false).await?;
    let is_named = answer.iss == Some(settings.issuer.as_str());
    let must_be_named = discovery.authorization_response_iss_parameter_supported;
    if !is_named && (must_be_named || answer.iss.is_some()) {
        return Err(documents::refuse(SignInRefusal::Issuer, "the answer names another issuer, or none"));
    }
    if let Some(error) = answer.error {
        return Err(documents::refuse(SignInRefusal::Denied, error.chars().take(40).collect::<String>()));
    }
    let Some(code) = answer.code else {
        return Err(documents::refuse(SignInRefusal::Malformed, "an answer without a code"));
    };
    let issued = IssuedCode { provider, discovery: &discovery, flow, code };
    let claims = issued.read_claims(service).await?;
    if flow.purpose == FlowPurpose::Prove && !claims.is_fresh(service.clock.now()) {
        return Err(documents::refuse(SignInRefusal::NotAnew, "auth_time is missing or too old"));
    }
    match ProvenIdentity::read(settings, &claims) {
        Some(identity) => Ok((identity, claims)),
        None => Err(documents::refuse(SignInRefusal::Subject, "the claim that identifies the person is missing")),
    }
}

/// Returns a provider of any school.
///
/// # Errors
/// Fails if there is no such provider, or the database fails.
pub async fn find_provider(service: &Service, id: ProviderId) -> Result<SignInProvider, Error> {
    providers::find_provider_of_any_school(service.db.reader(), id).await?.ok_or(Error::NotFound)
}
