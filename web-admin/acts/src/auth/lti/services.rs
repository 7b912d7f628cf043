//! Requests to the services of a learning platform, such as those for grades and for members (1EdTech
//! Security Framework 1.0, section 4).

use model::auth::lti::PlatformSettings;
use platform::openid::{ASSERTION_TYPE, TokenUse};
use platform::outgoing::{Answer, Call, CallFailed, Content};
use serde::Deserialize;
use store::auth::lti::platforms::Platform;

use crate::auth::federation::client_keys;
use crate::error::Error;
use crate::service::Service;

/// A request to a service of a learning platform.
#[derive(Clone, Debug)]
pub struct ServiceRequest<'a> {
    /// Scopes of the access token, separated by spaces.
    pub scopes: &'a str,
    /// Address, as the platform has sent it.
    pub address: &'a str,
    /// Media type of the answer.
    pub accept: &'static str,
    /// What to post; `None` for a GET request.
    pub content: Option<Content>,
    /// Maximum size of the answer, in bytes.
    pub largest_answer: u64,
}

/// Why a service of a learning platform has not answered.
#[derive(Debug, thiserror::Error)]
pub enum ServiceFailure {
    /// The platform is disabled.
    #[error("the learning platform is disabled")]
    Disabled,
    /// The request was not sent, or not answered.
    #[error(transparent)]
    Call(#[from] CallFailed),
    /// The platform has issued no access token: HTTP status, and the error code of OAuth 2.0.
    #[error("no access token: HTTP status {0} {1}")]
    Token(u16, String),
    /// An error of this service.
    #[error(transparent)]
    Service(Error),
}

impl<E: Into<Error>> From<E> for ServiceFailure {
    fn from(error: E) -> Self {
        Self::Service(error.into())
    }
}

/// Sends a request with an access token. If the platform refuses the token (401), sends it once more
/// with a new one. Other refusals are answers.
///
/// # Errors
/// Fails if there is no answer.
pub async fn send_request(
    service: &Service,
    platform: &Platform,
    request: &ServiceRequest<'_>,
) -> Result<Answer, ServiceFailure> {
    let token = fetch_token(service, platform, request.scopes, None).await?;
    let answer = send(service, platform, request, &token).await?;
    if answer.status != 401 {
        return Ok(answer);
    }
    let token = fetch_token(service, platform, request.scopes, Some(&token)).await?;
    send(service, platform, request, &token).await
}

async fn send(
    service: &Service,
    platform: &Platform,
    request: &ServiceRequest<'_>,
    token: &str,
) -> Result<Answer, ServiceFailure> {
    let url = service.outgoing.rules().check(request.address)?;
    service.outgoing.count_service_request(platform.school_id, &url)?;
    let authorization = Some(format!("Bearer {token}"));
    let (accept, content, largest_answer) = (request.accept, request.content.clone(), request.largest_answer);
    let call = Call { authorization, accept, content, largest_answer, ..Call::get(url) };
    let mut answer = service.outgoing.send(call).await?;
    // Answers to failed requests are stored and shown, and some repeat the request.
    if answer.body.windows(token.len().max(1)).any(|part| part == token.as_bytes()) {
        answer.body.clear();
    }
    Ok(answer)
}

/// Returns an access token other than the `refused` one: a kept one, or a new one for a signed
/// assertion.
///
/// # Errors
/// Fails if the platform is disabled or issues no token.
pub async fn fetch_token(
    service: &Service,
    platform: &Platform,
    scopes: &str,
    refused: Option<&str>,
) -> Result<String, ServiceFailure> {
    if platform.disabled_at.is_some() {
        return Err(ServiceFailure::Disabled);
    }
    let for_use = TokenUse { platform: platform.id, scopes: scopes.to_owned() };
    let turn = service.outgoing.document_turn(&platform.settings.token_url);
    let _turn = turn.lock().await;
    if let Some(token) = service.access_tokens.find(&for_use, refused, service.clock.now()) {
        return Ok(token);
    }
    let url = service.outgoing.rules().check(&platform.settings.token_url)?;
    service.outgoing.count_service_request(platform.school_id, &url)?;
    let form = make_form(service, &platform.settings, scopes).await?;
    let answer = service.outgoing.send(Call::post(url, Content::of_form(&form))).await?;
    if !(200..300).contains(&answer.status) {
        return Err(ServiceFailure::Token(answer.status, read_error_code(&answer.body)));
    }
    let kept = service.access_tokens.keep(for_use, &answer.body, service.clock.now());
    kept.map_err(|_| ServiceFailure::Token(answer.status, "malformed answer".to_owned()))
}

async fn make_form(
    service: &Service,
    settings: &PlatformSettings,
    scopes: &str,
) -> Result<[(&'static str, String); 4], Error> {
    let key = client_keys::read_signing_key(service).await?;
    let audience = settings.token_audience.as_ref().unwrap_or(&settings.token_url);
    let now_s = service.clock.now().micros().div_euclid(1_000_000);
    Ok([
        ("grant_type", "client_credentials".to_owned()),
        ("client_assertion_type", ASSERTION_TYPE.to_owned()),
        ("client_assertion", key.sign_assertion(&settings.client_id, audience, now_s)?),
        ("scope", scopes.to_owned()),
    ])
}

/// Returns the error code of a refusal (RFC 6749, section 5.2), or nothing: the body may contain more
/// than a code.
fn read_error_code(body: &[u8]) -> String {
    #[derive(Deserialize)]
    struct Refusal {
        error: String,
    }
    let read = serde_json::from_slice(body).map(|refusal: Refusal| refusal.error);
    let is_code = |code: &String| code.len() <= 60 && code.bytes().all(|b| b.is_ascii_lowercase() || b == b'_');
    read.ok().filter(is_code).unwrap_or_default()
}
